// Figures that go step by step: what they show is the unit's own run, and a page plays it.
"use strict";

const {execFileSync, spawnSync} = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");
const axe = require("./axe.js");
const {Browser} = require("./browser.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, pandoc, chromium, script, compiler, python] = process.argv.slice(2);
const build = process.cwd(), folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-steps-"));
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

// --- the states ----------------------------------------------------------------------------------

const read = (unit) => JSON.parse(fs.readFileSync(`live/steps/${unit}.json`, "utf8"));
// All states; NAME@K is entry K of an array.
function states_of({begin, steps}) {
  const states = [begin];
  for (const [, , changed] of steps) {
    const state = {...states[states.length - 1]};
    for (const [name, value] of Object.entries(changed)) {
      const [whole, k] = name.split("@");
      if (k === undefined) state[name] = value;
      else state[whole] = Object.assign([...state[whole]], {[k]: value});
    }
    states.push(state);
  }
  return states;
}
const last = (trace) => states_of(trace).pop();
const sorted = (list) => [...list].sort((a, b) => a - b).join();

function equal(got, wanted, what) {
  check(JSON.stringify(got) === JSON.stringify(wanted), what, `${JSON.stringify(got)}\n-- instead of --\n${JSON.stringify(wanted)}`);
}

// The end of each figure, and what the program got by calling the unit's public functions.
const ENDS = {
  bvh_median({selection, traversal}) {
    const {keys, triangles} = last(selection), {wanted} = selection.once;
    equal(sorted(triangles.slice(0, wanted)), sorted(selection.result.left), "selection: the last state's lower half is the root's left child");
    equal(sorted(keys.slice(0, wanted)), sorted(keys.map((key, k) => k + 1).slice(0, wanted)), "selection: it holds the lowest keys");
    const {hit, box_tests, triangle_tests} = last(traversal), result = traversal.result;
    equal([hit.triangle, hit.t.toPrecision(6), box_tests, triangle_tests], [result.triangle, result.t.toPrecision(6), result.box_tests, result.triangle_tests],
      "traversal: the last state has the hit and the counts that the unit returns");
  },
  sah_binning({bins}) {
    const seen = states_of(bins), late = (name) => seen.findLast((state) => state[name])[name], {splits, cheapest} = bins.result;
    equal([late("tried"), late("costs").map((cost) => cost.toPrecision(6))], [splits.map(([boundary]) => boundary), splits.map(([, , , cost]) => cost.toPrecision(6))],
      "bins: the last state has the splits and costs that the unit returns");
    equal(late("tried")[late("costs").indexOf(Math.min(...late("costs")))], cheapest, "bins: the split that the figure calls cheapest is the unit's");
    equal(late("filled").reduce((sum, {count}) => sum + count, 0), bins.once.references.length, "bins: each triangle is counted once");
  },
  parallelogram_light({clip}) {
    const {kept, left} = last(clip), {n} = clip.once, dot = (a, b) => a.x * b.x + a.y * b.y + a.z * b.z;
    const cross = (a, b) => ({x: a.y * b.z - a.z * b.y, y: a.z * b.x - a.x * b.z, z: a.x * b.y - a.y * b.x});
    const lambert = kept.map((a, k) => [a, kept[(k + 1) % left]]).map(([a, b]) => [dot(a, b), cross(a, b)])
      .reduce((sum, [cosine, across]) => sum + Math.atan2(Math.hypot(across.x, across.y, across.z), cosine) * dot(n, across) / Math.hypot(across.x, across.y, across.z), 0);
    equal((Math.abs(lambert) / 2).toPrecision(5), clip.result.irradiance.toPrecision(5), "clip: the corners of the last state have the irradiance that the unit returns");
    equal(kept.map((p) => Math.sign(dot(n, p))), [0, 1, 1, 0], "clip: two of them are on the horizon, none is below it");
  },
  sampling({owen}) {
    const {scrambled} = last(owen), {eighths} = owen.result, {bits} = owen.once;
    equal([scrambled, scrambled >>> 29], [owen.result.scrambled, eighths[bits >>> 29]], "owen: the last state is what the unit returns, in the eighth to which it takes the point's");
    equal(sorted(eighths), "0,1,2,3,4,5,6,7", "owen: no two eighths come to the same place");
    const nodes = states_of(owen).map(({before}) => before).filter((before) => before != null);
    equal(nodes, [...Array(32).keys()].map((digit) => Number((2n ** 32n + BigInt(bits)) >> BigInt(32 - digit))), "owen: each digit's coin is that of the digits before, as they were");
  },
  adaptive_sampling({rounds}) {
    const states = states_of(rounds), {counts, kept, own} = last(rounds), sum = (list) => list.reduce((a, b) => a + b, 0);
    const thrown_away = 8 * kept.filter((is_kept) => !is_kept).length;
    equal([sum(counts), sum(counts) + thrown_away], [rounds.result.kept, rounds.result.taken], "rounds: the last state's samples are those that the picture has, and those thrown away are the others");
    check(kept.some((is_kept, p) => is_kept && own[p] === 0) && kept.some((is_kept, p) => !is_kept && own[p] === 0), "rounds: of the pixels whose samples agree some keep them, and some do not");
    const colours = [0, 1].map((colour) => states.filter((state) => state.colour === colour && state.n != null).map(({i}) => (i % 8 + Math.floor(i / 8)) % 2));
    equal(colours.map((list) => [...new Set(list)]), [[0], [1]], "rounds: each colour of the chessboard is planned by itself");
  },
};

// --- known mistakes --------------------------------------------------------------------------------

// What the states of a figure are, line numbers apart.
const story = (trace) => JSON.stringify(states_of(trace));

const FOLLOWED = {adaptive_sampling: `${source}/src/render/stages/adaptive_plan.c`}; // in the place of the unit

// The unit with a mistake of tests/mutants, followed as the unit itself.
function follow_mistake(unit, mistake) {
  const kept = path.join(folder, mistake), wrong = path.join(kept, `${unit}.c`);
  fs.mkdirSync(kept, {recursive: true});
  execFileSync(python, ["-B", "-c", "import sys; sys.path.insert(0, sys.argv[1] + '/tools'); from grading import mutants\n" +
    "path = f'{sys.argv[1]}/src/features/{sys.argv[2]}.c'\n" +
    "found = [m for m in mutants.read_mutants(f'{sys.argv[1]}/tests/mutants/{sys.argv[2]}.mutants', sys.argv[2]) if m.name == sys.argv[3]][0]\n" +
    "open(sys.argv[4], 'w').write(mutants.mutate(found, open(path).read(), path))", source, unit, mistake, wrong]);
  execFileSync("sh", ["-c", `${compiler} -O0 -g ${source}/tools/live/steps/${unit}.c ${wrong} ${FOLLOWED[unit] || ""} ${process.env.RAYKIT_STEP_LIBS} -o ${kept}/${unit}`],
    {encoding: "utf8", stdio: ["ignore", "pipe", "pipe"]});
  execFileSync(process.env.GDB, ["-q", "-batch", "-nx", "-x", `${source}/tools/live/steps/trace.py`, `./${unit}`],
    {cwd: kept, env: {...process.env, UNIT: unit, ASAN_OPTIONS: "detect_leaks=0"}, stdio: "pipe"});
  return JSON.parse(fs.readFileSync(path.join(kept, `${unit}.json`), "utf8"));
}

const MISTAKES = {
  bvh_median: {first_key_as_the_pivot: "selection", left_child_first: "traversal", popped_nodes_not_checked_again: "traversal"},
  sah_binning: {highest_centroid_in_a_bin_of_its_own: "bins", empty_bins_have_a_box_at_the_origin: "bins"},
  adaptive_sampling: {proportional_to_the_variance: "rounds", its_own_neighbour: "rounds"},
  sampling: {digits_shifted_at_random: "owen", last_digit_first: "owen"},
  parallelogram_light: {corners_below_the_horizon_left_out: "clip", crossing_in_the_middle: "clip"},
};

function mistakes_are_seen(unit, right) {
  for (const [mistake, figure] of Object.entries(MISTAKES[unit])) {
    const wrong = follow_mistake(unit, mistake);
    const others = Object.keys(right).filter((name) => name !== figure && story(wrong[name]) !== story(right[name]));
    check(story(wrong[figure]) !== story(right[figure]) && others.length === 0, `${figure}: a unit with the mistake ${mistake} goes other steps, in this figure alone`, others.join());
  }
}

// --- the page --------------------------------------------------------------------------------------

// A page with the figures of all units; steps: the folder of their states.
function weave(name, {steps = path.join(build, "live/steps"), solutions = "yes"} = {}) {
  const text = path.join(folder, `${name}.md`), page = path.join(folder, `${name}.html`);
  const figures = fs.readdirSync(`${source}/docs`).filter((file) => file.endsWith(".md")).sort()
    .flatMap((file) => fs.readFileSync(`${source}/docs/${file}`, "utf8").match(/^::: \{\.replay [^]*?\n:::\n/gm) || []);
  fs.writeFileSync(text, `# A page {#a-page}\n\n${figures.join("\n")}`);
  const woven = spawnSync(pandoc, ["--standalone", "--self-contained", "--from=commonmark_x+sourcepos", "--to=html5", `--resource-path=${folder}`,
    `--lua-filter=${source}/docs/weave.lua`, `--template=${source}/tools/weave/template.html`, `--css=${source}/tools/weave/page.css`,
    `--css=${source}/docs/book.css`, "--metadata=title:steps", `--metadata=solutions:${solutions}`, "--metadata=lang:en", `--output=${page}`, text],
  {encoding: "utf8", env: {...process.env, RAYKIT_WEAVES: "book", RAYKIT_SOURCE: source, RAYKIT_SOURCE_LINK: source, RAYKIT_BUILD: build,
    RAYKIT_DRIVERS: build, RAYKIT_OUT: folder, RAYKIT_SCRAPS: folder, RAYKIT_STORE: path.join(folder, "drawn"), RAYKIT_RUNS: "1",
    RAYKIT_ALONE: "", RAYKIT_STEPS: steps, RAYKIT_LIVE: ""}});
  return {page, said: woven.stderr, html: woven.status === 0 ? fs.readFileSync(page, "utf8") : "", count: figures.length};
}

function lines_are_the_listing_s(units, traces) {
  const moved = path.join(folder, "moved");
  fs.cpSync("live/steps", moved, {recursive: true});
  for (const unit of units) {
    const file = path.join(moved, `${unit}.json`);
    fs.writeFileSync(file, fs.readFileSync(file, "utf8").replace(/\["(\w+)",\d+,/, '["$1",1,'));
    const {said} = weave(`moved_${unit}`, {steps: moved});
    const {file: followed} = Object.values(traces[unit])[0];
    check(new RegExp(`gdb has seen line 1 of \\w+, which ${followed} does not have`).test(said), `${unit}: a line that is not its function's stops the weaver`, said);
    fs.cpSync(`live/steps/${unit}.json`, file);
  }
}

function solutions_are_kept(units) {
  const {html, said} = weave("starters", {solutions: "no"});
  const shown = units.flatMap((unit) => [...fs.readFileSync(`${source}/src/features/${unit}.c`, "utf8").matchAll(/\/\* solution \*\/\n([^]*?)\/\* starter/g)])
    .flatMap(([, text]) => text.split("\n").map((line) => line.trim()).filter((line) => line.length > 25))
    .filter((line) => html.includes(JSON.stringify(line).slice(1, -1)));
  check(html && shown.length === 0, "without solutions the states are shown, but no line of these", said + shown.join("\n"));
  const {html: bare} = weave("without", {steps: ""});
  check(/made\s+without\s+gdb,\s+which/.test(bare) && !/class="replay"/.test(bare), "without gdb the captions stay, and say why there are no steps");
}

// What is to be read in a figure's picture at each state, and how: all states are drawn as the unit ran them.
const DRAWN = {
  rounds: {
    reads: '[...svg.querySelectorAll(".count")].map((count) => count.textContent)',
    wants: ({has, counts}) => counts.map((n, p) => n === has[p] ? `${n}` : `${has[p]} → ${n}`),
  },
  owen: {
    reads: '[...svg.querySelectorAll(".digit.after")].map((digit) => digit.textContent).join("")',
    wants: ({scrambled}) => scrambled == null ? "" : scrambled.toString(2).padStart(32, "0"),
  },
  clip: {
    reads: '[...svg.querySelectorAll(".slot")].map((slot) => slot.lastChild.textContent)',
    wants: ({kept}, {corners}) => (kept || []).map((p) => corners.findIndex((corner) => JSON.stringify(corner) === JSON.stringify(p))).map((k) => k < 0 ? "new" : `corner ${k}`),
  },
};

const replay = (i) => `document.querySelectorAll(".replay")[${i}]`;

// A figure is moved by keys: it begins at a question; an answer is judged by the states; the timeline's end is the unit's.
async function figure_is_played(browser, i, trace, figure) {
  const now = () => browser.value(`Number(${replay(i)}.dataset.now)`);
  const start = await now(), text = await browser.value(`${replay(i)}.querySelector("fieldset:not([hidden]) p").textContent`);
  check(start > 0 && text.endsWith("?"), `${figure}: it begins with a question`, `${start}: ${text}`);
  await browser.value(`${replay(i)}.querySelector("fieldset button").click()`);
  const verdict = await browser.value(`${replay(i)}.querySelector("fieldset p:last-of-type").textContent`);
  check(/^(Right|Not so: .*)\. $/.test(verdict), `${figure}: an answer is judged`, verdict);
  await browser.value(`${replay(i)}.querySelector("input[type=range]").focus()`);
  await browser.value(`${replay(i)}.querySelector("button[title='the next step']").click()`);
  equal(await now(), start + 1, `${figure}: a button runs the next line`);
  const line = await browser.value(`${replay(i)}.querySelector("pre .now").textContent`);
  check(line.trim().startsWith(`${trace.steps[start][1]} `), `${figure}: the line that has run is marked`, line);
  await browser.value(`(() => { const time = ${replay(i)}.querySelector("input[type=range]"); time.value = time.max; time.dispatchEvent(new Event("input")); })()`);
  const said = await browser.value(`${replay(i)}.querySelector("[role=status]").textContent`);
  check(said.startsWith(`Step ${trace.steps.length} of ${trace.steps.length},`), `${figure}: the timeline leads to the last line`, said);
  const values = await browser.value(`${replay(i)}.querySelector(".values").textContent`);
  const shown = Object.entries(last(trace)).filter(([, value]) => Number.isInteger(value)).map(([name, value]) => name + value);
  check((shown.length > 0 || DRAWN[figure]) && shown.every((pair) => values.includes(pair)), `${figure}: its last values are the unit's`, `${values}\n-- without one of --\n${shown}`);
}

async function states_are_drawn(browser, i, trace, figure) {
  if (!DRAWN[figure]) return;
  const states = states_of(trace), {once} = trace;
  const seen = await browser.value(`[...Array(${states.length}).keys()].map((k) => {
    const time = ${replay(i)}.querySelector("input[type=range]"), svg = ${replay(i)}.querySelector("svg");
    time.value = k;
    time.dispatchEvent(new Event("input"));
    return ${DRAWN[figure].reads};
  })`);
  const wanted = states.map((state) => DRAWN[figure].wants(state, once)), wrong = wanted.findIndex((want, k) => JSON.stringify(want) !== JSON.stringify(seen[k]));
  check(wrong < 0 && new Set(seen.map(String)).size > 2, `${figure}: all states are drawn as the unit ran them`, `step ${wrong}: ${JSON.stringify(seen[wrong])}, not ${JSON.stringify(wanted[wrong])}`);
}

async function pages_play(browser, traces) {
  const {page, html, count: figures, said} = weave("page");
  await browser.open(`file://${page}`, script ? axe.read(script) : "");
  const ready = await browser.until(`document.querySelectorAll(".replay[data-ready]").length === ${figures}`);
  check(ready, "all figures come", said);
  if (!ready) return;
  const overflow = [];
  for (let i = 0; i < figures; i++) {
    const {figure, unit} = await browser.value(`({...${replay(i)}.dataset})`), trace = traces[unit][figure];
    await figure_is_played(browser, i, trace, figure);
    await states_are_drawn(browser, i, trace, figure);
  }
  for (const [width, scheme] of [[1280, "light"], [390, "dark"]]) {
    await browser.view(width, scheme);
    if (await browser.value("document.documentElement.scrollWidth") > width) overflow.push(width);
  }
  check(overflow.length === 0, "no figure is wider than its page", overflow.join());
  if (script) {
    const found = await axe.findings(browser);
    check(found.length === 0, "axe-core finds nothing", found.join("\n"));
  } else console.log(`ok ${++count} - axe-core finds nothing # SKIP axe-core is missing: ./bootstrap --live installs it, by npm`);
  check((html.match(/class="replay"[^]*?<table>/g) || []).length === figures, "where no scripts run, each is a table");
}

async function main() {
  const units = fs.readdirSync("live/steps").filter((name) => name.endsWith(".json")).map((name) => path.basename(name, ".json"));
  equal(units, Object.keys(ENDS).sort(), "all units are followed");
  const traces = Object.fromEntries(units.map((unit) => [unit, read(unit)]));
  for (const unit of units) {
    ENDS[unit](traces[unit]);
    mistakes_are_seen(unit, traces[unit]);
  }
  lines_are_the_listing_s(units, traces);
  solutions_are_kept(units);
  const browser = new Browser(chromium, folder);
  try {
    await pages_play(browser, traces);
  } finally {
    await browser.quit();
  }
  console.log(`1..${count}`);
}

main().catch((error) => check(false, "the tests run to their end", error.stack)).finally(() => {
  fs.rmSync(folder, {recursive: true, force: true});
  process.exitCode = failed ? 1 : 0;
});
