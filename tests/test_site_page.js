// The workbench in a browser: what is typed into it is compiled there, and its claims say what the native suite says.
// Speaks TAP, for make check-site; runs in a build folder that has site/. Arguments: the source folder, Chromium,
// what make site has made, and axe-core ("" if missing).
"use strict";

const fs = require("fs");
const os = require("os");
const path = require("path");
const axe = require("./axe.js");
const {Browser} = require("./browser.js");
const {serve} = require("./site_server.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, chromium, made, axe_core] = process.argv.slice(2);
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

// With Ctrl.
async function press(browser, key, code, number) {
  for (const type of ["keyDown", "keyUp"])
    await browser.send("Input.dispatchKeyEvent", {type, key, code, windowsVirtualKeyCode: number, modifiers: 2});
}

// Replaces the text as typing does, and waits for the verdict. Returns {state, claims: {NAME: verdict and message}, said,
// seconds}.
async function type(browser, text) {
  await browser.value(`(() => {
    document.getElementById("state").textContent = "Typed";
    document.querySelector("#text .cm-content").focus();
  })()`);
  await press(browser, "a", "KeyA", 65);
  await browser.send("Input.insertText", {text});
  await browser.until(`/claims hold|finds an error|does not go on/.test(document.getElementById("state").textContent)`);
  return JSON.parse(await browser.value(`JSON.stringify({
    state: document.getElementById("state").textContent, said: document.getElementById("said").textContent,
    seconds: document.getElementById("seconds").textContent,
    first: document.getElementById("first").textContent,
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
}

// What was typed is there again, with its history, when the page is opened anew.
async function kept(browser, address, stem) {
  const whole = `[...document.querySelectorAll("#text .cm-line")].map((line) => line.textContent).join("\\n")`;
  await type(browser, "int first;\n");
  await type(browser, "int second;\n");
  await browser.open(`${address}/workbench.html?${stem}`);
  await browser.until(`/finds an error|claims hold/.test(document.getElementById("state").textContent)`);
  const again = await browser.value(whole);
  await browser.value(`document.querySelector("#text .cm-content").focus()`);
  await press(browser, "z", "KeyZ", 90);
  const undone = await browser.value(whole);
  check(again.startsWith("int second;") && undone.startsWith("int first;"), "a text is kept, with what can be undone", `${again} ${undone}`);
}

// After one visit the pages need no network.
async function offline(browser, server, address) {
  await browser.open(`${address}/index.html`);
  const is_kept = await browser.until(`navigator.serviceWorker.controller && navigator.serviceWorker.controller.state === "activated"`);
  const links = await browser.value(`document.querySelectorAll(".course a").length`);
  check(is_kept && links === 16, "the landing page leads to all assignments, and keeps the site", `${is_kept} ${links}`);
  await new Promise((resolve) => {
    server.close(resolve);
    server.closeAllConnections();
  });
  await browser.open(`${address}/workbench.html?shading`);
  await browser.until(`/claims hold|does not go on/.test(document.getElementById("state").textContent)`);
  const typed = await type(browser, fs.readFileSync(`${source}/src/features/shading.c`, "utf8"));
  check(/^(\d+) of \1 claims/.test(typed.state), "without a network, an assignment that was never opened is checked", JSON.stringify(typed, null, 1));
}

// For readers with weak sight or without a mouse, on a phone and on a desk.
async function for_all_readers(browser, address) {
  if (!axe_core) return console.log(`ok ${++count} - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live`);
  for (const [page, drawn] of [["index.html", "true"], ["workbench.html?shading", `document.getElementById("drawn").textContent !== ""`]]) {
    await browser.open(`${address}/${page}`, axe.read(axe_core));
    await browser.until(drawn);
    const found = await axe.findings(browser);
    check(found.length === 0, `axe-core finds nothing on ${page}`, found.join("\n"));
  }
  return browser.view(1280, "light");
}

async function mistakes(browser) {
  const text = fs.readFileSync(`${source}/src/features/normals.c`, "utf8");
  const halved = await type(browser, text.replace("0.5f + 0.5f * n.x, 0.5f + 0.5f * n.y", "1 + n.x, 1 + n.y"));
  check(/failed: got .*test_normals\.c:\d+/s.test(halved.claims.each_axis_has_a_colour_of_its_own),
    "a mistake is told by the claim's message", JSON.stringify(halved, null, 1));
  const broken = await type(browser, text.replace("return rk_vec(0.5f", "retrun rk_vec(0.5f"));
  check(/normals\.c:\d+:\d+: error/.test(broken.said), "a compiler's error names the line", JSON.stringify(broken, null, 1));
  check(/^The compiler finds an error.*line \d+$/s.test(broken.first), "and stands where it is seen first", broken.first);
  const loop = await type(browser, text.replace("return rk_vec(0.5f", "for (volatile int k = 0; k < 2; k = 0) { }\n    return rk_vec(0.5f"));
  const limits = Object.values(loop.claims).filter((said) => /no verdict after 1 s/.test(said)).length;
  check(/no verdict after 10 s/.test(loop.first) && limits > 0, "after two claims that did not end the others get less time", JSON.stringify(loop, null, 1));
  const wild = await type(browser, text.replace("return rk_normalize(", "float two[2] = {a.x, b.x};\n    int many = 0x7fffffff + (int)(a.x > -1e30f);\n    if (two[many & 1] > 1e30f) return a;\n    return rk_normalize("));
  check(/fault: the sum of two integers is beyond their type's range \(line \d+\)/.test(Object.values(wild.claims).join("\n")),
    "undefined behaviour is told with its kind and line", JSON.stringify(wild, null, 1));
}

async function main() {
  if (!chromium || !made) {
    console.log(`1..0 # SKIP ${chromium ? "@yowasp/clang is missing: ./bootstrap --site" : "Chromium is missing: ./bootstrap --pdf"}`);
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-site-"));
  const server = await serve(path.resolve("site")), browser = new Browser(chromium, folder);
  try {
    const address = `http://127.0.0.1:${server.address().port}`;
    await workbench(browser, address, "normals");
    await mistakes(browser);
    await kept(browser, address, "normals");
    await for_all_readers(browser, address);
    await workbench(browser, address, "bvh_median");
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
