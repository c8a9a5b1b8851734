// The pages that make book and make report have woven, as readers with weak eyes, no mouse or a phone need them. Speaks
// TAP, for make check-pages; runs in a build folder. Arguments: Chromium and axe-core ("" if missing).
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const {Browser} = require("./browser.js");
const axe = require("./axe.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [chromium, script] = process.argv.slice(2);
// The single files have the same, and would take many minutes. Of the sources' pages, which are all alike, one.
const pagesIn = (folder) => !fs.existsSync(folder) ? [] :
  fs.readdirSync(folder).filter((name) => name.endsWith(".html")).sort().map((name) => `${folder}/${name}`);
const pages = ["docs", "reports"].flatMap((texts) => ["out", "out.some", "out.answers", "out.some.answers"].flatMap((out) =>
  [...pagesIn(`${texts}/${out}/${texts === "docs" ? "book" : "report"}`), ...pagesIn(`${texts}/${out}/source`).slice(0, 1)]))
  .filter((page) => page.includes(process.env.RAYKIT_TEST_PAGES || ""));

async function main() {
  const missing = !chromium ? "Chromium is missing: ./bootstrap --pdf" : !script ? "axe-core is missing: ./bootstrap --live"
    : !pages.length ? "there are none: make book, make report" : "";
  if (missing) return console.log(`ok 1 - pages # SKIP ${missing}\n1..1`);
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-pages-")), browser = new Browser(chromium, folder);
  try {
    let count = 0;
    for (const page of pages) {
      await browser.open(`file://${path.resolve(page)}`, axe.read(script));
      await browser.until('document.readyState === "complete"');
      const found = await axe.findings(browser);
      for (const line of found) console.log(`# ${line}`);
      console.log(`${found.length ? "not ok" : "ok"} ${++count} - axe-core finds nothing in ${page}`);
      if (found.length) process.exitCode = 1;
      await browser.close();
    }
    console.log(`1..${count}`);
  } finally {
    await browser.quit();
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

main();
