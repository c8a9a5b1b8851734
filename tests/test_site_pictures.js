// The pictures of the steps in a page: drawn as WebAssembly by a clang that is WebAssembly itself, they are those of the
// native drivers, and the wanted ones. Speaks TAP, for make check-site; runs in a build folder that has site/.
// Arguments: the source folder, Chromium, and what make site has made ("" if missing);
// FEATURES names the drivers; with RAYKIT_QUICK, they are those that are drawn in Chromium, too.
"use strict";

const {execFileSync, spawnSync} = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");
const {Browser} = require("./browser.js");
const {decode} = require("./png.js");
const {serve} = require("./site_server.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

// Every operation of the renderer is one of IEEE 754's, which WebAssembly has too, or of the two C libraries' (powf,
// expf), whose last bits may differ: of 8 bits per channel a rounding may then fall to the other side, by 1 of 255.
const MOST = 1;

const IN_A_PAGE = ["normals", "bvh_median", "shading", "parallelogram_light", "depth_of_field"];

const [source, chromium, made] = process.argv.slice(2);
let count = 0, failed = 0;

function check(good, what, why = "") {
  if (!good && why !== "") String(why).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  failed += good ? 0 : 1;
}

// Returns {differ, beyond, most}: how many pixels differ, how many by more than MOST of 255, and by how much at most.
function difference(wanted, rgba) {
  const result = {differ: 0, beyond: 0, most: 0};
  for (let i = 0; i < wanted.width * wanted.height; i++) {
    const off = Math.max(...[0, 1, 2].map((channel) => Math.abs(wanted.rgb[3 * i + channel] - rgba[4 * i + channel])));
    result.differ += off > 0 ? 1 : 0;
    result.beyond += off > MOST ? 1 : 0;
    result.most = Math.max(result.most, off);
  }
  return result;
}

function native(folder, stem, args) {
  const at = fs.readdirSync("assignments").find((name) => name.replace(/^\d+_/, "") === stem);
  const printed = execFileSync(path.resolve("assignments", at, stem), [...args, "--out", folder], {encoding: "utf8"});
  return decode(printed.match(/^(.*\.png): /m)[1]);
}

function drawn(folder, units, only) {
  const options = ["--site", "site", "--units", units, "--out", folder, "--json", "--only", only];
  const {stdout} = spawnSync(process.execPath, [`${source}/tools/site/pictures.mjs`, ...options],
    {encoding: "utf8", stdio: ["ignore", "pipe", "inherit"]});
  return stdout.trim().split("\n").map((line) => JSON.parse(line));
}

function pictures(folder, looks, wanted) {
  console.log("# driver, step: pixels that differ, those by more than 1 of 255, and the most, from the native picture and");
  console.log("# from the wanted one; seconds");
  for (const stem of wanted) {
    const wrong = [];
    for (const {step, args, status, said, fault, pixels, draw} of drawn(folder, `${source}/src/features`, stem)) {
      const file = path.join(folder, `${stem}-${step}.rgba`);
      if (status !== 0 || !fs.existsSync(file)) {
        wrong.push(`step ${step}: ${fault || said || "no picture"}`);
        continue;
      }
      const rgba = fs.readFileSync(file), look = looks[stem].find((one) => one.step === step);
      const off = [native(folder, stem, args), decode(path.join("site", look.picture))].map((other) => difference(other, rgba));
      const row = `${stem}, ${step}: ${off.map(({differ, beyond, most}) => `${differ} ${beyond} ${most}`).join(", ")}; ${draw.toFixed(2)} s`;
      console.log(`# ${row}`);
      if (off.some(({beyond}) => beyond > 0)) wrong.push(row);
    }
    check(wrong.length === 0, `${stem}: a page draws the native pictures, which are the wanted ones`, wrong.join("\n"));
  }
}

// A unit's mistakes show, or are told.
function mistakes(folder) {
  const text = fs.readFileSync(`${source}/src/features/normals.c`, "utf8"), unit = path.join(folder, "normals.c");
  const first = (changed) => {
    fs.writeFileSync(unit, changed);
    return drawn(folder, folder, "normals")[0];
  };
  const broken = first(text.replace("return rk_vec(0.5f", "retrun rk_vec(0.5f"));
  check(broken.status !== 0 && /normals\.c:\d+:\d+: error/.test(broken.said), "of a unit that does not compile there is the compiler's word",
    JSON.stringify(broken));
  const missing = first('#include "features/normals.h"\n');
  check(missing.status !== 0 && /undefined symbol: rk_normals_/.test(missing.said), "a function that is missing is not the kit's",
    JSON.stringify(missing));
  const wild = first(text.replace("return rk_vec(0.5f", "volatile int i = 3;\n    float p[3] = {n.x, n.y, n.z};\n    n.x = p[i];\n    return rk_vec(0.5f"));
  check(wild.fault === "an index is outside of its array" && /^normals\.c:\d+$/.test(wild.place), "what C does not define is told, with its line",
    JSON.stringify(wild));
}

// What a page's worker does after a key, from the unit's text to the picture. Chromium lets no page itself start clang.
const IN_WORKER = (address) => `
  const at = (name) => "${address}/" + name;
  const packed = async (name) => (await import(at("packed.mjs"))).unpacked(await fetch(at(name + ".gz")));
  const bytes = async (name) => new Uint8Array(await (await packed(name)).arrayBuffer());
  const json = async (name) => (await fetch(at(name))).json();
  const [{Toolchain}, {Checker}, {Drawer, sized}] = await Promise.all(
    ["toolchain.mjs", "checker.mjs", "drawer.mjs"].map((name) => import(at(name))));
  const looks = await json("looks.json"), toolchain = await Toolchain.load(at("clang/bundle.mjs"));
  const checker = new Checker(toolchain, {headers: await (await packed("headers.json")).json()}, null);
  const kit = {archives: {"drivers.a": await bytes("drivers.a"), "kit.a": await bytes("kit.a")}, drivers: {}};
  const drawer = new Drawer(toolchain, kit, () => new Worker(at("draw_worker.mjs"), {type: "module"}));
  checker.compile("normals", '#include "features/normals.h"'); // the engine compiles clang while it runs
  const drawn = async (stem, text, step, limit) => {
    kit.drivers[stem] = kit.drivers[stem] || await bytes("drivers/" + stem + ".o");
    const begun = performance.now(), {object, said, seconds: compile} = checker.compile(stem, text);
    const {bytes: linked, seconds: link} = object ? drawer.link(stem, object) : {};
    if (!linked) return {said};
    const look = looks[stem].find((one) => one.step === step), args = sized(look.args, look.wanted);
    const {pixels, ...result} = await drawer.draw(await WebAssembly.compile(linked), [stem, ...args], limit);
    return {...result, rgba: pixels && Array.from(pixels), compile, link, total: (performance.now() - begun) / 1000};
  };
  onmessage = async ({data}) => postMessage(await drawn(...data).catch((error) => ({said: String(error)})));
  postMessage("ready");`;

async function in_a_page(folder, looks, stems) {
  const server = await serve(path.resolve("site")), browser = new Browser(chromium, folder);
  const unit = (stem) => fs.readFileSync(`${source}/src/features/${stem}.c`, "utf8");
  const address = `http://127.0.0.1:${server.address().port}`;
  const drawn = (...call) => browser.value(`new Promise((resolve) => {
    worker.onmessage = ({data}) => resolve(data);
    worker.postMessage(${JSON.stringify(call)});
  })`);
  try {
    await browser.open(`${address}/looks.json`);
    await browser.until(`document.readyState === "complete" && location.href.endsWith("looks.json")`);
    await browser.value(`new Promise((resolve) => {
      const text = new Blob([${JSON.stringify(IN_WORKER(address))}], {type: "text/javascript"});
      window.worker = new Worker(URL.createObjectURL(text), {type: "module"});
      worker.onmessage = resolve;
    })`);
    for (const stem of stems) for (const {step, picture} of looks[stem].slice(-1)) {
      const {rgba, said, fault, compile, link, seconds, total} = await drawn(stem, unit(stem), step, 60);
      const off = rgba ? difference(decode(path.join("site", picture)), rgba) : {};
      check(rgba && off.beyond === 0, `${stem}: Chromium draws the wanted picture`, JSON.stringify({said, fault, off}));
      if (rgba) console.log(`# compile ${compile.toFixed(2)} s, link ${link.toFixed(2)} s, draw ${seconds.toFixed(2)} s: ${total.toFixed(2)} s`);
    }
    const endless = unit("normals").replace("return rk_vec(0.5f", "volatile float x = n.x;\n    while (x < 9) ;\n    return rk_vec(0.5f");
    const late = await drawn("normals", endless, 1, 1), next = await drawn("normals", unit("normals"), 1, 60);
    check(/no picture after 1 s/.test(late.fault) && next.rgba, "a loop that never ends is ended, and the next text is drawn",
      JSON.stringify([late, next.fault]));
  } finally {
    await browser.quit();
    server.close();
  }
}

async function main() {
  if (!made) {
    console.log("1..0 # SKIP @yowasp/clang is missing: ./bootstrap --site");
    return;
  }
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-site-pictures-"));
  const looks = JSON.parse(fs.readFileSync("site/looks.json", "utf8"));
  const named = (process.env.FEATURES || "").split(/\s+/).filter(Boolean), wanted = named.length ? named : process.env.RAYKIT_QUICK ? IN_A_PAGE : Object.keys(looks);
  try {
    mistakes(folder);
    if (chromium) await in_a_page(folder, looks, wanted.filter((stem) => named.length || IN_A_PAGE.includes(stem)));
    else console.log(`ok ${++count} - pictures in Chromium # SKIP Chromium is missing: ./bootstrap --pdf`);
    pictures(folder, looks, wanted);
  } finally {
    fs.rmSync(folder, {recursive: true, force: true});
  }
  console.log(`1..${count}`);
  process.exitCode = failed ? 1 : 0;
}

main();
