// The pages that make book and make report have woven, as readers with weak eyes, no mouse or a phone need them. Speaks
// TAP, for make check-pages; runs in a build folder. Arguments: Chromium and axe-core ("" if missing).
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const vm = require("vm");
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

const FIRST = 5; // the number of the first page's claim

// Each browser takes the next page that none has taken; results are told in the pages' order.
async function read_pages(browsers) {
  const found = pages.map(() => null);
  let next = 0, told = 0;
  await Promise.all(browsers.map(async (browser) => {
    while (next < pages.length) {
      const mine = next++;
      found[mine] = await findings(browser, pages[mine]);
      for (; found[told]; told++) tell(!found[told].length, told + FIRST, `axe-core finds nothing in ${pages[told]}`, found[told]);
    }
  }));
}

// A phrase from the middle of a page is looked up on another one, by keys alone, from file://.
async function search_finds_the_text(browser, number) {
  const [page] = pages, folder = path.dirname(page), window = {};
  vm.runInNewContext(fs.readFileSync(`${folder}/text.js`, "utf8"), {window});
  const [to, name, title, text] = window.raykitText.filter((row) => row[3].length > 300).pop();
  const phrase = text.split(" ").slice(20, 25).join(" ");
  await browser.open(`file://${path.resolve(page)}`);
  await browser.until('document.querySelector(".search input")');
  await browser.value('document.querySelector(".search input").focus()');
  await browser.until("window.raykitText");
  await browser.value(`(() => { const field = document.activeElement; field.value = ${JSON.stringify(phrase)}; field.dispatchEvent(new Event("input")); })()`);
  const {shown, marked, said} = await browser.value(`({shown: [...document.querySelectorAll("#found a")].map((link) => link.textContent),
    marked: [...document.querySelectorAll("#found mark")].map((mark) => mark.textContent), said: document.querySelector(".search .said").textContent})`);
  tell(shown.includes(title) && marked.includes(phrase) && /\d sections/.test(said), number, `a phrase of ${to} is found from ${page}`, [phrase, shown, marked, said].map(String));
  for (let at = 0; at <= shown.indexOf(title); at++) await browser.key("ArrowDown");
  await browser.value("document.activeElement.click()"); // as the Enter key does
  const there = shown.includes(title) && await browser.until(`location.href.endsWith(${JSON.stringify(`${to}#${name}`)})`);
  tell(there, number + 1, "the arrow keys lead to it", [await browser.value("location.href")]);
  await browser.close();
}

// Each figure and each formula has a link to itself.
async function figures_have_permalinks(browser, number) {
  const missed = [];
  for (const page of pages.filter((one) => !one.includes("/source/"))) {
    await browser.open(`file://${path.resolve(page)}`);
    await browser.until('document.querySelector(".search input")');
    missed.push(...await browser.value(`[...document.querySelectorAll("main figure[id], main .equation[id]")]
      .filter((one) => !one.querySelector('a[href="#' + one.id + '"]')).map((one) => ${JSON.stringify(page)} + "#" + one.id)`));
    await browser.close();
  }
  tell(!missed.length, number, "each figure and each formula has a link to itself", missed);
}

async function main() {
  const missing = !chromium ? "Chromium is missing: ./bootstrap --pdf" : !pages.length ? "there are none: make book, make report" : "";
  if (missing) return console.log(`ok 1 - pages # SKIP ${missing}\n1..1`);
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-pages-"));
  const count = Math.min(os.cpus().length, 4, pages.length);
  const browsers = Array.from({length: count}, (_, i) => new Browser(chromium, path.join(folder, String(i))));
  try {
    await search_finds_the_text(browsers[0], 1);
    await figures_have_permalinks(browsers[0], 3);
    if (!script) return console.log("ok 4 - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live\n1..4");
    const planted = await findings(browsers[0], path.join(__dirname, "planted_page.html"));
    const missed = PLANTED.filter((mistake) => !planted.some((line) => mistake.test(line)));
    tell(!missed.length, FIRST - 1, "mistakes of each kind, each in some views only, are found", [...missed.map((mistake) => `not found: ${mistake}`), ...planted]);
    await read_pages(browsers);
    console.log(`1..${pages.length + FIRST - 1}`);
  } finally {
    await Promise.all(browsers.map((browser) => browser.quit()));
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

main();
