// What axe-core (Deque's checker of web pages against the WCAG) finds on a page: in light and dark colours, on a
// phone and on a desk, with all that folds unfolded. And whether the page is wider than the window.
"use strict";

const fs = require("fs");

// WCAG 2.1 at levels A and AA, axe-core's best practices, and from WCAG 2.2 the size of targets, which axe-core
// leaves out unless asked.
const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"];

// All rules run on the desk. Elsewhere those do whose verdict depends on the place or the colours of what is seen; the
// others read the document, and would say the same of the same elements.
const COLOURS = ["color-contrast", "link-in-text-block"];
const VIEWS = [
  {width: 1280, scheme: "light"},
  {width: 1280, scheme: "dark", rules: COLOURS},
  {width: 390, scheme: "light", rules: [...COLOURS, "target-size", "scrollable-region-focusable"]},
  {width: 390, scheme: "dark", rules: COLOURS},
];

const options = (rules) => ({
  runOnly: rules || TAGS,
  rules: rules ? {} : {"target-size": {enabled: true}},
  resultTypes: ["violations"],
  preload: false, // what style sheets and films hold, which none of these rules reads
});

// What comes and goes: a live figure is drawn when the reader is near, and a click explains a pixel. Where the first one
// isn't drawn, the book has been woven without them.
const EXPLAIN = `(async () => {
  const wait = async (condition) => {
    for (let tick = 0; tick < 6000 && !condition(); tick++) await new Promise((resolve) => setTimeout(resolve, 20));
    return condition();
  };
  for (const live of document.querySelectorAll(".live")) {
    live.scrollIntoView();
    if (!await wait(() => live.dataset.drawn)) break;
    await wait(() => !live.querySelector('[role="slider"]:not([aria-valuenow])')); // a widget has answered
    if (live.dataset.click) continue;
    const canvas = live.querySelector("canvas"), {left, top, width, height} = canvas.getBoundingClientRect();
    const at = {pointerId: 1, bubbles: true, buttons: 1, clientX: left + width / 2, clientY: top + height / 2};
    for (const type of ["pointerdown", "pointerup", "click"]) canvas.dispatchEvent(new PointerEvent(type, at));
    await wait(() => live.dataset.explained);
  }
  scrollTo(0, 0);
})()`;

// Colours cost most of the time. Marks the elements that need no look at theirs: those without words of their own; and,
// after the first view, those in the same block and with the same colours and letters as another one.
const MARK = `(seen, isFirst) => {
  axe.configure({rules: [{id: "color-contrast", selector: "*:not([data-alike])"}]});
  const grounds = new Map(), looks = new Set(), blocks = new Map(), alike = new Set();
  for (const element of seen) {
    const {color, backgroundColor, backgroundImage, opacity, fontSize, fontWeight, textShadow} = getComputedStyle(element);
    const ground = backgroundColor === "rgba(0, 0, 0, 0)" && backgroundImage === "none" && opacity === "1"
      ? grounds.get(element.parentElement) : [grounds.get(element.parentElement), backgroundColor, backgroundImage, opacity].join();
    grounds.set(element, ground);
    const hasWords = [...element.childNodes].some((node) => node.nodeType === 3 && node.data.trim()) || element.matches("input, select, textarea, button");
    const block = element.closest("pre, table, p, li, svg, figcaption, .katex") || element;
    if (!blocks.has(block)) blocks.set(block, blocks.size);
    const look = [blocks.get(block), color, ground, fontSize, fontWeight, textShadow].join();
    if (!hasWords || (!isFirst && looks.has(look))) alike.add(element);
    else looks.add(look);
  }
  for (const element of seen) element.toggleAttribute("data-alike", alike.has(element)); // apart: styles are not computed anew for each
}`;

// All rules, too, on what this view shows and no view before.
const run = (rules) => `(async () => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  document.querySelectorAll("details").forEach((details) => { details.open = true; });
  const seen = [...document.querySelectorAll("body *")].filter((element) => element.checkVisibility({visibilityProperty: true}));
  const before = window.seenBefore = ${rules ? "window.seenBefore" : "new Set()"};
  const added = seen.filter((element) => !before.has(element)), isFirst = before.size === 0;
  added.forEach((element) => before.add(element));
  (${MARK})(seen, isFirst);
  const {violations} = await axe.run(document, ${JSON.stringify(options(rules))});
  const include = added.filter((element) => element.isConnected); // a widget may have drawn anew
  if (!isFirst && include.length) violations.push(...(await axe.run({include}, ${JSON.stringify(options())})).violations);
  return {violations, breadth: document.documentElement.scrollWidth};
})()`;

const IN_LIGHT = VIEWS.filter(({scheme}) => scheme === "light");

// A line for each rule broken at a place of the page, which must be open in the browser with axe-core in it.
async function findings(browser, views = VIEWS) {
  const found = new Map();
  await browser.view(views[0].width, views[0].scheme);
  await browser.value(EXPLAIN);
  for (const {width, scheme, rules} of views) {
    const add = (what, remedy) => {
      if (!found.has(what)) found.set(what, {remedy, views: new Set()});
      found.get(what).views.add(`${width} px, ${scheme}`);
    };
    await browser.view(width, scheme);
    const {violations, breadth} = await browser.value(run(rules));
    if (breadth > width) add("the page is wider than its window", `${breadth} px; let what sticks out wrap or scroll`);
    for (const {id, help, helpUrl, nodes} of violations) {
      for (const {target, failureSummary} of nodes)
        add(`${id} (${help}) at ${target.join(" ")}`, `${failureSummary.replace(/\s*\n\s*/g, "; ")}; ${helpUrl}`);
    }
  }
  return [...found].map(([what, {remedy, views}]) => `${what}, at ${[...views].join(" and ")}: ${remedy}`);
}

// The source of axe-core, to be given to browser.open.
const read = (file) => fs.readFileSync(file, "utf8");

module.exports = {findings, read, IN_LIGHT};
