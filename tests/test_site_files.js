// A student's files in the workbench, in a browser: they are saved and opened again, and graded by the kit; what is shown in
// two tabs is the same in both. Speaks TAP, for make check-site; runs in a build folder that has site/. Arguments: the
// source folder, Chromium, and what make site has made.
"use strict";

const {execFileSync, spawnSync} = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");
const {Browser} = require("./browser.js");
const {serve} = require("./site_server.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, chromium, made] = process.argv.slice(2);
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

const reference = (stem) => fs.readFileSync(`${source}/src/features/${stem}.c`, "utf8");
const state = `document.getElementById("state").textContent`;
const python = (code, ...args) => execFileSync("python3", ["-c", code, ...args], {encoding: "utf8"});

// In the browser's only tab: each has a clang in its memory.
async function visit(browser, page, condition) {
  if (await browser.value("location.href").catch(() => "")) await browser.value(`void (window.isLeft = true, location.assign(${JSON.stringify(page)}))`);
  else await browser.open(page);
  await browser.until(`!window.isLeft && (${condition})`);
}

async function workbench(browser, address, stem) {
  await visit(browser, `${address}/workbench.html?${stem}`, `/claims hold|found an error|does not go on/.test(${state})`);
}

// Puts a text in the place of the present one, in one page of several, by the editor's own keys: of a long text the page has only the lines
// that are seen, and a browser's commands would replace no others. Not by focus, at which pages keep and take over texts.
const PUT = `(({document, KeyboardEvent, ClipboardEvent, DataTransfer}, text) => {
  const content = document.querySelector("#text .cm-content"), clipboardData = new DataTransfer(), more = {bubbles: true, cancelable: true};
  document.getElementById("state").textContent = "Typed";
  content.dispatchEvent(new KeyboardEvent("keydown", {key: "a", code: "KeyA", keyCode: 65, ctrlKey: true, ...more}));
  clipboardData.setData("text/plain", text);
  content.dispatchEvent(new ClipboardEvent("paste", {clipboardData, ...more}));
})`;

// Types a text in place of the present one, into the page or into one within it, and waits for the verdict.
async function type(browser, text, page = "window") {
  await browser.value(`${PUT}(${page}, ${JSON.stringify(text)})`);
  await browser.until(`/claims hold|found an error|does not go on/.test(${page}.${state})`);
  return browser.value(`${page}.${state}`);
}

const text_in = (browser, page = "window") => browser.value(`[...${page}.document.querySelectorAll("#text .cm-line")].map((line) => line.textContent).join("\\n")`);

// What a click on the button, or Ctrl+S, would download: {name, bytes}.
async function saved(browser, action) {
  const [name, base64] = await browser.value(`new Promise((resolve) => {
    const {createObjectURL} = URL, {click} = HTMLAnchorElement.prototype;
    let blob = null;
    URL.createObjectURL = (given) => { blob = given; return createObjectURL(given); };
    HTMLAnchorElement.prototype.click = function () {
      Object.assign(URL, {createObjectURL});
      Object.assign(HTMLAnchorElement.prototype, {click});
      const reader = new FileReader();
      reader.onload = () => resolve([this.download, reader.result.replace(/.*,/, "")]);
      reader.readAsDataURL(blob);
    };
    ${action};
  })`);
  return {name, bytes: Buffer.from(base64, "base64")};
}

const press_save = `document.body.dispatchEvent(new KeyboardEvent("keydown", {key: "s", ctrlKey: true, bubbles: true, cancelable: true}))`;

// Opens files, {NAME: bytes or text}, and returns what the page asks or says, or "" if it needs no words, as when told silently.
async function opened(browser, files, silently = false) {
  const coded = Object.entries(files).map(([name, bytes]) => [name, Buffer.from(bytes).toString("base64")]);
  await browser.value(`(() => {
    const list = new DataTransfer(), input = document.getElementById("file");
    for (const [name, base64] of ${JSON.stringify(coded)}) list.items.add(new File([Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0))], name));
    document.getElementById("state").textContent = "Opened";
    input.files = list.files;
    input.dispatchEvent(new Event("change"));
  })()`);
  await browser.until(silently ? `/claims hold/.test(${state})` : `document.querySelector("dialog[open]")`);
  return browser.value(`document.querySelector("dialog[open]")?.innerText || ""`);
}

// Returns the dialog that follows, or "".
async function answered(browser, value) {
  await browser.value(`document.querySelector('dialog[open] button[value="${value}"]').click()`);
  await new Promise((resolve) => setTimeout(resolve, 300));
  return browser.value(`document.querySelector("dialog[open]")?.innerText || ""`);
}

// Everything, saved as a zip, is a workbook, and the unit in it earns all points. Returns the zip.
async function save_all(browser, address, folder) {
  await workbench(browser, address, "normals");
  await type(browser, reference("normals"));
  const all_hold = await browser.value(`document.getElementById("state").innerHTML`);
  check(/^(\d+) of \1 claims hold\. Next: <a href="workbench\.html\?bvh_median">1 /.test(all_hold), "when all claims hold, a link leads on", all_hold);
  const unit = await saved(browser, press_save);
  check(unit.name === "normals.c" && unit.bytes.toString() === reference("normals"), "Ctrl+S saves the file", `${unit.name}\n${unit.bytes}`);
  const zip = await saved(browser, `document.getElementById("save-all").click()`), file = path.join(folder, zip.name);
  fs.writeFileSync(file, zip.bytes);
  python("import sys, zipfile; zipfile.ZipFile(sys.argv[1]).extractall(sys.argv[2])", file, folder);
  const mine = path.join(folder, "mine"), said = execFileSync("python3", ["-B", `${source}/tools/workbook.py`, "--source", source, "--named", "mine", mine], {encoding: "utf8"});
  const kept = said.split("\n").filter((line) => line && !/, as it was generated$|^next:/.test(line));
  check(kept.join() === "kept     normals.c, which you have changed", "all that is saved is a workbook, as make workbook writes it", said);
  const graded = spawnSync(process.env.MAKE || "make", ["-s", "grade", "ASSIGNMENTS=normals", `IMPL=${mine}`], {encoding: "utf8"});
  check(/\b100 of 100 points/.test(graded.stdout), "and its unit earns 100 of 100 points", graded.stdout + graded.stderr);
  return zip.bytes;
}

// In a browser that has never been here.
async function open_all(browser, address, zip) {
  await workbench(browser, address, "shading");
  const said = await opened(browser, {"workbook.zip": zip});
  check(/^Opened\s+Taken[^\n]*\s+0 .*\s+The same as yours:(\s+\d+ .*){15}\s+Close$/.test(said), "a workbook is opened again: what is no starter is taken", said);
  await answered(browser, "");
  await visit(browser, `${address}/index.html`, `document.querySelector(".progress")`);
  const begun = await browser.value(`[...document.querySelectorAll(".progress")].map((one) => one.parentElement.textContent).join("\\n")`);
  check(/^0\. .*begun$/.test(begun), "the first page says what is begun", begun);
  const way = `document.querySelector(".ways .first").textContent`, goes_on = await browser.value(way);
  check(/^Continue: 0\. .*, begun$/.test(goes_on), "and leads on to it", goes_on);
  await workbench(browser, address, "normals");
  const [, passed, all] = (await browser.value(state)).match(/^(\d+) of (\d+)/) || [];
  check(passed === all && Number(all) > 0, "and all its claims hold", await browser.value(state));
  await visit(browser, `${address}/index.html`, `document.querySelector(".progress")`);
  const held = await browser.value(`document.querySelector(".progress").textContent`);
  check(held === `✓ all ${all} claims hold`, "the first page says how many claims hold", held);
  const next = await browser.value(`${way} + document.querySelector(".ways .first").href`);
  check(/^Continue: 1\. .*\?bvh_median$/.test(next), "and leads on to the next assignment", next);
}

// Zips of other programs, packs, and single files.
async function open_others(browser, address, folder) {
  const at = path.join(folder, "made");
  for (const [name, text] of Object.entries({"workbook/bloom.c": reference("bloom"), "workbook/helper.c": "int help;\n", "src/features/sampling.c": reference("sampling"), "tests/test_bloom.c": "int t;\n"})) {
    fs.mkdirSync(path.dirname(path.join(at, "pack", name)), {recursive: true});
    fs.writeFileSync(path.join(at, "pack", name), text);
  }
  python("import os, shutil, sys; os.chdir(sys.argv[1]); [shutil.make_archive('pack', form, base_dir='pack') for form in ('zip', 'gztar')]", at);
  await workbench(browser, address, "shading");
  const pack = await opened(browser, {"pack.tar.gz": fs.readFileSync(path.join(at, "pack.tar.gz"))});
  check(/Taken[^\n]*\s+6 .*\s+Not taken:\s+pack\/workbook\/helper\.c is not named after an assignment.*\s+Close$/.test(pack),
    "of a pack the student's own files are taken, and what is no unit is told", pack);
  await answered(browser, "");
  const again = await opened(browser, {"pack.zip": fs.readFileSync(path.join(at, "pack.zip"))});
  check(/^Nothing was changed\s+The same as yours:\s+6 /.test(again), "a zip of another program is read, too", again);
  await answered(browser, "");

  const other = await opened(browser, {"bloom.c": "int mine;\n"});
  check(/^Open this file\?\s+It takes the place of your own text[^\n]*\s+bloom\.c: 6 /.test(other), "before another text of one's own is replaced, the page asks", other);
  const cancelled = await answered(browser, "");
  await answered(browser, "");
  await workbench(browser, address, "bloom");
  check(/Nothing was changed/.test(cancelled) && !(await text_in(browser)).includes("int mine"), "and leaves it if so told", cancelled);
  await workbench(browser, address, "shading");
  await opened(browser, {"bloom.c": "int mine;\n"});
  const replaced = await answered(browser, "all");
  check(/^Opened\s+Taken[^\n]*\s+6 /.test(replaced), "a file goes to its own assignment", replaced);
  await answered(browser, "");
  await workbench(browser, address, "bloom");
  const put = await text_in(browser);
  await browser.value(`document.querySelector("#text .cm-content").dispatchEvent(new KeyboardEvent("keydown", {key: "z", code: "KeyZ", keyCode: 90, ctrlKey: true, bubbles: true, cancelable: true}))`);
  await browser.until(`document.getElementById("text").textContent.includes("rk_bloom")`);
  const undone = await text_in(browser);
  check(put.startsWith("int mine;") && undone.includes("rk_bloom"), "and undo brings back what it replaced", `${put}\n${undone}`);

  await workbench(browser, address, "shading");
  const elsewhere = await opened(browser, {"cubemap.c": reference("cubemap")});
  check(/It belongs to another assignment[^\n]*\s+cubemap\.c: 8 /.test(elsewhere), "before a file goes to another assignment, the page asks", elsewhere);
  await answered(browser, "");
  await answered(browser, "");
  const refused = await opened(browser, {"solution.c": "int a;\n", "cut.zip": fs.readFileSync(path.join(at, "pack.zip")).subarray(0, 400), "normals.c": fs.readFileSync(path.join(at, "pack.zip")), "bloom.c": Buffer.from([0xff, 0xfe])});
  const words = ["solution.c is not named after an assignment", "cut.zip cannot be read", "bloom.c is not text in UTF-8"];
  check(/^Nothing was changed/.test(refused) && words.every((part) => refused.includes(part)), "what is no unit is refused, and why", refused);
  await answered(browser, "");
  const silent = await opened(browser, {"shading.c": reference("shading")}, true);
  check(silent === "" && (await text_in(browser)).includes("rk_shading"), "a file for this assignment is taken without a word", silent);
}

// The second tab is a page within the page, which a browser treats alike.
async function two_tabs(browser, address) {
  const other = "window[0]";
  await workbench(browser, address, "transparency");
  await browser.value(`void document.body.append(Object.assign(document.createElement("iframe"), {src: location.href, width: 900, height: 900}))`);
  await browser.until(`/claims hold/.test(${other}.${state})`);
  await type(browser, "int first;\n");
  await browser.until(`${other}.document.getElementById("shared").textContent`);
  const taken = await text_in(browser, other), told = await browser.value(`${other}.document.getElementById("shared").textContent`);
  check(taken.startsWith("int first;") && /^Another tab changed this text/.test(told), "what one tab keeps another shows, and says so", `${taken}\n${told}`);
  // Both, before either has heard of the other.
  await browser.value(`for (const [page, text] of [[window, "int second;"], [${other}, "int third;"]]) ${PUT}(page, text);`);
  await browser.until(`[window, ${other}].some(({document}) => document.querySelector("#shared button"))`);
  await browser.until(`[window, ${other}].every(({document}) => /found an error/.test(document.getElementById("state").textContent))`);
  const both = [await text_in(browser), await text_in(browser, other)];
  check(both[0] === both[1] && /^int (second|third);$/.test(both[0]), "of two texts typed at once one stands, in both tabs", both.join("\n"));
  await browser.value(`[window, ${other}].map(({document}) => document.querySelector("#shared button")).find(Boolean).click()`);
  await browser.until(`[window, ${other}].every(({document}) => /int (second|third);/.test(document.getElementById("text").textContent) && !document.getElementById("text").textContent.includes(${JSON.stringify(both[0])}))`);
  const swapped = [await text_in(browser), await text_in(browser, other)];
  check(swapped[0] === swapped[1] && both[0] !== swapped[0], "and the other can be taken", swapped.join("\n"));
  // The page that keeps something itself is told nothing of it, like one that was frozen.
  await browser.value(`(() => {
    const {doc, selection} = JSON.parse(localStorage.getItem("raykit:unit:transparency"));
    localStorage.setItem("raykit:unit:transparency", JSON.stringify({doc: doc + " // more", selection}));
    dispatchEvent(new Event("blur"));
  })()`);
  const after = await text_in(browser);
  check(after === `${swapped[0]} // more`, "a tab that was told nothing overwrites nothing", after);
}

// What a unit prints stands with the claim, cut.
async function printed(browser, address) {
  const begin = `#include "features/normals.h"\n#include <stdio.h>\n`, body = reference("normals").replace("return rk_vec(0.5f", `printf("n.x %d", 1);\n    fputs(" said", stderr);\n    return rk_vec(0.5f`);
  const shown = `[...document.querySelectorAll(".claims .printed")].map((one) => one.textContent)`;
  await workbench(browser, address, "normals");
  const fine = await type(browser, begin + body), with_fine = await browser.value(shown);
  check(/^(\d+) of \1/.test(fine) && with_fine.some((text) => /^(n\.x 1)+( said)+$/.test(text)), "what a claim has printed stands with it", with_fine.join("\n").slice(0, 2000));
  await type(browser, begin + body.replace("return rk_vec(0.5f", "while (n.x < 9) printf(\"0123456789\");\n    return rk_vec(0.5f"));
  const endless = await browser.value(`document.querySelector("#first .printed")?.textContent || ""`);
  check(endless.length > 1000 && endless.length < 3000 && endless.endsWith("(and more, not shown)"), "and of one that never ends its beginning", endless.slice(0, 300));
  await type(browser, begin + body.replace("return rk_vec(0.5f", "*(volatile int *)0 = 1;\n    return rk_vec(0.5f"));
  const fault = await browser.value(`document.querySelector("#first .printed")?.textContent || ""`);
  check(/^n\.x 1/.test(fault), "and of one that crashes", fault);
}

async function main() {
  if (!chromium || !made) {
    console.log(`1..0 # SKIP ${chromium ? "@yowasp/clang is missing: ./bootstrap --site" : "Chromium is missing: ./bootstrap --pdf"}`);
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-site-")), server = await serve(path.resolve("site"));
  const address = `http://127.0.0.1:${server.address().port}`;
  const in_new_browser = async (name, work) => {
    fs.mkdirSync(path.join(folder, name));
    const browser = new Browser(chromium, path.join(folder, name));
    try {
      return await work(browser);
    } finally {
      await browser.quit();
    }
  };
  try {
    const zip = await in_new_browser("first", (browser) => save_all(browser, address, folder));
    await in_new_browser("second", async (browser) => {
      await open_all(browser, address, zip);
      await open_others(browser, address, folder);
      await two_tabs(browser, address);
      await printed(browser, address);
    });
  } finally {
    server.close();
    fs.rmSync(folder, {recursive: true, force: true});
  }
  console.log(`1..${count}`);
  process.exitCode = failed ? 1 : 0;
}

main();
