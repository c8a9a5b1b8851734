// The pages that make book and make report have woven, as readers with weak eyes, no mouse or a phone need them. Speaks
// TAP, for make check-pages; runs in a build folder. Arguments: Chromium and axe-core ("" if missing). With RAYKIT_QUICK
// axe-core reads a third of the pages, in light colours.
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const vm = require("vm");
const {Browser, MOUSE} = require("./browser.js");
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

async function findings(browser, page, views) {
  await browser.open(`file://${path.resolve(page)}`, axe.read(script));
  await browser.until('document.readyState === "complete"');
  const found = await axe.findings(browser, views);
  await browser.close();
  return found;
}

function tell(good, number, what, said) {
  for (const line of good ? [] : said) console.log(`# ${line}`);
  console.log(`${good ? "ok" : "not ok"} ${number} - ${what}`);
  if (!good) process.exitCode = 1;
}

const FIRST = 8; // the number of the first page's claim
const isQuick = Boolean(process.env.RAYKIT_QUICK);
const read = isQuick ? pages.filter((page, i) => i % 3 === 0) : pages;

// Each browser takes the next page that none has taken; results are told in the pages' order.
async function read_pages(browsers) {
  const found = read.map(() => null);
  let next = 0, told = 0;
  await Promise.all(browsers.map(async (browser) => {
    while (next < read.length) {
      const mine = next++;
      found[mine] = await findings(browser, read[mine], isQuick ? axe.IN_LIGHT : undefined);
      for (; found[told]; told++) tell(!found[told].length, told + FIRST, `axe-core finds nothing in ${read[told]}`, found[told]);
    }
  }));
}

// A folder of pages with a search; undefined where they have been woven without.
const SEARCHED = pages.find((page) => fs.existsSync(`${path.dirname(page)}/search.js`));

async function look_up(browser, words) {
  await browser.value(`(() => { const field = document.querySelector(".search input"); field.focus(); field.value = ${JSON.stringify(words)}; field.dispatchEvent(new Event("input")); })()`);
  await browser.until("window.raykitFind && document.querySelector('.search .said').textContent");
  return browser.value(`({said: document.querySelector(".search .said").textContent, links: [...document.querySelectorAll("#found a")].map((link) => link.getAttribute("href")),
    excerpts: [...document.querySelectorAll("#found li")].map((item) => [...item.querySelectorAll("mark")].map((mark) => mark.textContent).join(" "))})`);
}

async function open_search(browser, page, before) {
  await browser.open(`file://${path.resolve(page)}`, before);
  await browser.until('document.readyState === "complete" && document.querySelector(".search input")');
}

// A phrase from the middle of a page is looked up on another one, by keys alone, from file://.
async function search_finds_the_text(browser, number) {
  const window = {};
  vm.runInNewContext(fs.readFileSync(`${path.dirname(SEARCHED)}/search.js`, "utf8"), {window});
  const long = window.raykitFind("the").filter(({text}) => text.length > 300);
  const {at, name, text} = long.find((one) => window.raykitSections[one.at][0] !== path.basename(SEARCHED)) || long[0]; // all may be on one page
  const [page] = window.raykitSections[at], place = `${page === path.basename(SEARCHED) ? "" : page}#${name}`, phrase = text.match(/[\p{L}]{4,}/gu).slice(3, 8).join(" ");
  await open_search(browser, SEARCHED);
  const {said, links, excerpts} = await look_up(browser, phrase), found = links.indexOf(place);
  tell(found >= 0 && phrase.split(" ").some((word) => excerpts[found].includes(word)) && /^\d+( of \d+)? places?$/.test(said), number,
    `a paragraph of ${place} is found from ${SEARCHED}, with words around the hit`, [phrase, said, ...links, ...excerpts]);
  for (let at = 0; at <= found; at++) await browser.key("ArrowDown");
  await browser.key("Enter");
  const there = found >= 0 && await browser.until(`location.href.endsWith(${JSON.stringify(place)}) && document.getElementById(${JSON.stringify(name)})`);
  tell(there, number + 1, "the arrow keys and Enter lead to it", [await browser.value("location.href")]);
  await browser.close();
}

// Of a word, its beginning and one with a letter that lacks are looked up.
async function search_forgives(browser, number) {
  await open_search(browser, SEARCHED);
  const missed = [];
  for (const words of ["triangl", "tirangle", "trangle"]) {
    const {links, excerpts, said} = await look_up(browser, words);
    if (!links.length || !excerpts.some((marked) => /triangle/i.test(marked))) missed.push(`${words}: ${said}: ${excerpts}`);
  }
  const none = await look_up(browser, "qqxyzzyqq");
  if (none.links.length || none.said !== "nothing found") missed.push(`nonsense: ${none.said}`);
  await browser.key("Escape");
  const left = await browser.value('[document.querySelector(".search input").value, document.getElementById("found").hidden].join()');
  if (left !== ",true") missed.push(`Escape leaves ${left}`);
  tell(!missed.length, number, "a beginning finds, and a word with a wrong letter, and Escape ends the search", missed);
  await browser.close();
}

async function search_is_for_all_readers(browser, number) {
  await open_search(browser, SEARCHED, axe.read(script));
  await look_up(browser, "triangl");
  const found = await axe.findings(browser, isQuick ? axe.IN_LIGHT : undefined);
  tell(!found.length, number, "axe-core finds nothing in a page that shows what was found", found);
  await browser.close();
}

