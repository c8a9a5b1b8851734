// Draws the pictures of the steps as a page does, in Node.js: node pictures.mjs --site FOLDER --units FOLDER
// [--only "STEM ..."] [--size WIDTHxHEIGHT or full] [--out FOLDER] [--json]; without a size they are as large as the
// wanted ones. Prints a row for each picture, with --json a line with what the driver said; --out takes them as
// STEM-STEP.rgba. The status is 0 if all are drawn.
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {Checker} from "./checker.mjs";
import {Drawer, sized} from "./drawer.mjs";
import {load_toolchain, read_drivers, read_kit, read_open, read_units, start_worker} from "./kit_files.mjs";
import {Others} from "./others.mjs";

const LIMIT = 300; // seconds for a picture

const {values} = parseArgs({options: {site: {type: "string"}, units: {type: "string"}, only: {type: "string"},
  size: {type: "string"}, out: {type: "string"}, json: {type: "boolean"}}});
const kit = read_drivers(values.site);
const toolchain = await load_toolchain(values.site), checker = new Checker(toolchain, read_kit(values.site), null);
const {open, starters} = read_open(values.site), others = new Others(checker, open, starters), texts = read_units(values.units, open);
const drawer = new Drawer(toolchain, kit, () => start_worker("draw_worker.mjs"));
const size_of = ({size, wanted}) => {
  if (!values.size) return wanted;
  const [width, height] = values.size.split("x").map(Number);
  return values.size === "full" ? size : {width, height};
};

// Returns a row for each step: {stem, step, args, width, height, status, printed, said, fault, compile, link, draw}.
async function draw_all(stem) {
  const {object, said, seconds: compile} = checker.compile(stem, fs.readFileSync(path.join(values.units, `${stem}.c`), "utf8"));
  const {bytes, said: why, seconds: link} = object ? others.driver(drawer, stem, object, texts) : {};
  if (!bytes) return [{stem, step: 0, status: 1, said: said + (why || ""), fault: "", compile, link, draw: 0}];
  const module = await WebAssembly.compile(bytes), rows = [];
  for (const look of kit.looks[stem]) {
    const args = sized(look.args, size_of(look));
    const {pixels, seconds: draw, ...result} = await drawer.draw(module, [stem, ...args], LIMIT);
    if (values.out && pixels) fs.writeFileSync(path.join(values.out, `${stem}-${look.step}.rgba`), pixels);
    if (result.fault) result.place = checker.verdict_of(bytes, result).place;
    rows.push({stem, step: look.step, args, ...result, compile, link, draw, bytes: bytes.length});
  }
  return rows;
}

let all_drawn = true;
if (values.out) fs.mkdirSync(values.out, {recursive: true});
if (!values.json) console.log(`${"driver".padEnd(20)} step      size compile    link    draw  (seconds)`);
for (const stem of values.only ? values.only.split(/\s+/) : Object.keys(kit.looks))
  for (const row of await draw_all(stem)) {
    const {step, width, height, status, said, fault, compile, link, draw} = row;
    const drawn = status === 0 && width > 0, times = [compile, link, draw].map((value) => (value || 0).toFixed(2).padStart(8));
    all_drawn = all_drawn && drawn;
    if (values.json) console.log(JSON.stringify(row));
    else console.log(`${stem.padEnd(20)}${String(step).padStart(5)}${`${width} x ${height}`.padStart(10)}${times.join("")}`);
    if (!drawn && !values.json) console.log(((fault && `${fault} (${row.place})`) || said || "no picture").replace(/^/gm, "    "));
  }
drawer.end();
process.exitCode = all_drawn ? 0 : 1;
