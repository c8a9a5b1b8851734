// What axe-core (Deque's checker of web pages against the WCAG) finds on a page: in light and dark colours, on a
// phone and on a desk, with all that folds unfolded. And whether the page is wider than the window.
"use strict";

const fs = require("fs");

// WCAG 2.1 at levels A and AA, axe-core's best practices, and from WCAG 2.2 the size of targets, which axe-core
// leaves out unless asked.
const OPTIONS = {
  runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"],
  rules: {"target-size": {enabled: true}},
  resultTypes: ["violations"],
};

const VIEWS = [390, 1280].flatMap((width) => ["light", "dark"].map((scheme) => ({width, scheme})));

// What comes and goes: a live figure is drawn when the reader is near, and a click explains a pixel. Where the first one
// isn't drawn, the book has been woven without them.
const EXPLAIN = `(async () => {
  const wait = async (condition) => {
    for (let tenth = 0; tenth < 1200 && !condition(); tenth++) await new Promise((resolve) => setTimeout(resolve, 100));
    return condition();
  };
  for (const live of document.querySelectorAll(".live")) {
    live.scrollIntoView();
    if (!await wait(() => live.dataset.drawn)) break;
    if (live.dataset.click) continue;
    const canvas = live.querySelector("canvas"), {left, top, width, height} = canvas.getBoundingClientRect();
    const at = {pointerId: 1, bubbles: true, buttons: 1, clientX: left + width / 2, clientY: top + height / 2};
    for (const type of ["pointerdown", "pointerup", "click"]) canvas.dispatchEvent(new PointerEvent(type, at));
    await wait(() => live.dataset.explained);
  }
  scrollTo(0, 0);
})()`;

const RUN = `(async () => {
  await new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
  document.querySelectorAll("details").forEach((details) => { details.open = true; });
  return {...await axe.run(document, ${JSON.stringify(OPTIONS)}), breadth: document.documentElement.scrollWidth};
})()`;

// A line for each rule broken at a place of the page, which must be open in the browser with axe-core in it.
async function findings(browser) {
  const found = new Map();
  await browser.value(EXPLAIN);
  for (const {width, scheme} of VIEWS) {
    const add = (what, remedy) => {
      if (!found.has(what)) found.set(what, {remedy, views: []});
      found.get(what).views.push(`${width} px, ${scheme}`);
    };
    await browser.view(width, scheme);
    const {violations, breadth} = await browser.value(RUN);
    if (breadth > width) add("the page is wider than its window", `${breadth} px; let what sticks out wrap or scroll`);
    for (const {id, help, helpUrl, nodes} of violations) {
      for (const {target, failureSummary} of nodes)
        add(`${id} (${help}) at ${target.join(" ")}`, `${failureSummary.replace(/\s*\n\s*/g, "; ")}; ${helpUrl}`);
    }
  }
  return [...found].map(([what, {remedy, views}]) => `${what}, ${views.length === VIEWS.length ? "in all views" : `at ${views.join(" and ")}`}: ${remedy}`);
}

// The source of axe-core, to be given to browser.open.
const read = (file) => fs.readFileSync(file, "utf8");

module.exports = {findings, read};
