// The workbench in a browser: what is typed into it is compiled there, and its claims say what the native suite says.
// Speaks TAP, for make check-site; runs in a build folder that has site/. Arguments: the source folder, Chromium,
// and what make site has made ("" if missing).
"use strict";

const fs = require("fs");
const http = require("http");
const os = require("os");
const path = require("path");
const {Browser} = require("./browser.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, chromium, made] = process.argv.slice(2);
const TYPES = {".html": "text/html", ".mjs": "text/javascript", ".json": "application/json", ".wasm": "application/wasm"};
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

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

// Replaces the text as typing does, and waits for the verdict. Returns {state, claims: {NAME: verdict and message}, said,
// seconds}.
async function type(browser, text) {
  await browser.value(`(() => {
    const area = document.getElementById("text");
    document.getElementById("state").textContent = "Typed";
    area.focus();
    area.select();
  })()`);
  await browser.send("Input.insertText", {text});
  await browser.until(`/claims hold|finds an error|does not go on/.test(document.getElementById("state").textContent)`);
  return JSON.parse(await browser.value(`JSON.stringify({
    state: document.getElementById("state").textContent, said: document.getElementById("said").textContent,
    seconds: document.getElementById("seconds").textContent,
    claims: Object.fromEntries([...document.getElementById("claims").children].map((item) =>
      [item.id, item.dataset.verdict + ": " + (item.querySelector("small") || {}).textContent]))})`));
}

async function workbench(browser, address, stem) {
  const begun = Date.now(), reference = fs.readFileSync(`${source}/src/features/${stem}.c`, "utf8");
  await browser.open(`${address}/workbench.html?${stem}`);
  await browser.until(`/claims hold|does not go on/.test(document.getElementById("state").textContent)`);
  const starter = await browser.value(`document.getElementById("state").textContent`);
  check(/^\d+ of \d+ claims hold$/.test(starter), `${stem}: the page begins with the starter's verdict`, starter);
  console.log(`# ${stem}: ${((Date.now() - begun) / 1000).toFixed(1)} s to the starter's verdict`);
  for (let time = 0; time < 3; time++) {
    const typed = await type(browser, `${reference}\n// ${time}\n`);
    const [, passed, all] = typed.state.match(/^(\d+) of (\d+)/) || [];
    if (time === 0) check(passed === all && Number(all) > 0, `${stem}: the reference, typed, passes all claims`, JSON.stringify(typed, null, 1));
    console.log(`# ${stem}: ${typed.seconds}`);
  }
}

async function mistakes(browser) {
  const text = fs.readFileSync(`${source}/src/features/normals.c`, "utf8");
  const halved = await type(browser, text.replace("0.5f + 0.5f * n.x, 0.5f + 0.5f * n.y", "1 + n.x, 1 + n.y"));
  check(/failed: got .*test_normals\.c:\d+/s.test(halved.claims.each_axis_has_a_colour_of_its_own),
    "a mistake is told by the claim's message", JSON.stringify(halved, null, 1));
  const broken = await type(browser, text.replace("return rk_vec(0.5f", "retrun rk_vec(0.5f"));
  check(/normals\.c:\d+:\d+: error/.test(broken.said), "a compiler's error names the line", JSON.stringify(broken, null, 1));
  const wild = await type(browser, text.replace("return rk_normalize(", "float two[2] = {a.x, b.x};\n    int many = 0x7fffffff + (int)(a.x > -1e30f);\n    if (two[many & 1] > 1e30f) return a;\n    return rk_normalize("));
  check(/fault: the sum of two integers is beyond their type's range \(normals\.c:\d+\)/.test(Object.values(wild.claims).join("\n")),
    "undefined behaviour is told with its kind and line", JSON.stringify(wild, null, 1));
}

async function main() {
  if (!chromium || !made) {
    console.log(`1..0 # SKIP ${chromium ? "@yowasp/clang is missing: ./bootstrap --site" : "Chromium is missing: ./bootstrap --pdf"}`);
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-site-"));
  const server = await serve(path.resolve("site")), browser = new Browser(chromium, folder);
  try {
    const address = `http://127.0.0.1:${server.address().port}`;
    await workbench(browser, address, "normals");
    await mistakes(browser);
    await workbench(browser, address, "bvh_median");
  } finally {
    await browser.quit();
    server.close();
    fs.rmSync(folder, {recursive: true, force: true});
  }
  console.log(`1..${count}`);
  process.exitCode = failed ? 1 : 0;
}

main();
