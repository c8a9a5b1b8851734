// Serves what `make site` has made to a browser of a suite.
"use strict";

const fs = require("fs");
const http = require("http");
const path = require("path");

const TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".mjs": "text/javascript",
  ".json": "application/json", ".webmanifest": "application/manifest+json", ".png": "image/png", ".svg": "image/svg+xml",
  ".wasm": "application/wasm"};

// Serves a folder to this machine; resolves to the server. changed: texts in the place of files.
function serve(folder, {port = 0, changed = {}} = {}) {
  const server = http.createServer((request, answer) => {
    const file = path.join(folder, path.normalize(decodeURIComponent(request.url.replace(/\?.*/, ""))));
    if (!file.startsWith(folder) || !fs.existsSync(file)) return answer.writeHead(404).end();
    const type = TYPES[path.extname(file)] || "application/octet-stream";
    const seconds = type === "text/html" ? 600 : 0; // for which pages may be kept, as on GitHub Pages
    answer.writeHead(200, {"Content-Type": type, "Cache-Control": `max-age=${seconds}`});
    const text = changed[path.relative(folder, file)];
    if (text !== undefined) return answer.end(text);
    return fs.createReadStream(file).pipe(answer);
  });
  return new Promise((resolve) => server.listen(port, "127.0.0.1", () => resolve(server)));
}

module.exports = {serve};
