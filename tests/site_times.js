// How long the workbench takes, in both browsers: prints docs/tools.md with its table of times made anew, for make
// site-times; runs in a build folder that has site/. Arguments: the source folder, docs/tools.md, Chromium, Firefox. Nothing
// else should run.
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const {execFileSync} = require("child_process");
const {Browser} = require("./browser.js");
const {Firefox} = require("./firefox.js");
const {serve} = require("./site_server.js");

const [source, page, chromium, firefox] = process.argv.slice(2);
const STEMS = ["normals", "bvh_median"];
const RUNS = 5;
const READING = 5000; // milliseconds between a picture and the next text, in which a page builds the last text again
const TABLE = /(<!-- times of a site -->\n)([^]*?)(<!-- end -->\n)/;

const median = (numbers) => [...numbers].sort((a, b) => a - b)[numbers.length >> 1];

// When the page first says that claims hold, when their picture stands there, and when the compiler is loaded, in ms since
// the text was typed; or since the page began, if none was.
const WATCH = `(() => {
  window.since = 0;
  window.said = {};
  const note = (name, is_there) => { if (is_there && !window.said[name]) window.said[name] = performance.now() - window.since; };
  const look = () => {
    const state = document.getElementById("state"), drawn = document.getElementById("drawn");
    note("verdict", state && /claims hold/.test(state.textContent));
    note("picture", window.said.verdict && drawn && drawn.textContent !== "");
    note("compiler", document.getElementById("loaded")?.hidden);
  };
  new MutationObserver(look).observe(document, {subtree: true, childList: true, characterData: true, attributes: true});
  look();
})()`;

async function visited(browser, address) {
  await browser.open(address, WATCH);
  if (browser instanceof Firefox) await browser.value(WATCH); // where nothing can be run before a page
  await browser.until("window.said && window.said.picture && window.said.compiler");
  return JSON.parse(await browser.value("JSON.stringify([window.said.verdict / 1000, window.said.compiler / 1000])"));
}

// text: one key, after which the page checks all that was typed.
async function typed(browser, text) {
  await browser.value(`(() => {
    document.getElementById("state").textContent = "Typed";
    document.getElementById("drawn").textContent = "";
    window.said = {};
    window.since = performance.now();
  })()`);
  await browser.insert(text);
  await browser.until("window.said.picture");
  return JSON.parse(await browser.value(`JSON.stringify([window.said.verdict / 1000, window.said.picture / 1000])`));
}

const read = () => new Promise((resolve) => setTimeout(resolve, READING));

// Returns {first, later, compiler, verdict, picture} in seconds: a first visit in a new browser, and medians.
async function times_of(Kind, program, stem, root) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-times-"));
  const browser = new Kind(program, folder), address = `${root}/workbench.html?${stem}`;
  try {
    const [first] = await visited(browser, address);
    await browser.until(`navigator.serviceWorker.controller && navigator.serviceWorker.controller.state === "activated"`);
    const later = [], compilers = [], verdicts = [], pictures = [];
    for (let run = 0; run < RUNS; run++) {
      const [verdict, compiler] = await visited(browser, address);
      later.push(verdict);
      compilers.push(compiler);
    }
    const reference = fs.readFileSync(`${source}/src/features/${stem}.c`, "utf8");
    await browser.value(`document.querySelector("#text .cm-content").focus()`);
    await browser.press("a");
    await typed(browser, reference);
    await read();
    for (let run = 0; run < RUNS; run++) {
      const [verdict, picture] = await typed(browser, "\n");
      verdicts.push(verdict);
      pictures.push(picture);
      await read();
    }
    return {first, later: median(later), compiler: median(compilers), verdict: median(verdicts), picture: median(pictures)};
  } finally {
    await browser.quit();
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

const version = (program) => execFileSync(program, ["--version"], {encoding: "utf8"}).match(/\d+/);

async function main() {
  const server = await serve(path.resolve("site")), root = `http://127.0.0.1:${server.address().port}`, rows = [];
  const kinds = [[Browser, chromium], [Firefox, firefox]].filter(([, program]) => program);
  const names = kinds.map(([kind, program]) => `${kind === Firefox ? "Firefox" : "Chromium"} ${version(program)}`);
  for (const stem of STEMS) {
    for (const [i, [kind, program]] of kinds.entries()) {
      const {first, later, compiler, verdict, picture} = await times_of(kind, program, stem, root);
      rows.push(`| \`${stem}\` | ${names[i]} | ${[first, later, compiler, verdict, picture].map((seconds) => seconds.toFixed(1)).join(" | ")} |\n`);
      console.error(rows[rows.length - 1].trim());
    }
  }
  server.close();
  server.closeAllConnections();
  const [{model}] = os.cpus(), table = `Seconds on ${os.cpus().length} processors (${model}), from a server on the same machine; but for the first visit, medians of ${RUNS}:\n\n` +
    `| assignment | browser | first visit | later visits | compiler | verdict | picture |\n|---|---|--:|--:|--:|--:|--:|\n${rows.join("")}`;
  process.stdout.write(fs.readFileSync(page, "utf8").replace(TABLE, (all, begin, old, end) => begin + table + end));
}

main();
