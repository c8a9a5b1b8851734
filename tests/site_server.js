// Serves what `make site` has made to a browser of a suite.
"use strict";

const fs = require("fs");
const http = require("http");
const path = require("path");

const TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".mjs": "text/javascript",
  ".json": "application/json", ".webmanifest": "application/manifest+json", ".png": "image/png", ".svg": "image/svg+xml",
  ".wasm": "application/wasm"};

// Serves a folder to this machine; resolves to the server.
function serve(folder) {
  const server = http.createServer((request, answer) => {
    const file = path.join(folder, path.normalize(decodeURIComponent(request.url.replace(/\?.*/, ""))));
    if (!file.startsWith(folder) || !fs.existsSync(file)) return answer.writeHead(404).end();
    answer.writeHead(200, {"Content-Type": TYPES[path.extname(file)] || "application/octet-stream"});
    return fs.createReadStream(file).pipe(answer);
  });
  return new Promise((resolve) => server.listen(0, "127.0.0.1", () => resolve(server)));
}

module.exports = {serve};
