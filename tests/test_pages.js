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

// What is wrong on the planted page, as it must be told: rule, place and views.
const PLANTED = [
  /^image-alt .* at #mute, at 1280 px, light:/, /^image-alt .* at #mute-on-a-phone, at 390 px, light:/,
  /^color-contrast .* at #pale, at 1280 px, dark:/, /^link-in-text-block .* at #plain > a.*, at 1280 px, dark and 390 px, dark:/,
  /^scrollable-region-focusable .* at #stuck, at 390 px/, /^target-size .* at #small, at 390 px/,
  /^the page is wider than its window, at 390 px, light and 390 px, dark:/,
];

async function findings(browser, page) {
  await browser.open(`file://${path.resolve(page)}`, axe.read(script));
  await browser.until('document.readyState === "complete"');
  const found = await axe.findings(browser);
  await browser.close();
  return found;
}

function tell(good, number, what, said) {
  for (const line of good ? [] : said) console.log(`# ${line}`);
  console.log(`${good ? "ok" : "not ok"} ${number} - ${what}`);
  if (!good) process.exitCode = 1;
}

// Each browser takes the next page that none has taken; results are told in the pages' order.
async function read_pages(browsers) {
  const found = pages.map(() => null);
  let next = 0, told = 0;
  await Promise.all(browsers.map(async (browser) => {
    while (next < pages.length) {
      const mine = next++;
      found[mine] = await findings(browser, pages[mine]);
      for (; found[told]; told++) tell(!found[told].length, told + 2, `axe-core finds nothing in ${pages[told]}`, found[told]);
    }
  }));
}

async function main() {
  const missing = !chromium ? "Chromium is missing: ./bootstrap --pdf" : !script ? "axe-core is missing: ./bootstrap --live"
    : !pages.length ? "there are none: make book, make report" : "";
  if (missing) return console.log(`ok 1 - pages # SKIP ${missing}\n1..1`);
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-pages-"));
  const count = Math.min(os.cpus().length, 4, pages.length);
  const browsers = Array.from({length: count}, (_, i) => new Browser(chromium, path.join(folder, String(i))));
  try {
    const planted = await findings(browsers[0], path.join(__dirname, "planted_page.html"));
    const missed = PLANTED.filter((mistake) => !planted.some((line) => mistake.test(line)));
    tell(!missed.length, 1, "mistakes of each kind, each in some views only, are found", [...missed.map((mistake) => `not found: ${mistake}`), ...planted]);
    await read_pages(browsers);
    console.log(`1..${pages.length + 1}`);
  } finally {
    await Promise.all(browsers.map((browser) => browser.quit()));
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

main();
