// What axe-core finds on a quick book and report of one feature, and on the page of the live loop, in test_live.js's browser.
"use strict";

const {execFileSync} = require("child_process");
const fs = require("fs");
const axe = require("./axe.js");

const FEATURE = "bloom"; // its chapter has a live figure, a comparison, a table, a plot, formulas, steps and mistakes

const PARTS = [".live .story:not([hidden]) .now", ".comparison", ".wide", ".formula", ".thumbnail", ".claim[open]", "nav details[open]"];

module.exports = ({check, browser, source, folder, script}) => {
  const before = axe.read(script);

  async function lint(what) {
    const found = await axe.findings(browser);
    check(found.length === 0, `axe-core finds nothing on ${what}`, found.join("\n"));
  }

  async function open(page) {
    await browser.open(`file://${folder}/${page}`, before);
    await browser.until('document.readyState === "complete"');
  }

  // The environment is that of make book.
  function weave(maker) {
    execFileSync("sh", [`${source}/${maker}`], {stdio: ["ignore", "ignore", "pipe"], env: {...process.env, RAYKIT_BUILD: folder,
      RAYKIT_RECORD: "", RAYKIT_JUDGES: "no", RAYKIT_COMPILER: "the compiler", RAYKIT_FLAGS: "-O2", QUICK: "1", FEATURES: FEATURE, CHROMIUM: ""}});
  }

  // On the page that is open, and spoilt by it.
  async function mistakes_are_found() {
    await browser.value(`(() => {
      const text = document.querySelector("#text");
      text.querySelector(".caption").style.color = "#999";
      text.querySelector("img").removeAttribute("alt");
      text.querySelector("p").style.width = "600px";
    })()`);
    const found = await axe.findings(browser), said = found.join("\n");
    check(/^color-contrast .* at #\S+ > figcaption, at 1280 px, light and 390 px, light: .*#999999.*https:/m.test(said),
      "pale words are told with rule, place, views and remedy", said);
    check(/^image-alt .* 1280 px, light:/m.test(said), "a picture without a text is told", said);
    check(/^the page is wider .* 390 px/m.test(said), "and a page that is too wide for a phone", said);
  }

  async function woven_pages() {
    weave("docs/make_book");
    const pages = fs.readdirSync(`${folder}/docs/out.some/book`).filter((name) => name.endsWith(".html"));
    let unseen = PARTS;
    for (const page of pages) {
      await open(`docs/out.some/book/${page}`);
      await lint(`a page of a chapter, ${page}`);
      unseen = await browser.value(`${JSON.stringify(unseen)}.filter((part) => !document.querySelector(part))`);
      await browser.close();
    }
    check(!unseen.length, "and has seen a live figure with an explained pixel, a comparison, tables, formulas, thumbnails and claims", unseen.join());
    const text_of = (page) => fs.readFileSync(`${folder}/docs/out.some/book/${page}`, "utf8");
    const [begin] = pages.filter((page) => /^(?:(?!class="caption")[^])*<img (?:(?!class="caption")[^])*<figcaption class="caption"/.test(text_of(page)));
    await open(`docs/out.some/book/${begin}`);
    await mistakes_are_found();
    await browser.close();
    await open("docs/out.some/book.html");
    await lint("the book in a single file");
    await browser.close();
    weave("reports/make_report");
    await open("reports/out.some/report/index.html");
    await lint("a section of the report");
    await browser.close();
  }

  return {before, lint, woven_pages};
};
