// Live figures: the drivers' WebAssembly module draws the same pictures as the drivers, and a woven page shows
// them, turns what is typed and dragged into options, and explains pixels; make live-STEM shows each save. Speaks TAP, for make check-live; runs in a
// build folder. Arguments: the source folder, pandoc, Chromium and axe-core ("" if missing).
"use strict";

const {execFileSync, spawn} = require("child_process");
const fs = require("fs");
const http = require("http");
const os = require("os");
const path = require("path");
const vm = require("vm");
const zlib = require("zlib");
const {Browser} = require("./browser.js");
const {decode} = require("./png.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, pandoc, chromium, script] = process.argv.slice(2);
const build = process.cwd();
// A name longer than a narrow page, as folders of students have them: the page shows the file's path.
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit_live_for_a_student_with_a_folder_of_a_long_name_"));
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

// --- pictures ------------------------------------------------------------------------------------

function native(driver, args, table = "") {
  const program = fs.readdirSync("assignments").find((name) => name.replace(/^\d+_/, "") === driver);
  if (table) fs.rmSync(path.join(folder, "tables", `${table}.csv`), {force: true}); // rows of other options
  const printed = execFileSync(path.join(build, "assignments", program, driver), [...args, "--out", folder],
    {encoding: "utf8", stdio: ["ignore", "pipe", "inherit"]});
  const picture = printed.match(/^(.*\.png): /m);
  return {printed, picture: picture && decode(picture[1]), rows: table ? rows_of(table) : []};
}

// The rows of a table that the drivers put, as texts by column; their cells need no quotes.
function rows_of(table) {
  const [header, ...lines] = fs.readFileSync(path.join(folder, "tables", `${table}.csv`), "utf8").trim().split("\n").map((line) => line.split(","));
  return lines.map((cells) => Object.fromEntries(header.map((name, i) => [name, cells[i]])));
}

// "" if two pictures are equal, else how they differ.
function difference(wanted, rgba, width, height) {
  if (wanted.width !== width || wanted.height !== height) return `${width} x ${height}, not ${wanted.width} x ${wanted.height}`;
  let values = 0, most = 0;
  for (let i = 0; i < wanted.rgb.length; i++) {
    const off = Math.abs(wanted.rgb[i] - rgba[Math.floor(i / 3) * 4 + i % 3]);
    values += off ? 1 : 0;
    most = Math.max(most, off);
  }
  return values ? `${values} of ${wanted.rgb.length} values differ, by at most ${most}` : "";
}

// --- the module ----------------------------------------------------------------------------------

for (const name of ["run.js", "arguments.js"]) vm.runInThisContext(fs.readFileSync(`${source}/tools/live/${name}`, "utf8"));
const module_ = new WebAssembly.Module(fs.readFileSync("live/raykit.wasm"));

// Of each driver the first three command lines in its look.tsv and its chapter's live figures.
function command_lines(name) {
  const stem = name.replace(/^\d+_/, ""), lines = new Set();
  const chapter = fs.readFileSync(`${source}/docs/${name}.md`, "utf8");
  for (const [, driver, args] of chapter.matchAll(/^:+ \{\.live driver=(\w+) args="([^"]*)"/gm)) if (driver === stem) lines.add(args);
  const look = fs.readFileSync(`${source}/assignments/${name}/look.tsv`, "utf8").trim().split("\n").slice(1);
  for (const row of [...look.map((line) => line.split("\t")[1]), "--scene cornell", "--scene teapot --shadows"]) lines.add(row);
  return [...lines].slice(0, 3);
}

function module_draws_like_the_drivers() {
  for (const name of fs.readdirSync("assignments").filter((entry) => /^\d+_/.test(entry)).sort()) {
    const driver = name.replace(/^\d+_/, ""), wrong = [];
    for (const line of command_lines(name)) {
      const side = line.includes("--pixel") ? "480" : "120"; // where the pixel is
      const args = [...line.split(/\s+/).filter((word) => word), "--width", side, "--height", side];
      const wanted = native(driver, args), drawn = runDriver(module_, [driver, ...args]);
      const why = drawn.status !== 0 ? drawn.said : !drawn.picture ? "no picture"
        : difference(wanted.picture, drawn.picture.rgba, drawn.picture.width, drawn.picture.height);
      if (why) wrong.push(`${driver} ${args.join(" ")}: ${why}`);
    }
    check(wrong.length === 0, `${driver} draws the same in WebAssembly, to the bit`, wrong.join("\n"));
  }
}

function module_prints_like_the_drivers() {
  const ask = ["--shadows", "--pixel", "60,60", "--width", "120", "--height", "120"];
  const said = (text) => text.split("\n").filter((line) => !line.includes(".png: ")).join("\n"); // that line has times
  const printed = said(runDriver(module_, ["shading", ...ask]).printed), wanted = said(native("shading", ask).printed);
  check(printed === wanted, "a pixel is explained in the driver's words", `${printed}\n-- instead of --\n${wanted}`);
  const unknown = runDriver(module_, ["bloom", "--bloom-radios", "3"]);
  check(unknown.status === 1 && /there is no such option/.test(unknown.said), "an unknown option ends with the driver's message",
    JSON.stringify(unknown));
  const mesh = runDriver(module_, ["bloom", "--mesh", "a.obj"]);
  check(mesh.status === 1 && /a page reads no files/.test(mesh.said), "a mesh file is refused with a reason", JSON.stringify(mesh));
}

// --- controls --------------------------------------------------------------------------------------

// What a figure's widget alone shows, or shows once a widget has moved something.
const BY_WIDGET = {lobes: {names: ["shininess", "ks"]}, motion: {moves: ["shutter-close", "500"]}};

const changed = (args, name, value) => {
  const map = new Map(args);
  if (value === null) map.delete(name);
  else map.set(name, value);
  return map;
};

// All choices, or the ends and the middle of a range; null stands for the default.
function values_of({limits}, row) {
  if (row.kind === "flag") return [null, true];
  if (row.kind !== "uint" && row.kind !== "float") return (limits !== undefined ? limits.split("|") : row.names).map((value) => value || null);
  const [low, high] = limits ? limits.split("..").map(Number) : [row.low, row.high];
  const middle = low > 0 && high / low >= 100 ? Math.sqrt(low * high) : (low + high) / 2;
  return [low, row.kind === "uint" ? Math.round(middle) : middle, high];
}

// A live figure of a chapter, in a quarter of its size.
function figure_of(text) {
  const [, attributes] = text.match(/\{\.live ([^}]*)\}/), at = (name) => (attributes.match(`${name}="?([^" ]*|(?<=")[^"]*)"?(?: |$)`) || [])[1];
  const [, given] = attributes.match(/args="([^"]*)"/), [, options] = attributes.match(/options="([^"]*)"/), driver = at("driver");
  const rows = JSON.parse(runDriver(module_, [driver, "--help"]).printed), args = parseArguments(given);
  for (const side of ["width", "height"]) args.set(side, Math.round((args.get(side) || 480) / 4));
  if (args.has("pixel")) args.set("pixel", args.get("pixel").split(",").map((x) => Math.floor(x / 4)).join());
  return {driver, rows, args, offers: options.split(/\s+/).map((word) => parseOffer(word, rows)), widget: at("widget"), clicks: at("click") !== "no"};
}

// Presses each control to each value in each view, and clicks in each; returns what fails, and controls that change nothing.
function press_all({driver, rows, args, offers, widget, clicks}) {
  const wrong = [], views = offers.find(({name}) => name === "debug"), by = BY_WIDGET[widget] || {};
  const run = (map) => {
    const words = wordsOf(belonging(map, offers, rows)), result = runDriver(module_, [driver, ...words]);
    if (result.status !== 0) wrong.push(`${words.join(" ")}: ${result.said.trim()}`);
    return result.picture ? Buffer.from(result.picture.rgba).toString("latin1") : "";
  };
  const changes = (offer, start) => new Set(values_of(offer, rows[offer.name]).map((value) => run(changed(start, offer.name, value)))).size > 1;
  for (const view of views ? values_of(views, rows.debug) : [args.get("debug") || null]) {
    const start = changed(args, "debug", view);
    for (const offer of offers) {
      if (offer === views || !goesWith(offer, start)) continue;
      const larger = new Map([...start, ["width", 4 * args.get("width")], ["height", 4 * args.get("height")]]);
      const alive = changes(offer, start) || (by.names || []).includes(offer.name) || (by.moves && changes(offer, changed(start, ...by.moves))) ||
        (!start.has("pixel") && changes(offer, larger));
      if (!alive) wrong.push(`${offer.name} changes nothing with debug ${view || "none"}`);
    }
    if (clicks) run(new Map([...changed(start, "debug", null), ["pixel", "20,20"], ["pixel-code", true], ["pixel-rays", true]]));
  }
  return wrong;
}

// All live figures of a chapter.
function figures_of(name) {
  return [...fs.readFileSync(`${source}/docs/${name}`, "utf8").matchAll(/^:+ \{\.live .*\}$/gm)].map(([text]) => figure_of(text));
}

// Frames whose scene has the same options are drawn by the instance that has it, unless the driver looks from a place of its own.
function a_scene_is_kept_between_frames() {
  const wrong = [], kept = {};
  let count = 0;
  for (const name of fs.readdirSync(`${source}/docs`).filter((entry) => entry.endsWith(".md")).sort()) for (const {driver, args} of figures_of(name)) {
    args.delete("pixel"); // not in each frame
    if (args.get("debug") === "rays") continue;
    for (const more of [[], ["--yaw", "25", "--pitch", "10"], ["--yaw", "50"], ["--width", "70", "--height", "50"]]) {
      const line = [driver, ...wordsOf(new Map([...args, ...parseArguments(more.join(" "))]))], drawn = runDriver(module_, line, undefined, kept), fresh = runDriver(module_, line);
      count += drawn.kept ? 1 : 0;
      if (drawn.status !== 0 || !drawn.picture || Buffer.compare(drawn.picture.rgba, fresh.picture.rgba) !== 0) wrong.push(line.join(" "));
    }
  }
  check(wrong.length === 0, "a kept scene is drawn from elsewhere, and in another size, to the bit as a new one", wrong.join("\n"));
  check(count >= 3 * 15, "it is kept for nearly all figures", `${count} of the frames had a kept scene`);
  const other = runDriver(module_, ["bloom", "--scene", "no-such"], undefined, kept), after = runDriver(module_, ["bloom", "--width", "20", "--height", "20"], undefined, kept);
  check(other.status === 1 && after.status === 0 && !after.kept, "after an error nothing is kept", JSON.stringify([other.status, after.status, after.kept]));
}

// In ms, or on a busy machine in s.
const withoutTimes = (text) => text.replace(/\d[\d.e+]* m?s\b/g, "");

// Each option at each of its values, after the figure's own picture; the scene is made anew for those that --help says are of_scene.
function each_option_draws_with_a_kept_scene() {
  const wrong = [], sliders = [];
  for (const name of fs.readdirSync(`${source}/docs`).filter((entry) => entry.endsWith(".md")).sort()) for (const {driver, args, offers, rows} of figures_of(name)) {
    const kept = {}, run = (map, kept) => runDriver(module_, [driver, ...wordsOf(belonging(map, offers, rows))], undefined, kept);
    for (const offer of offers) for (const value of values_of(offer, rows[offer.name])) {
      const first = run(args, kept), map = changed(args, offer.name, value), drawn = run(map, kept), fresh = run(map), line = `${name}: ${offer.name} ${value}`;
      if (drawn.status !== fresh.status || withoutTimes(drawn.printed) !== withoutTimes(fresh.printed) ||
        (fresh.picture && Buffer.compare(drawn.picture.rgba, fresh.picture.rgba) !== 0)) wrong.push(line);
      if (first.status === 0 && !rows[offer.name].of_scene && ["uint", "float"].includes(rows[offer.name].kind) && !drawn.kept) sliders.push(line);
    }
  }
  check(wrong.length === 0, "each option of each figure draws with a kept scene as with a new one, to the bit", wrong.join("\n"));
  check(sliders.length === 0, "a slider of the picture keeps the scene", sliders.join("\n"));
}

function every_control_does_something() {
  for (const name of fs.readdirSync(`${source}/docs`).filter((entry) => entry.endsWith(".md")).sort()) {
    const wrong = figures_of(name).map(press_all);
    if (wrong.length) check(wrong.flat().length === 0, `${name}: each control draws at each of its values, in each view, and changes the picture`, wrong.flat().join("\n"));
  }
}

// --- the page ------------------------------------------------------------------------------------

const FIGURE = {driver: "bloom", args: "--bloom-threshold 0.5 --bloom-radius 15 --width 200 --height 160"};

const OPTIONS = "bloom-threshold=0..1 bloom-radius=1..100 scene=teapot|cornell debug=|mask";

// A page with one live figure; widget: the part that it alone has.
function weave({driver, args}, options, widget = "") {
  const text = path.join(folder, "page.md"), page = path.join(folder, `${driver}${widget}.html`);
  fs.mkdirSync(path.join(folder, "figures"), {recursive: true});
  fs.writeFileSync(text, `# A page {#a-page}\n\n::: {.live driver=${driver} args="${args}" options="${options}" ${widget}}\nA caption.\n:::\n`);
  execFileSync(pandoc, ["--standalone", "--self-contained", "--from=commonmark_x+sourcepos", "--to=html5", `--resource-path=${folder}`,
    `--lua-filter=${source}/docs/weave.lua`, `--template=${source}/tools/weave/template.html`, "--metadata=title:live", `--output=${page}`, text],
  {stdio: ["ignore", "ignore", "pipe"], env: {...process.env, RAYKIT_WEAVES: "book", RAYKIT_SOURCE: source, RAYKIT_SOURCE_LINK: source,
    RAYKIT_BUILD: build, RAYKIT_DRIVERS: build, RAYKIT_OUT: folder, RAYKIT_SCRAPS: folder, RAYKIT_STORE: path.join(folder, "drawn"), RAYKIT_RUNS: "1", RAYKIT_ALONE: "",
    RAYKIT_LIVE: path.join(build, "live/raykit.wasm")}});
  return page;
}

const drawn = (args) => `document.querySelector(".live").dataset.drawn === ${JSON.stringify(args)}`;

// How the canvas differs from the driver's picture of the command under it.
async function differs(browser, driver = FIGURE.driver) {
  const args = (await browser.value('document.querySelector(".live .command").textContent')).split(" ").slice(1);
  const {width, height, bytes} = await browser.value(`(() => {
    const canvas = document.querySelector(".live canvas"), {width, height} = canvas;
    return {width, height, bytes: Array.from(canvas.getContext("2d").getImageData(0, 0, width, height).data)};
  })()`);
  return difference(native(driver, args).picture, bytes, width, height);
}

async function page_is_live(browser, page) {
  await browser.open(`file://${page}`);
  const live = await browser.until(drawn(FIGURE.args));
  check(live, "a page opened as a file draws its figure", "no picture within 30 seconds");
  if (!live) return;
  const first = await differs(browser);
  check(!first, "the picture is the driver's, to the bit", first);

  await browser.value(`(() => {
    const slider = document.querySelector(".live input[name=bloom-radius]");
    slider.value = 1000;
    slider.dispatchEvent(new Event("input"));
    slider.dispatchEvent(new Event("change"));
  })()`);
  const moved = await browser.until(drawn(FIGURE.args.replace("radius 15", "radius 100")));
  const second = moved ? await differs(browser) : "no new picture within 30 seconds";
  check(!second, "a slider at its end draws the driver's picture of that option", second);

  const box = await browser.value(`(() => {
    const {left, top, width, height} = document.querySelector(".live canvas").getBoundingClientRect();
    return {left, top, width, height};
  })()`);
  const at = (x, y) => [box.left + (x + .5) / 200 * box.width, box.top + (y + .5) / 160 * box.height];
  await browser.mouse("mousePressed", ...at(100, 80));
  await browser.mouse("mouseReleased", ...at(100, 80));
  await browser.until('document.querySelector(".live").dataset.explained');
  const story = await browser.value('[...document.querySelectorAll(".live .story pre:not(.code) span")].map((step) => step.textContent).join("\\n")');
  const wanted = native(FIGURE.driver, [...FIGURE.args.replace("radius 15", "radius 100").split(" "), "--pixel", "100,80"]).printed;
  check(story && wanted.startsWith(story), "a click shows the driver's explanation of the pixel", `${story}\n-- instead of --\n${wanted}`);

  const lines = await browser.value(`(() => {
    const next = document.querySelectorAll(".live .story button")[1], lines = [];
    for (const step of document.querySelectorAll(".live .story pre:not(.code) span")) {
      const code = document.querySelector(".live .story .code");
      if (step.dataset.code) lines.push([step.dataset.code, code.hidden, code.querySelector(".now").textContent]);
      next.click();
    }
    return lines;
  })()`);
  const unshown = lines.filter(([code, hidden, line]) => hidden || !line.includes(code.split(": ")[1]));
  check(lines.length > 3 && unshown.length === 0, "beside each step is the line of C that does it", JSON.stringify(lines));

  await browser.mouse("mousePressed", ...at(100, 80));
  for (let x = 100; x <= 150; x += 10) await browser.mouse("mouseMoved", ...at(x, 80));
  await browser.mouse("mouseReleased", ...at(150, 80));
  const turned = await browser.until(`(() => {
    const command = document.querySelector(".live .command").textContent;
    return /--yaw/.test(command) && command.endsWith(" " + document.querySelector(".live").dataset.drawn);
  })()`);
  const third = turned ? await differs(browser) : "the command has no --yaw";
  check(!third, "dragging turns the camera", third);

  // A click while the picture of another option is drawn.
  await browser.value(`(() => {
    delete document.querySelector(".live").dataset.explained;
    const box = document.querySelector(".live canvas").getBoundingClientRect();
    document.querySelector(".live input[name=bloom-radius]").dispatchEvent(new Event("change"));
    for (const type of ["pointerdown", "pointerup"]) document.querySelector(".live canvas").dispatchEvent(new PointerEvent(type, {clientX: box.left + box.width / 2, clientY: box.top + box.height / 2}));
  })()`);
  check(await browser.until('document.querySelector(".live").dataset.explained'), "a click while the figure is drawn is answered afterwards");
  for (const width of [1280, 390]) {
    await browser.view(width, "light");
    const cut = await browser.value('[...document.querySelectorAll(".live .story pre:not([hidden])")].filter((pre) => pre.scrollWidth > pre.clientWidth || pre.clientWidth === 0).length');
    check(cut === 0, `at ${width} px no line of an explanation is cut`, cut);
  }
  await browser.view(1280, "light");
}

// Over the picture, at the places that the driver prints.
async function a_clicked_pixel_shows_its_rays(browser) {
  const args = "--scene cornell --shadows --reflections --width 120 --height 120";
  await browser.open(`file://${weave({driver: "shading", args}, "shadows")}`);
  await browser.until('document.querySelector(".live").dataset.drawn');
  for (const [pixel, legend] of [["37,95", "shadow ray, reaches the light; reflected ray"], ["100,107", "shadow ray, does not reach it"]]) {
    const [x, y] = await browser.value(`(() => {
      const {left, top, width} = document.querySelector(".live canvas").getBoundingClientRect();
      return [${pixel}].map((at, i) => [left, top][i] + (at + .5) / 120 * width);
    })()`);
    for (const type of ["mousePressed", "mouseReleased"]) await browser.mouse(type, x, y);
    await browser.until(`document.querySelector(".live").dataset.explained === "${pixel}"`);
    const shown = await browser.value(`({
      lines: [...document.querySelectorAll(".live .rays line:not(.under)")].map((line) => [line.getAttribute("class"), ...["x1", "y1", "x2", "y2"].map((name) => line.getAttribute(name))].join(" ")),
      legend: [...document.querySelectorAll(".live .legend span")].map((part) => part.textContent).join("; "),
      over: ["canvas", "svg.rays"].map((part) => JSON.stringify(document.querySelector(".live " + part).getBoundingClientRect())),
      view: document.querySelector(".live svg.rays").getAttribute("viewBox")})`);
    const wanted = native("shading", [...args.split(" "), "--pixel", pixel, "--pixel-rays"]).printed.match(/^@ (?!camera).*/gm).map((line) => line.slice(2));
    check(wanted.length > 0 && shown.lines.sort().join() === wanted.sort().join() && shown.view === "0 0 120 120" && shown.over[0] === shown.over[1],
      `the rays of pixel ${pixel} are drawn where the driver says`, `${JSON.stringify(shown)}\n-- instead of --\n${wanted}`);
    check(shown.legend === legend, "with a legend of those that there are", shown.legend);
    const under = await browser.value('[...document.querySelectorAll(".live line.under")].map((line) => getComputedStyle(line).stroke)');
    check(under.length > shown.lines.length && under.every((colour) => colour === "rgb(0, 0, 0)"), "each on a dark line, which is seen where the page or the picture is light", under.join());
  }
  await browser.value('document.querySelector(".live input[name=shadows]").click()');
  check(await browser.until('document.querySelectorAll(".live .rays line").length === 0 && !document.querySelector(".live .legend span")'), "a new setting takes them away");
}

async function a_clicked_pixel_tells_its_fraction(browser) {
  const args = "--debug rays --light-samples 16 --light-visibility rays --pixel 51,52 --width 60 --height 60";
  await browser.open(`file://${weave({driver: "parallelogram_light", args}, "light-samples=1..64", "click=draw")}`);
  await browser.until('document.querySelector(".live").dataset.drawn');
  const said = await browser.value('document.querySelector(".live .says").textContent'), [wanted] = native("parallelogram_light", args.split(" ")).printed.match(/^pixel .*/m) || ["no line of the pixel"];
  check(/unoccluded: a fraction of [\d.]+$/.test(wanted) && said.startsWith(wanted), "the fraction of the light that a pixel sees is told as a number", `${said}\n-- instead of --\n${wanted}`);
}

async function page_stays_without_webassembly(browser, page) {
  await browser.open(`file://${page}`, "delete window.WebAssembly");
  await browser.until('document.readyState === "complete"');
  await new Promise((resolve) => setTimeout(resolve, 500));
  const kept = await browser.value('Boolean(document.querySelector(".live img[src^=data]") && !document.querySelector("canvas"))');
  check(kept, "without WebAssembly the driver's picture stays");
}

// --- make live-STEM ------------------------------------------------------------------------------

// The state that the page is told of, once it fulfils the condition; null after two minutes.
async function told(url, condition) {
  const limit = AbortSignal.timeout(120000);
  let text = "";
  try {
    for await (const part of (await fetch(`${url}/events`, {signal: limit})).body) {
      text += Buffer.from(part).toString();
      for (const [, line] of text.matchAll(/^data: (.*)\n\n/gm)) if (condition(JSON.parse(line))) return JSON.parse(line);
      text = text.slice(text.lastIndexOf("\n\n") + 2);
    }
  } catch (error) {
    if (!limit.aborted) throw error;
  }
  return null;
}

const words = (browser, place) => browser.value(`document.querySelector("${place}").innerText`);

// What the page of a claim that fails shows, and that it asks for nothing else.
async function loop_shows_the_task(browser) {
  const first = await words(browser, "#first"), step = await words(browser, "#step-1.current"), place = await words(browser, "#path");
  check(/^Step 1: lambert falls with the cosine\s+got.x: got 0.5, want 1 .*\s+in tests\/test_shading.c:\d+/.test(first), "the page begins with the claim to work on, what it got, and where", first);
  check(/rk_shade: off, Lambert/.test(step) && /Given/.test(step) && /Hint: a nudge/.test(step), "its step says what to write, what is given, and hints", step);
  check(place === path.join(folder, "shading.c"), "it names the file to edit", place);
  const said = await words(browser, "#drawn");
  check(/^Step 1: the picture differs in \d+ % of the 400 x 400 pixels, most at \d+,\d+; teapot/.test(said), "the comparison stands below the pictures", said);
  const marks = await browser.value(`[...document.querySelectorAll(".claims li[data-verdict]")].map((item) => item.dataset.verdict)`);
  check(marks.length > 30 && new Set(marks).size === 2 && marks.includes("failed"), "each claim has its verdict", marks.join());
  const loaded = await browser.value(`performance.getEntriesByType("resource").map(({name}) => name.replace(/.*:\\d+|\\?.*/g, "")).filter((name) => !name.startsWith("/picture/")).sort().join()`);
  const wanted = ["/elements.mjs", "/icon.svg", "/native.mjs", "/pixel.mjs", "/ray_trees.mjs", "/said.mjs", "/task", "/task.mjs", "/verdicts.mjs", "/workbench.css"];
  check(loaded === wanted.join(), "it loads neither compiler nor editor", loaded);
  const absent = await browser.value(`["#text", "#save", "#open", "#again", "#assignment", ".cm-editor", "[rel=manifest]"].filter((part) => document.querySelector(part)).join() + navigator.serviceWorker.controller`);
  check(absent === "null", "and has none of their controls", absent);
}

// The header of what is given, from the server.
async function loop_shows_a_header(browser) {
  await browser.value('document.querySelector("#first p button.place").click()');
  const line = await words(browser, "#header_text mark"), [, number] = (await words(browser, "#header_name")).match(/^test_shading\.c, line (\d+)$/) || [];
  check(line && line.trim() === fs.readFileSync(`${source}/tests/test_shading.c`, "utf8").split("\n")[number - 1].trim(), "the place of a claim that fails leads to the suite's line", `${number} ${line}`);
  await browser.value('document.getElementById("header_close").click()');

  await browser.value('document.querySelector("#step-1 button.place").click()');
  await browser.until('document.getElementById("header").open');
  const header = await words(browser, "#header");
  check(/^[a-z]+\/\w+\.h\s[^]*\brk_\w+/.test(header), "a button shows the header of what is given", header.slice(0, 200));
  await browser.value('document.getElementById("header_close").click()');
}

// A state in which the next assignment waits, as make start tells it.
async function loop_goes_on(browser) {
  await browser.value('events_of_page.onmessage({data: JSON.stringify({...JSON.parse(events_of_page.last), next: "bloom"})})');
  check(await browser.until(`document.querySelector("#state button").textContent === "go on to bloom"`), "a button leads to the next assignment", await words(browser, "#state"));
  await browser.value('document.querySelector("#state button").click()');
  check(await browser.until('performance.getEntriesByType("resource").some(({name}) => name.endsWith("/next"))'), "and tells the server");
}

// Keeps what the page is told.
const LISTENS = `{
  const Source = EventSource;
  EventSource = class extends Source {
    constructor(address) {
      super(address);
      globalThis.events_of_page = this;
      this.addEventListener("message", ({data}) => { this.last = data; });
    }
  };
}`;

// A click on the student's picture: two trees of rays, and where they begin to differ.
async function loop_compares_rays(browser, url, lint) {
  await browser.open(url, LISTENS + (lint ? lint.before : ""));
  await browser.until('document.querySelector("#own").width === 400 && document.querySelector("#own").checkVisibility() && document.querySelector("#steps .current")');
  await loop_shows_the_task(browser);
  await loop_shows_a_header(browser);
  await loop_goes_on(browser);
  await browser.value('document.querySelector("#own").scrollIntoView({block: "center"})');
  const {left, top, width, height} = await browser.value('(({left, top, width, height}) => ({left, top, width, height}))(document.querySelector("#own").getBoundingClientRect())');
  for (const type of ["mousePressed", "mouseReleased"]) await browser.mouse(type, left + width / 2, top + height / 2);
  await browser.until('document.querySelector("#explained").dataset.of');
  const {marked, values, nested, folded} = await browser.value(`({
    marked: [...document.querySelectorAll(".tree mark")].map((mark) => mark.textContent.replace(/ .*/, "")).join(),
    values: [...document.querySelectorAll("#explained td code")].map((code) => code.textContent),
    nested: document.querySelectorAll(".tree:first-of-type details details details").length,
    folded: document.querySelectorAll(".tree details:not([open])").length})`);
  check(marked === "adds,adds" && values.length === 2 && values[0] !== values[1], "a click marks where the rays of two units begin to differ, with both values",
    JSON.stringify({marked, values}));
  check(nested === 2 && folded === 0, "lights are nested in hits, and hits in rays", JSON.stringify({nested, folded}));
  await browser.value('document.querySelector("#own").focus()');
  for (const key of ["ArrowRight", "ArrowDown", "Enter"]) await browser.key(key);
  check(await browser.until('document.querySelector("#explained").dataset.of === "201,201"'), "by keys, arrows aim at a pixel, and Enter asks", await words(browser, "#pixel"));
  await browser.value('document.querySelector("#drawn button").click()');
  const [place] = (await words(browser, "#drawn")).match(/\d+,\d+(?=;)/);
  check(await browser.until(`document.querySelector("#explained").dataset.of === "${place}"`), "the place where the pictures differ most is explained by a click, too", place);
  if (lint) await lint.lint("the page of the live loop, with a pixel explained");
}

async function loop_shows_each_save(browser, lint) {
  const unit = path.join(folder, "shading.c"), solution = fs.readFileSync(`${source}/src/features/shading.c`, "utf8");
  fs.writeFileSync(unit, solution);
  const make = spawn(process.env.MAKE || "make", ["-s", "live-shading", `IMPL=${unit}`, "STEP=1"], {stdio: ["ignore", "pipe", "inherit"], detached: true});
  try {
    let said = "";
    await new Promise((resolve) => make.stdout.on("data", (part) => { // on to the end: a closed pipe would end the loop
      said += part;
      if (/http:\S+\//.test(said)) resolve();
    }).on("end", resolve));
    const url = said.match(/http:\S+(?=\/)/)[0];
    const solved = await told(url, (known) => known.same && !known.busy);
    check(solved && /^ok/m.test(solved.claims), "the live loop shows that a solution's picture and claims are right", JSON.stringify(solved));
    fs.writeFileSync(unit, solution.replace("rk_scale(kd, diffuse));", "rk_scale(kd, 0.5f * diffuse));"));
    const wrong = await told(url, (known) => known.compared && !known.same && !known.busy);
    const {steps: [{hints}]} = await (await fetch(`${url}/task`)).json();
    check(wrong && /FAIL/.test(wrong.claims) && hints.length && wrong.pictures.difference && wrong.broken.length > 1 &&
      wrong.broken.every((claim) => claim.reason), "after a save with a mistake it shows the difference, the failed claims and hints", JSON.stringify(wrong));
    await fetch(`${url}/look?2`);
    const other = await told(url, (known) => known.step === 2 && known.drawn && !known.busy);
    await fetch(`${url}/look?1`);
    const back = await told(url, (known) => known.step === 1 && known.drawn && !known.busy);
    check(other && back && other.command !== back.command, "it draws another step when asked", JSON.stringify([other, back]));
    if (browser) {
      await loop_compares_rays(browser, url, lint);
      fs.writeFileSync(unit, solution);
      check(await browser.until('document.querySelector("#claims.old") && /^before this save/.test(document.querySelector("#claims").textContent)'),
        "while claims are checked, those of the save before are marked as old");
      check(await browser.until('document.querySelector("#explained").textContent.includes("Both explain this pixel alike") && !document.querySelector("#claims.old")'),
        "after the next save, the same pixel is explained again", await browser.value("document.body.innerText"));
    }
    fs.writeFileSync(unit, solution.replace(/^rk_vec3 rk_shade\([^{]*\{/m, "$&\n    kd.x == 2;"));
    const warned = await told(url, (known) => known.warned && !known.busy);
    check(warned && /^[^\n]*shading\.c:\d+:\d+: warning: /m.test(warned.warned) && /^ok/m.test(warned.claims), "where all claims hold the compiler's warnings are told", JSON.stringify(warned));
    if (browser) {
      await browser.until('document.querySelector("#findings li")');
      const findings = await words(browser, "#compiler");
      check(/^The compiler warns:\s+shading\.c:\d+: warning: /.test(findings), "and the page has them", findings);
    }
    fs.writeFileSync(unit, "#error unfinished\n");
    const unfinished = await told(url, (known) => known.failed && !known.busy);
    check(unfinished && /unfinished/.test(unfinished.failed) && !unfinished.drawn && unfinished.pictures.own,
      "a unit that does not compile leaves the last picture, and does not call it this save's", JSON.stringify(unfinished));
    if (browser) {
      await browser.until('document.querySelector("#state").textContent === "The compiler found an error"');
      const shown = await browser.value('["#first", "#said", "#whose"].map((place) => document.querySelector(place).innerText).join("|")');
      check(/^The compiler found an error\s+#error unfinished\s+in shading.c:1\|.*shading.c:1:2: error: #error unfinished[^]*\|by your code, before this save$/.test(shown), "and the page has the compiler's words", shown);
      if (lint) await lint.lint("the page of the live loop, with a unit that does not compile");
    }
    fs.writeFileSync(unit, solution.replace(/^rk_vec3 rk_shade\([^{]*\{/m, "$&\n    for (volatile int i = 1; i; i = 1)\n        ;"));
    const endless = await told(url, (known) => known.busy.includes("checking") && known.late.some((claim) => /^still running after .* s \(it took .* s before\): perhaps an endless loop$/.test(claim.reason)));
    check(endless && endless.held.length + endless.broken.length + endless.late.length < endless.of, "an endless loop is told soon where claims passed before, while others are still checked", JSON.stringify(endless));
    const slow = "for (volatile int i = 0; kd.z == 1e-10f && i < 1500000000; i++)\n        ;"; // in a call of one claim
    fs.writeFileSync(unit, solution.replace(/^rk_vec3 rk_shade\([^{]*\{/m, `$&\n    ${slow}`));
    const late = await told(url, (known) => known.drawn && !known.busy);
    check(late && /^ok/m.test(late.claims) && late.held.length === late.of && !late.late.length, "a unit that is much slower than before, but right, is right", JSON.stringify(late));
    const {hostname, port} = new URL(url);
    const status = await new Promise((resolve) => http.get({hostname, port, path: "/events", headers: {Host: "elsewhere.example"}},
      (answer) => resolve(answer.statusCode)));
    check(status === 403, "it refuses a request that names another host", status);
  } finally {
    process.kill(-make.pid, "SIGTERM");
  }
}

// The picture of the step that is reached, with a word on the one that is left; and a picture that does not show a mistake.
async function loop_follows_the_steps(browser) {
  const unit = path.join(folder, "normals.c"), solution = fs.readFileSync(`${source}/src/features/normals.c`, "utf8");
  const first = solution.replace(/rk_sub\(b, a\), rk_sub\(c, a\)/, "a, a");
  fs.writeFileSync(unit, first.replace("0.5f + 0.5f * n.x", "0.5f * n.x"));
  const make = spawn(process.env.MAKE || "make", ["-s", "live-normals", `IMPL=${unit}`], {stdio: ["ignore", "pipe", "inherit"], detached: true});
  try {
    let said = "";
    await new Promise((resolve) => make.stdout.on("data", (part) => {
      said += part;
      if (/http:\S+\//.test(said)) resolve();
    }).on("end", resolve));
    const url = said.match(/http:\S+(?=\/)/)[0];
    const begun = await told(url, (known) => known.step === 1 && known.drawn && !known.busy);
    const {steps: [{write, given}]} = await (await fetch(`${url}/task`)).json();
    check(begun && begun.task === 1 && /rk_normals_colour/.test(write) && given.length, "it names what is to be written, and what is given for it", JSON.stringify([begun, write, given]));
    check(begun && begun.unwritten.length === 0, "what is written is not called unwritten", JSON.stringify(begun));
    check(begun && !begun.passed, "the live loop begins with the first step that is broken", JSON.stringify(begun));
    fs.writeFileSync(unit, first);
    const passed = await told(url, (known) => known.step === 2 && known.drawn && !known.busy);
    check(passed && passed.passed === "all claims up to step 1 hold, and the picture of step 1 is the wanted one" && !passed.same,
      "once its claims hold, it turns to the next, and says that the picture before was right", JSON.stringify(passed));
    fs.writeFileSync(unit, solution.replace(/rk_sub\(b, a\), rk_sub\(c, a\)/, "rk_sub(c, a), rk_sub(b, a)"));
    const turned = await told(url, (known) => known.same && known.broken.length && !known.busy);
    check(turned && turned.step === 2 && !turned.passed, "normals that point inwards draw the wanted picture, and break claims", JSON.stringify(turned));
    if (browser) {
      await browser.open(url);
      check(await browser.until('/the wanted picture, but some claims up to this step fail, which it does not show/.test(document.querySelector("#drawn").textContent)'),
        "the page then says that the claims decide", await browser.value("document.body.innerText"));
    }
    fs.writeFileSync(unit, solution.replace(/^ *\/\* solution \*\/\n[^]*?\/\* starter\n([^]*?)^ *end \*\/\n/gm, "$1"));
    const starter = await told(url, (known) => known.unwritten.length && known.drawn && !known.busy);
    check(starter && starter.unwritten.join() === "1,2", "of a starter it tells which steps are not written yet", JSON.stringify(starter));
    if (browser) {
      check(await browser.until('/^Step 1: not written yet; /.test(document.querySelector("#drawn").textContent)'), "and the page says so of the picture", await words(browser, "#drawn"));
      const steps = await browser.value('[...document.querySelectorAll("#steps .points")].map((one) => one.textContent).join("; ")');
      check(/^\d+ points, not written yet; \d+ points, not written yet$/.test(steps), "and of each step", steps);
    }
  } finally {
    process.kill(-make.pid, "SIGTERM");
  }
}

// The driver says where the ticks are: 0 lies a fifth from the left, where errors are grey.
async function false_colours_have_a_bar(browser) {
  const ticks = '[...document.querySelectorAll(".live .scale .tick")].map((tick) => [tick.textContent, tick.style.getPropertyValue("--place")].join(" at ")).join()';
  await browser.open(`file://${weave({driver: "sampling", args: "--debug error --samples 2 --reference 8 --gain 4 --width 40 --height 40"}, "samples=1..4 debug=|error")}`);
  await browser.until('document.querySelector(".live").dataset.drawn');
  const shown = await browser.value(`${ticks} + document.querySelector(".live .scale .unit").textContent`);
  check(shown === "−0.05 at 0,0 at 0.2,0.2 at 1error of the radiance", "false colours have the bar of the still picture", shown);
  await browser.value('(() => { const view = [...document.querySelectorAll(".live select")].find((one) => [...one.options].some((option) => option.value === "error")); view.value = ""; view.dispatchEvent(new Event("change", {bubbles: true})); view.dispatchEvent(new Event("input", {bubbles: true})); })()');
  check(await browser.until('document.querySelector(".live .scale").hidden'), "the bar goes with them");
}

async function main() {
  module_draws_like_the_drivers();
  module_prints_like_the_drivers();
  every_control_does_something();
  a_scene_is_kept_between_frames();
  each_option_draws_with_a_kept_scene();
  const converging = require("./test_live_converge.js")({check, native, run: (...args) => runDriver(module_, ...args), difference, weave});
  converging.means_have_less_noise();
  if (!pandoc || !chromium) {
    console.log(`ok ${++count} - pages # SKIP ${pandoc ? "Chromium is missing: ./bootstrap --pdf" : "pandoc is missing: ./bootstrap"}`);
    await loop_shows_each_save();
    await loop_follows_the_steps();
  } else {
    const page = weave(FIGURE, OPTIONS), browser = new Browser(chromium, folder, ["--force-prefers-reduced-motion"]); // pictures stay as they are drawn
    try {
      await page_is_live(browser, page);
      await a_clicked_pixel_shows_its_rays(browser);
      await a_clicked_pixel_tells_its_fraction(browser);
      await false_colours_have_a_bar(browser);
      await converging.page_converges(browser);
      await page_stays_without_webassembly(browser, page);
      await require("./test_live_widgets.js")({check, native, run: (...args) => runDriver(module_, ...args), weave, differs, browser});
      const lint = script && require("./test_live_axe.js")({check, browser, source, folder, script});
      if (lint) await lint.woven_pages();
      else console.log(`ok ${++count} - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live installs it, by npm`);
      await loop_shows_each_save(browser, lint);
      await loop_follows_the_steps(browser);
    } finally {
      await browser.quit();
    }
  }
  console.log(`1..${count}`);
}

main().catch((error) => check(false, "the tests run to their end", error.stack)).finally(() => {
  fs.rmSync(folder, {recursive: true, force: true});
  process.exitCode = failed ? 1 : 0;
});
