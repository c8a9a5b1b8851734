// The workbench in a browser: what is typed into it is compiled there, and its claims say what the native suite says.
// Speaks TAP, for make check-site; runs in a build folder that has site/ and what test_site.py has written. Arguments: the
// source folder, the browser's name and its program, what make site has made, and axe-core ("" if missing). With
// RAYKIT_QUICK, Firefox is tried with one suite, and without known mistakes.
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const axe = require("./axe.js");
const {Browser} = require("./browser.js");
const {Firefox} = require("./firefox.js");
const {serve} = require("./site_server.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const BROWSERS = {Chromium: Browser, Firefox};

const [source, name, program, made, axe_core] = process.argv.slice(2);
const isQuick = process.env.RAYKIT_QUICK && name !== "Chromium";
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

// Replaces the text as typing does, and waits for the verdict. Returns {state, claims: {NAME: verdict and message}, said,
// seconds, first: what is seen first, told: its title and its message}.
async function type(browser, text) {
  await browser.value(`(() => {
    document.getElementById("state").textContent = "Typed";
    document.querySelector("#text .cm-content").focus();
  })()`);
  await browser.press("a");
  await browser.insert(text);
  await browser.until(`/claims hold|found an error|is empty|does not go on/.test(document.getElementById("state").textContent)`);
  return JSON.parse(await browser.value(`JSON.stringify({
    state: document.getElementById("state").textContent, said: document.getElementById("said").textContent,
    seconds: document.getElementById("seconds").textContent,
    first: document.getElementById("first").textContent,
    told: [...document.querySelectorAll("#first:not([hidden]) > :is(strong, pre)")].map((part) => part.textContent),
    claims: Object.fromEntries([...document.querySelectorAll(".claims li")].map((item) =>
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
  await browser.until(`document.getElementById("drawn").textContent !== ""`);
  const drawn = await browser.value(`document.getElementById("drawn").textContent`);
  check(/the wanted picture; drawn in/.test(drawn), `${stem}: its picture is the wanted one`, drawn);
  const dead = await browser.value(`Promise.all([...document.querySelectorAll("a")].map(async ({href}) => {
    const answer = await fetch(href), page = new DOMParser().parseFromString(await answer.text(), "text/html");
    const place = decodeURIComponent(new URL(href).hash.slice(1));
    return answer.ok && (!place || page.getElementById(place)) ? "" : href;
  })).then((all) => all.join(" ").trim())`);
  check(dead === "", `${stem}: its links lead somewhere`, dead);
  const [name, line] = await browser.value(`(() => {
    const button = [...document.querySelectorAll("#steps button.code")].pop();
    button.click();
    return [button.textContent, document.querySelector("#text .cm-activeLine").textContent];
  })()`);
  check(line.includes(`${name.replace(/\(\)$/, "")}(`) && !line.endsWith(";"), `${stem}: the task's names of functions lead to them`, `${name}: ${line}`);
}

// What was typed is there again, with its history, when the page is opened anew.
async function kept(browser, address, stem) {
  const whole = `[...document.querySelectorAll("#text .cm-line")].map((line) => line.textContent).join("\\n")`;
  await type(browser, "int first;\n");
  await type(browser, "int second;\n");
  await browser.open(`${address}/workbench.html?${stem}`, `window.early = [];
    setInterval(() => {
      const text = document.getElementById("text");
      if (text?.querySelector(".cm-content") && !text.inert) early.push(text.textContent.includes("int second;"));
    }, 1);`);
  await browser.until(`/found an error|claims hold/.test(document.getElementById("state").textContent)`);
  const early = name === "Firefox" || await browser.value("early.length && early.every(Boolean)"); // it runs no script so early
  check(early, "nothing can be typed before the kept text is there", String(early));
  const again = await browser.value(whole);
  await browser.value(`document.querySelector("#text .cm-content").focus()`);
  await browser.press("z");
  const undone = await browser.value(whole);
  check(again.startsWith("int second;") && undone.startsWith("int first;"), "a text is kept, with what can be undone", `${again} ${undone}`);
}

// A visit shows verdict and picture of what was built at the last one, without a compiler; and of nothing else.
async function built_before(browser, address) {
  const seen = async () => {
    await browser.until(`/claims hold/.test(document.getElementById("state").textContent) && document.getElementById("drawn").textContent`);
    return JSON.parse(await browser.value(`JSON.stringify({seconds: document.getElementById("seconds").textContent,
      told: [document.getElementById("state").textContent, document.getElementById("drawn").textContent.replace(/drawn in.*/, ""),
        document.getElementById("first").textContent, ...[...document.querySelectorAll(".claims li")].map((item) => item.dataset.verdict + item.textContent)].join("\\n")})`));
  };
  const reference = fs.readFileSync(`${source}/src/features/normals.c`, "utf8"), open = () => browser.open(`${address}/workbench.html?normals`);
  const beyond = "float *volatile p = malloc(12);\n    if (p && p[3] > 1e30f) return a;\n    free(p);\n    return rk_normalize("; // whose place the engine's list of calls tells
  const traps = `#include <stdlib.h>\n${reference.replace("return rk_normalize(", beyond)}`;
  await type(browser, traps);
  const typed = await seen();
  await open();
  const again = await seen();
  check(traps.includes(beyond) && /line \d+/.test(typed.told) && again.told === typed.told, "a later visit has the same verdicts, places and picture", `${typed.told}\n\n${again.told}`);
  check(/compile/.test(typed.seconds) && /run/.test(again.seconds) && !/compile/.test(again.seconds), "it runs what was built before", `${typed.seconds}; ${again.seconds}`);
  await browser.value(`document.querySelector("#text .cm-content").focus()`);
  await browser.press("a");
  await browser.insert(reference);
  await open(); // before the text is compiled
  const other = await seen();
  check(/compile/.test(other.seconds) && /^(\d+) of \1 claims hold/.test(other.told), "another text is built first", JSON.stringify(other, null, 1));
  await browser.value(`caches.keys().then((names) => Promise.all(names.map(async (name) =>
    (await caches.open(name)).put("built/normals", new Response("damaged")))))`);
  await open();
  const rebuilt = await seen();
  check(/compile/.test(rebuilt.seconds) && rebuilt.told === other.told, "a text whose kept modules are damaged is built anew", JSON.stringify(rebuilt, null, 1));
}

const closed = (server) => new Promise((resolve) => {
  server.close(resolve);
  server.closeAllConnections();
});

// What a visitor sees first: each picture, and where each link leads.
async function landing_page(browser, address) {
  await browser.open(`${address}/index.html`);
  await browser.until('document.readyState === "complete"');
  const found = await browser.value(`(async () => {
    for (const image of document.images) image.loading = "eager";
    await Promise.all([...document.images].map((image) => image.decode().catch(() => {})));
    const links = await Promise.all([...document.querySelectorAll("a")].map(async ({href}) =>
      (await fetch(href)).ok && (!new URL(href).hash || document.getElementById(new URL(href).hash.slice(1))) ? "" : href));
    return {blank: [...document.images].filter((image) => !image.naturalWidth).map((image) => image.src),
      dead: links.filter(Boolean), ways: [...document.querySelectorAll(".ways a")].map((link) => link.textContent),
      strip: document.querySelectorAll(".strip img").length,
      told: [...document.querySelectorAll(".course a")].filter((link) => /\\w.*\\w/.test(link.lastChild.textContent)).length};
  })()`);
  check(!found.blank.length && !found.dead.length, "the landing page's pictures can be seen, and its links lead somewhere", JSON.stringify(found));
  check(found.ways[0].startsWith("Start") && found.ways.includes("For instructors") && found.strip === 3 && found.told === 16,
    "it shows where to start, a mistake beside the right picture, and what each effect is", JSON.stringify(found));
}

// Who comes from the workbench sees no solution by accident, there and in the next chapter.
async function solutions_are_folded(browser, folder) {
  const listing = (file) => `<div class="listing"><div class="caption"><span class="from"><a><code>${file}</code>, line 1</a></span></div><pre>{ }</pre></div>`;
  const page = path.join(folder, "chapter.html");
  fs.writeFileSync(page, `<!DOCTYPE html><main>${listing("src/features/normals.c")}${listing("src/features/normals.h")}${listing("tests/test_normals.c")}
    <div class="replay" data-file="src/features/normals.c"><pre>{ }</pre></div></main>
    <script src="file://${path.resolve("site/folded.js")}"></script>`);
  const seen = async (query) => {
    await browser.value(`void setTimeout(() => { location.search = "${query}"; })`);
    await browser.until(`document.readyState === "complete" && location.search === "${query}"`);
    return browser.value(`[...document.querySelectorAll("pre")].filter((pre) => pre.checkVisibility()).length`);
  };
  await browser.open(`file://${page}`);
  const counts = [await seen("?other"), await seen("?work"), await seen("?next")];
  check(counts.join() === "4,2,2", "the kit's units are folded for those who come from the workbench, from then on", counts.join());
}

// The book's pages, of which one was opened with a network, are found by the search, and are there.
async function begin_the_book(browser, address) {
  await browser.open(`${address}/book/index.html`);
  await browser.until(`document.querySelector(".search input")`);
  return browser.until(`window.raykitPlaces && Promise.all(["search.js", ...new Set(Object.values(raykitPlaces))].map((page) => caches.match(page))).then((all) => all.every(Boolean))`);
}

async function search_offline(browser, address) {
  await browser.open(`${address}/book/index.html`);
  await browser.until(`document.readyState === "complete" && document.querySelector(".search input")`);
  await browser.value(`(() => { const field = document.querySelector(".search input"); field.focus(); field.value = "surface area heuristc"; field.dispatchEvent(new Event("input")); })()`);
  await browser.until(`document.querySelector("#found mark")`);
  const place = await browser.value(`document.querySelector("#found li:has(mark) a").href`);
  await browser.value(`void setTimeout(() => document.querySelector("#found li:has(mark) a").click())`);
  const there = await browser.until(`location.href === ${JSON.stringify(place)} && document.querySelector(":target")`);
  check(there && !place.includes("/index.html"), "without a network, the book's search finds a paragraph of a page that was never opened, and leads to it", place);
}

// After one visit the pages need no network; when there is one again, a new version of the site is loaded.
async function offline(browser, server, address) {
  await browser.open(`${address}/index.html`);
  const is_kept = await browser.until(`document.readyState === "complete" && navigator.serviceWorker.controller && navigator.serviceWorker.controller.state === "activated"`);
  const links = await browser.value(`document.querySelectorAll(".course a").length`);
  check(is_kept && links === 16, "the landing page leads to all assignments, and keeps the site", `${is_kept} ${links}`);
  const has_book = fs.existsSync("site/book/search.js");
  if (has_book) await begin_the_book(browser, address);
  const {port} = server.address();
  await closed(server);
  if (has_book) await search_offline(browser, address);
  else console.log(`ok ${++count} - the book's search # SKIP this site has no book with a search: make book, after ./bootstrap --site`);
  await browser.open(`${address}/`);
  const is_there = await browser.until(`document.querySelectorAll(".course a").length === 16`);
  check(is_there, "without a network, the first page is there by its folder's address");
  await browser.open(`${address}/workbench.html?shading`);
  await browser.until(`/claims hold|does not go on/.test(document.getElementById("state").textContent)`);
  const typed = await type(browser, fs.readFileSync(`${source}/src/features/shading.c`, "utf8"));
  check(/^(\d+) of \1 claims/.test(typed.state), "without a network, an assignment that was never opened is checked", JSON.stringify(typed, null, 1));
  const read = (file) => fs.readFileSync(path.resolve("site", file), "utf8");
  const anew = {"index.html": `${read("index.html")}<p id="anew">`, "service_worker.js": read("service_worker.js").replace("VERSION = \"", "VERSION = \"anew-")};
  const again = await serve(path.resolve("site"), {port, changed: anew});
  try {
    await browser.open(`${address}/index.html`);
    await browser.until(`caches.keys().then(([version, old]) => version.startsWith("anew-") && !old)`);
    await browser.open(`${address}/index.html`);
    check(await browser.until(`document.getElementById("anew")`), "with a network again, a new version of the site is loaded");
  } finally {
    await closed(again);
  }
}

// For readers with weak sight or without a mouse, on a phone and on a desk.
async function for_all_readers(browser, address) {
  if (name !== "Chromium") return undefined; // what axe-core finds does not depend on it
  if (!axe_core) return console.log(`ok ${++count} - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live`);
  const drawn = `!document.querySelector("#pictures.old") && !document.getElementById("pictures").hidden`;
  for (const page of ["index.html", "workbench.html?shading"]) {
    await browser.open(`${address}/${page}`, axe.read(axe_core));
    if (page !== "index.html") {
      await browser.until(drawn);
      await browser.value(`document.getElementById("own").click()`);
      await browser.until(`document.getElementById("explained").dataset.of`);
    }
    const found = await axe.findings(browser);
    check(found.length === 0, `axe-core finds nothing on ${page}`, found.join("\n"));
  }
  return browser.view(1280, "light");
}

// The trees of a pixel that is clicked, or aimed at by keys, and where they begin to differ.
async function a_pixel_is_explained(browser) {
  const text = fs.readFileSync(`${source}/src/features/normals.c`, "utf8");
  const drawn = () => browser.until(`document.getElementById("drawn").textContent !== "" && !document.querySelector("#pictures.old")`);
  const explained = async (of) => {
    await browser.until(`document.getElementById("explained").dataset.of === "${of}"`);
    return browser.value(`({said: document.getElementById("pixel").textContent, tree: document.getElementById("explained").innerText,
      marked: [...document.querySelectorAll("#explained mark")].map((mark) => mark.textContent), trees: document.querySelectorAll("#explained .tree").length})`);
  };
  await drawn();
  const place = await browser.value(`(() => {
    const canvas = document.getElementById("wanted");
    canvas.scrollIntoView({block: "center"});
    const {left, top, width, height} = canvas.getBoundingClientRect();
    return {x: left + width / 2, y: top + height / 2, middle: [canvas.width >> 1, canvas.height >> 1]};
  })()`);
  for (const type of ["mousePressed", "mouseReleased"]) await browser.mouse(type, place.x, place.y);
  await browser.until(`document.getElementById("explained").dataset.of`);
  place.of = await browser.value(`document.getElementById("explained").dataset.of`); // a mouse has whole numbers, and pixels are smaller
  const same = await explained(place.of), is_near = place.of.split(",").every((at, i) => Math.abs(at - place.middle[i]) <= 2);
  check(is_near && same.trees === 2 && /Both explain this pixel alike/.test(same.tree) && /camera ray/.test(same.tree) && same.said.startsWith(`Pixel ${place.of}: `) &&
    /by your code +\((.*)\), wanted +\(\1\)$/.test(same.said), "a click on a pixel shows its colours, and both trees of rays", JSON.stringify(same));
  await type(browser, text.replace("return rk_normalize(", "return rk_scale(rk_vec(1, 2, 3), 0 * a.x); return rk_normalize("));
  await drawn();
  await browser.until(`document.querySelectorAll("#explained mark").length === 2`);
  const other = await explained(place.of);
  check(other.marked.length === 2 && other.marked[0] !== other.marked[1] && /first difference/.test(other.tree),
    "after the next text the same pixel is explained again, and the first line that differs is marked", JSON.stringify(other));
  await browser.value(`(() => {
    const place = document.getElementById("whose");
    window.whose_said = [];
    new MutationObserver(() => window.whose_said.push(place.textContent)).observe(place, {childList: true, characterData: true, subtree: true});
  })()`);
  await type(browser, `#include <stdio.h>\n${text.replace("return rk_vec(0.5f", "printf(\"n.x is %d\\n  and more\", n.x > 2);\n    return rk_vec(0.5f")}`);
  await drawn();
  await browser.until(`document.querySelector("#explained .printed")`);
  const printing = await explained(place.of), printed = await browser.value(`document.querySelector("#explained .printed")?.textContent`);
  check(/^(n\.x is 0\n  and more)+/.test(printed) && printing.marked.length === 0 && printing.trees === 2 && !/n\.x is/.test(await browser.value(`document.querySelector("#explained .trees").innerText`)),
    "what a unit prints while a pixel is explained stands apart from its rays, as printed", `${printed}\n${JSON.stringify(printing)}`);
  const said_of_old = await browser.value("window.whose_said");
  check(said_of_old[0] === "by your code, from before your last change" && said_of_old[said_of_old.length - 1] === "by your code", "a picture of the text before says so in words", said_of_old.join("\n"));
  await browser.value(`document.getElementById("own").focus()`);
  for (const key of ["ArrowLeft", "ArrowUp", "Enter"]) await browser.key(key);
  const [x, y] = place.of.split(",").map(Number), aimed = await explained([x - 1, y - 1]);
  check(aimed.said.startsWith(`Pixel ${x - 1},${y - 1}: `), "arrow keys aim at a pixel, and Enter asks", JSON.stringify(aimed));
  const closed = await browser.value(`(() => {
    document.querySelector("#explained > button").click();
    return [document.getElementById("explained").textContent, document.querySelector("#pictures.aimed"), document.getElementById("pixel").textContent];
  })()`);
  check(closed[0] === "" && !closed[1] && closed[2].startsWith("Click a pixel"), "an explanation can be closed", JSON.stringify(closed));
}

// With a starter: what is shown though it is not the student's, or not at all.
async function unwritten(browser, address) {
  const starter = fs.readFileSync("site/starters/bvh_median.c", "utf8");
  const drawn = async () => {
    await browser.until(`document.getElementById("drawn").textContent !== "" && !document.querySelector("#pictures.old")`);
    return browser.value(`document.getElementById("drawn").innerText`);
  };
  await browser.open(`${address}/workbench.html?bvh_median`);
  await browser.until(`/claims hold|does not go on/.test(document.getElementById("state").textContent)`);
  const seconds = await browser.value(`document.getElementById("seconds").textContent`);
  check(/compile [\d.]+ s/.test(seconds) && !/last key/.test(seconds), "before any key nothing is said of the last one", seconds);
  const first = await drawn();
  const whose = await browser.value(`document.getElementById("whose").textContent`);
  check(/^Step 1: not written yet/.test(first) && whose === "by your code, without step 1", "a picture that the starter draws is not called the wanted one, or the student's", `${whose}\n${first}`);
  await browser.value(`document.getElementById("own").click()`);
  await browser.until(`document.getElementById("explained").dataset.of`);
  const tree = await browser.value(`document.getElementById("explained").innerText`);
  check((tree.match(/^camera ray$/gm) || []).length === 2, "a pixel of a debug view is explained, with the options that go with the view", tree);
  await type(browser, starter.replace("    return rk_box_empty();\n}", `    rk_box box = rk_box_empty();
    for (uint32_t i = 0; i < count; i++)
        box = rk_box_merge(box, references[triangle_of(keys[i])].box);
    return box;
}`).replace(/(bvh->nodes\[0\] = .*\n)/, "$1    split(builder, 0, bvh->triangle_count, RK_BVH_LEVELS_MAX - 1, &bvh->nodes[0].box);\n"));
  const third = await drawn();
  check(/^Step 1: the wanted picture; drawn/.test(third), "where the next step is not written, what was written before it is drawn", third);
  const ask = (step) => browser.value(`document.querySelector('#looks button[value="${step}"]').click()`);
  await ask(3);
  await browser.until(`/^Step 3/.test(document.getElementById("drawn").textContent)`);
  const none = [await drawn(), await browser.value(`document.querySelector("#looks [aria-pressed=true]").textContent`)];
  check(/^Step 3 is not written yet, and draws nothing\./.test(none[0]) && none[1] === "step 3", "of a step that cannot be drawn yet that is said first", none.join("\n"));
  const steps = await browser.value(`[...document.querySelectorAll("#steps .points")].map((one) => / points, not written yet$/.test(one.textContent))`);
  check(steps.length > 3 && !steps[0] && steps.slice(2).every(Boolean), "of each step it is said whether it is not written yet", steps.join());
  await ask(1);
  await browser.until(`/^Step 1/.test(document.getElementById("drawn").textContent)`);
  const earlier = [await drawn(), await browser.value(`document.querySelector("#looks [aria-pressed=true]").textContent`)];
  check(/^Step 1: the wanted picture; drawn/.test(earlier[0]) && earlier[1] === "step 1", "the picture of an earlier step can be looked at", earlier.join("\n"));
  await ask(3);
  await browser.until(`/^Step 3/.test(document.getElementById("drawn").textContent)`);
  await ask("");
  check(await browser.until(`/^Step 1/.test(document.getElementById("drawn").textContent)`), "and the first one that is not done again");
  await browser.value("scrollTo(0, document.body.scrollHeight)");
  const seen = await browser.value(`(({top, bottom}) => [scrollY > 500, top >= 0, bottom <= innerHeight])(document.getElementById("code").getBoundingClientRect())`);
  check(seen.every(Boolean), "editor and pictures stay where they are while steps are read", seen.join());
}

async function at_all_widths(browser) {
  await browser.view(390, "light");
  const tops = await browser.value(`["#goal", "#steps > .current", "#text", "#step-1"].map((part) => document.querySelector(part).getBoundingClientRect().top)`);
  check(tops.every((top, i) => i === 0 || top > tops[i - 1]), "on a phone the step to work on stands before the editor", tops.join());
  await browser.view(1280, "light");
  await type(browser, `${"\n".repeat(100)}// ${"x".repeat(97)}`);
  const wraps = await browser.value(`(([before, line], {scrollHeight, clientHeight}) => [line.offsetHeight / before.offsetHeight, scrollHeight > clientHeight])
    ([...document.querySelectorAll("#text .cm-line")].slice(-2), document.querySelector("#text .cm-scroller"))`);
  check(wraps.join() === "1,true", "at 1280 pixels a line of 100 letters does not wrap", wraps.join());
}

// What stands beside the code.
async function beside(browser) {
  const lead = await browser.value(`document.querySelector("#steps .current .claims [data-verdict=failed]").innerText`);
  const code = await browser.value(`document.querySelector("#first details pre").textContent`);
  check(/^static void \w+\(void \*\*state\)\n\{\n[^]*\n\}$/m.test(code), "a claim that fails shows its code", `${lead}\n${code}`);
  const given = await browser.value(`(() => {
    const item = [...document.querySelectorAll("#step-1 li")].find((one) => one.querySelector(".prototype"));
    item.querySelector("button.place").click();
    return item.textContent;
  })()`);
  check(/rk_box rk_box_merge\(rk_box \w+, rk_box \w+\);/.test(given), "what is given has its prototype", given);
  await browser.until(`document.getElementById("header").open`);
  const header = await browser.value(`document.getElementById("header_name").textContent + document.getElementById("header_text").textContent`);
  check(/^base\/box\.h[^]*rk_box_merge\(/.test(header), "and its header, by a button", header.slice(0, 200));
  await browser.value(`document.getElementById("header").close()`);
  const heights = await browser.value(`["Checking", "Checking: 17 of 36", "36 of 36 claims hold. Save the file, and choose the next assignment above."].map((said) => {
    document.getElementById("state").textContent = said;
    return document.querySelector("header").offsetHeight;
  })`);
  check(new Set(heights).size === 1, "the head of the page keeps its height while claims are checked", heights.join());
  if (name === "Chromium") await at_all_widths(browser);
  const typed = await type(browser, "int f(void)");
  for (const key of ["{", "Enter", "}"]) await browser.key(key);
  const text = await browser.value(`document.querySelector("#text .cm-content").innerText`);
  check(text.replace(/\s/g, "") === "intf(void){}", "a closing brace that is typed stands there once", `${typed.state}\n${text}`);
  await type(browser, fs.readFileSync("site/starters/bvh_median.c", "utf8")); // with which the next page begins
}

// Beside the verdict, with what belongs to them, and in the editor.
async function warnings(browser, text) {
  const told = () => browser.value(`[document.getElementById("compiler").checkVisibility() && document.getElementById("findings").innerText,
    document.querySelectorAll("#text .cm-lint-marker-warning").length, document.getElementById("first").textContent]`);
  await type(browser, text.replace("return rk_vec(0.5f", "rk_vec(0.5f"));
  const [missing, marks, first] = await told();
  check(/^line \d+: warning: non-void function does not return a value$/m.test(missing) && marks > 0 && !/cut off/.test(first),
    "a missing return is told as the compiler's warning, and not as another mistake", `${missing}\n${marks}\n${first}`);
  const held = await type(browser, text.replace("return rk_vec(0.5f", "n.x == 2;\n    unsigned k = 1;\n    if (k >= 0)\n        k = 2;\n    return rk_vec(0.5f"));
  const [all] = await told();
  check(/^(\d+) of \1 claims/.test(held.state) && /warning: equality comparison result unused\s+line \d+: note: use '='/.test(all) && /warning: .*always true/.test(all),
    "where all claims hold warnings are shown as well, with the compiler's notes", `${held.state}\n${all}`);
  await type(browser, text);
  const [none, unmarked] = await told();
  check(none === false && unmarked === 0, "a text without warnings has none", `${none} ${unmarked}`);
}

async function mistakes(browser) {
  const text = fs.readFileSync(`${source}/src/features/normals.c`, "utf8");
  const halved = await type(browser, text.replace("0.5f + 0.5f * n.x, 0.5f + 0.5f * n.y", "1 + n.x, 1 + n.y"));
  check(/failed: got .*test_normals\.c:\d+/s.test(halved.claims.each_axis_has_a_colour_of_its_own),
    "a mistake is told by the claim's message", JSON.stringify(halved, null, 1));
  const place = await browser.value(`(() => {
    document.querySelector("#first p button.place").click();
    const {height} = document.getElementById("header_text").getBoundingClientRect(), mark = document.querySelector("#header_text mark");
    const said = [document.getElementById("header_name").textContent, mark.textContent, mark.offsetTop < height + mark.closest("pre").scrollTop + mark.closest("pre").offsetTop];
    document.getElementById("header").close();
    return said;
  })()`);
  const [, line] = place[0].match(/^test_normals\.c, line (\d+)$/) || [];
  check(line && place[1].trimEnd() === fs.readFileSync(`${source}/tests/test_normals.c`, "utf8").split("\n")[line - 1] && place[2], "the place of a claim that fails leads to the suite's line", place.join("\n"));
  await warnings(browser, text);
  const printing = await type(browser, `#include <stdio.h>\n${text.replace("return rk_vec(0.5f", "if (n.x == 1)\n        printf(\"two\\nlines\\n\");\n    return rk_vec(0.5f")}`);
  const printed = await browser.value(`[document.querySelector("#printed:not([hidden]) summary").textContent, document.querySelector("#printed pre").textContent]`);
  check(/^(\d+) of \1 claims/.test(printing.state) && /^Your code printed \d+ lines$/.test(printed[0]) && printed[1].startsWith("two\nlines\n"),
    "what was printed can be unfolded where all claims hold", `${printing.state}\n${printed.join("\n")}`);
  const broken = await type(browser, text.replace("return rk_vec(0.5f", "retrun rk_vec(0.5f"));
  check(/normals\.c:\d+:\d+: error/.test(broken.said), "a compiler's error names the line", JSON.stringify(broken, null, 1));
  check(/^The compiler found an error.*line \d+$/s.test(broken.first), "and stands where it is seen first", broken.first);
  await browser.insert(" ");
  const old = await browser.value(`new Promise((resolve) => {
    const check = () => document.querySelector("#first.old") ? resolve(["first", "compiler"].map((box) => getComputedStyle(document.querySelector("#" + box + " > strong"), "::after").content)) : setTimeout(check, 1);
    check();
  })`);
  check(old.every((said) => /from before your last change/.test(said)), "while a text is compiled, the error of the text before says so in words", old.join("\n"));
  await browser.until(`!document.querySelector("#first.old")`);
  const empty = await type(browser, " ");
  check(empty.state === "The file is empty" && /^The file is empty.*"Start over"/.test(empty.first), "of an empty file it is said how the starter comes back", `${empty.state}\n${empty.first}`);
  const open = await type(browser, text.replace("return rk_vec(0.5f", "if (n.x > 2) {\n    return rk_vec(0.5f"));
  check(/line \d+: note: to match this '\{'/.test(open.first), "with the compiler's notes", open.first);
  const loop = await type(browser, text.replace("return rk_vec(0.5f", "for (volatile int k = 0; k < 2; k = 0) { }\n    return rk_vec(0.5f"));
  const limits = Object.values(loop.claims).filter((said) => /no verdict after 1 s/.test(said)).length;
  check(/no verdict after 10 s/.test(loop.first) && limits > 0, "after two claims that did not end the others get less time", JSON.stringify(loop, null, 1));
  await browser.until(`/ran again/.test(document.getElementById("first").textContent)`);
  const where = await browser.value(`document.querySelector("#first > p").textContent`), at = text.split("\n").findIndex((one) => one.includes("return rk_vec(0.5f")) + 1;
  check(where === `in line ${at}`, "and the line is told in which the loop is", `${where}, want line ${at}`);
  const told = await browser.value(`document.getElementById("state").textContent`);
  check(/claims hold$/.test(told), "the count of claims stands there still", told);
  const wild = await type(browser, text.replace("return rk_normalize(", "float two[2] = {a.x, b.x};\n    int many = 0x7fffffff + (int)(a.x > -1e30f);\n    if (two[many & 1] > 1e30f) return a;\n    return rk_normalize("));
  check(/fault: the sum of two integers is beyond their type's range \(line \d+\)/.test(Object.values(wild.claims).join("\n")),
    "undefined behaviour is told with its kind and line", JSON.stringify(wild, null, 1));
}

const measured_alike = (message) => message.replace(/took \d+/g, "took"); // the bytes of stack that code took are the compiler's

// Known mistakes of a suite are told first by the claim that fails natively, with its message. Faults have other words:
// a page has no addresses.
async function known_mistakes(browser, stem) {
  const begun = Date.now(), known = JSON.parse(fs.readFileSync("tests/site_mistakes.json", "utf8"))[stem] || [];
  const count = Math.min(known.length, 10), differ = [];
  for (let i = 0; i < count; i++) {
    const {name: mistake, text, claim, verdict, message} = known[Math.floor(i * known.length / count)];
    const {told: [title = "", said = ""]} = await type(browser, text);
    const is_same = title.replace(/^Step \d+: /, "") === claim.replaceAll("_", " ") && (verdict === "fault" || measured_alike(said) === measured_alike(message));
    if (!is_same) differ.push(`${mistake}: natively ${claim}: ${message}`, `    in the page ${title}: ${said}`);
  }
  if (known.length) check(differ.length === 0, `${stem}: ${count} known mistakes are told as natively`, differ.join("\n"));
  console.log(`# ${stem}: ${((Date.now() - begun) / 1000).toFixed(1)} s for ${count} known mistakes`);
}

async function main() {
  if (!program || !made) {
    console.log(`1..0 # SKIP ${program ? "@yowasp/clang is missing: ./bootstrap --site" : `${name} is missing: ./bootstrap --pdf`}`);
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-site-"));
  const server = await serve(path.resolve("site")), browser = new BROWSERS[name](program, folder);
  try {
    const address = `http://127.0.0.1:${server.address().port}`;
    await landing_page(browser, address);
    await solutions_are_folded(browser, folder);
    await workbench(browser, address, "normals");
    await a_pixel_is_explained(browser);
    await mistakes(browser);
    if (!isQuick) await known_mistakes(browser, "normals");
    await kept(browser, address, "normals");
    await built_before(browser, address);
    await for_all_readers(browser, address);
    await unwritten(browser, address);
    await beside(browser);
    if (!isQuick) {
      await workbench(browser, address, "bvh_median");
      await known_mistakes(browser, "bvh_median");
    }
    await offline(browser, server, address);
  } finally {
    await browser.quit();
    server.close();
    fs.rmSync(folder, {recursive: true, force: true});
  }
  console.log(`1..${count}`);
  process.exitCode = failed ? 1 : 0;
}

main();