// What a page loads, by what it is for.
const NEEDS = {"formulas.css": /class="katex|<tspan font-/, "compare.js": /class="(\w+ )*compare\b/, "live.js": /data-program="/,
  "steps.js": /class="replay"/};

// Fonts are in files of their own, which a browser loads for the letters that it meets.
function pages_load_what_they_use(number) {
  const wrong = [], room = (page) => path.dirname(page);
  for (const page of pages.filter((one) => !one.includes("/source/"))) {
    const text = fs.readFileSync(page, "utf8");
    for (const [name, used] of Object.entries(NEEDS)) {
      const is_loaded = new RegExp(`(src|href)="${name}"`).test(text), is_needed = used.test(text) && fs.existsSync(`${room(page)}/${name}`);
      if (is_loaded !== is_needed) wrong.push(`${page}: ${name} is ${is_loaded ? "loaded and not needed" : "needed and not loaded"}`);
    }
  }
  for (const sheet of new Set(pages.map((page) => `${room(page)}/style.css`).filter(fs.existsSync)))
    if (/@font-face|data:font/.test(fs.readFileSync(sheet, "utf8"))) wrong.push(`${sheet}: it has fonts, and all pages load it`);
  tell(!wrong.length, number, "a page loads the scripts and fonts that it uses, and no others", wrong);
}

// What has a number or a name, of which a reader may want to send the address.
const ADDRESSED = "main :is(figure, .listing, .equation)[id]";

// The address of each of these is behind a sign, which shows on pointing at the whole or by the keyboard, and moves nothing.
async function blocks_have_permalinks(browser, number) {
  const missed = [];
  for (const page of pages.filter((one) => !one.includes("/source/"))) {
    await browser.open(`file://${path.resolve(page)}`);
    await browser.until('document.querySelector(".search input")');
    await browser.value('document.querySelectorAll("details").forEach((fold) => { fold.open = true; })');
    missed.push(...await browser.value(`[...document.querySelectorAll(${JSON.stringify(ADDRESSED)})].flatMap((block) => {
      const link = block.querySelector(".permalink"), seen = () => getComputedStyle(link).opacity;
      if (!link || link.getAttribute("href") !== "#" + block.id) return [block.id + ": no link to itself"];
      const hidden = seen(), {height} = block.getBoundingClientRect();
      link.focus();
      const said = hidden === "0" && seen() === "1" ? "" : "its sign is not shown for the keyboard alone";
      return said || block.getBoundingClientRect().height !== height ? [block.id + ": " + (said || "it grows")] : [];
    }).map((said) => ${JSON.stringify(page)} + "#" + said)`));
    missed.push(...await pointed_at(browser, page));
    await browser.close();
  }
  tell(!missed.length, number, "each figure, formula and listing has a link to itself", missed);
}

// The first of each kind, whose corner is farthest from the sign.
async function pointed_at(browser, page) {
  const missed = [];
  for (const kind of ["figure", ".listing", ".equation"]) {
    const place = await browser.value(`(() => {
      document.activeElement.blur();
      window.block = document.querySelector("main ${kind}[id]");
      if (!block || !block.checkVisibility()) return null;
      block.scrollIntoView();
      const {left, top} = block.getBoundingClientRect();
      return [left + 3, top + 3];
    })()`);
    if (!place) continue;
    await browser.mouse("mouseMoved", ...place);
    const shown = await browser.value('[...block.querySelectorAll(".permalink")].map((link) => getComputedStyle(link).opacity).join()');
    if (shown !== "1") missed.push(`${page}: the sign of the first ${kind} is not shown where the mouse is`);
  }
  return missed;
}

async function main() {
  const missing = !chromium ? "Chromium is missing: ./bootstrap --pdf" : !pages.length ? "there are none: make book, make report" : "";
  if (missing) return console.log(`ok 1 - pages # SKIP ${missing}\n1..1`);
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-pages-"));
  const count = Math.min(os.cpus().length, 4, pages.length);
  const browsers = Array.from({length: count}, (_, i) => new Browser(chromium, path.join(folder, String(i))));
  const desk = new Browser(chromium, path.join(folder, "desk"), [MOUSE]);
  try {
    const skip = (number) => console.log(`ok ${number} - search # SKIP pages are woven without it: ./bootstrap --site`);
    if (SEARCHED) await search_finds_the_text(browsers[0], 1); else [1, 2].forEach(skip);
    if (SEARCHED) await search_forgives(browsers[0], 3); else skip(3);
    await blocks_have_permalinks(desk, 4);
    pages_load_what_they_use(5);
    if (!script) return console.log("ok 6 - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live\n1..6");
    if (SEARCHED) await search_is_for_all_readers(browsers[0], 6); else skip(6);
    const planted = await findings(browsers[0], path.join(__dirname, "planted_page.html"));
    const missed = PLANTED.filter((mistake) => !planted.some((line) => mistake.test(line)));
    tell(!missed.length, FIRST - 1, "mistakes of each kind, each in some views only, are found", [...missed.map((mistake) => `not found: ${mistake}`), ...planted]);
    await read_pages(browsers);
    console.log(`1..${read.length + FIRST - 1}`);
  } finally {
    await Promise.all([...browsers, desk].map((browser) => browser.quit()));
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

main();
