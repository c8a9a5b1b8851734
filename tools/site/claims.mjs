// Checks units as a page does, in Node.js: node claims.mjs --site FOLDER --units FOLDER [--only "STEM ..."], or units
// by their files: node claims.mjs --site FOLDER --json normals=a.c normals=b.c ... In the site of a course, suites take
// further units that they need from the folder; without it they have starters.
//
// Prints a row for each suite, and each claim that does not pass; with --json a line for each unit: its stem, file,
// what the compiler said, and its verdicts. --first ends a unit at its first claim that does not pass. A claim may take
// 60 seconds, or --seconds. The status is 0 if all units have verdicts, and all are "passed".
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import {parseArgs} from "node:util";
import {Checker} from "./checker.mjs";
import {load_toolchain, read_kit, read_open, read_units, start_worker} from "./kit_files.mjs";
import {Others} from "./others.mjs";

// Returns {stem, file, said, verdicts, starters, seconds: {compile, link, run}}; no verdicts if the unit cannot be built;
// starters: those of the course that the suite needs and has.
async function check(checker, others, texts, stem, file, {first, seconds: limit}) {
  const result = {stem, file, said: "", verdicts: [], starters: [], seconds: {}};
  const {object, said, seconds} = checker.compile(stem, fs.readFileSync(file, "utf8"));
  result.said = said;
  result.seconds.compile = seconds;
  if (!object) return result;
  const linked = others.suite(stem, object, texts);
  result.seconds.link = linked.seconds;
  result.starters = linked.starters;
  if (!linked.bytes) return {...result, said: result.said + linked.said};
  const started = performance.now();
  await checker.run(await WebAssembly.compile(linked.bytes), linked.bytes, checker.kit.suites[stem].claims.map(({name}) => name), () => Number(limit), (verdict) => {
    if (first && result.verdicts.some((one) => one.verdict !== "passed")) return;
    result.verdicts.push(verdict);
    if (first && verdict.verdict !== "passed") checker.end();
  });
  result.seconds.run = (performance.now() - started) / 1000;
  return result;
}

function row(stem, {verdicts, seconds}) {
  const time = (name) => (seconds[name] === undefined ? "" : seconds[name].toFixed(2)).padStart(8);
  const passed = verdicts.filter(({verdict}) => verdict === "passed").length;
  return `${stem.padEnd(20)}${String(verdicts.length).padStart(7)}${String(passed).padStart(8)}${time("compile")}${time("link")}${time("run")}`;
}

const {values, positionals} = parseArgs({allowPositionals: true, options: {site: {type: "string"}, units: {type: "string"},
  only: {type: "string"}, json: {type: "boolean"}, first: {type: "boolean"}, seconds: {type: "string", default: "60"}}});
const workers = values.first ? 1 : os.availableParallelism();
const checker = new Checker(await load_toolchain(values.site), read_kit(values.site), start_worker, workers);
const stems = values.only ? values.only.split(/\s+/) : Object.keys(checker.kit.suites);
const units = positionals.length ? positionals.map((unit) => unit.split(/=(.*)/s).slice(0, 2))
  : stems.map((stem) => [stem, path.join(values.units, `${stem}.c`)]).filter(([, file]) => fs.existsSync(file));
const {open, starters} = read_open(values.site), others = new Others(checker, open, starters), texts = read_units(values.units, open);
let all_pass = units.length > 0;
if (!values.json) console.log(`${"suite".padEnd(20)} claims  passed compile    link     run  (seconds)`);
for (const [stem, file] of units) {
  const result = await check(checker, others, texts, stem, file, values), broken = result.verdicts.filter(({verdict}) => verdict !== "passed");
  all_pass = all_pass && result.verdicts.length > 0 && broken.length === 0;
  if (values.json) {
    console.log(JSON.stringify(result));
    continue;
  }
  console.log(row(stem, result));
  if (result.verdicts.length === 0) console.log(result.said.replace(/^/gm, "    "));
  if (result.starters.length) console.log(`    it needs ${result.starters.join(" and ")}, still the starter: solve that first`);
  for (const {claim, verdict, message, place} of broken) console.log(`    ${claim}: ${verdict}${place && ` (${place})`}: ${message}`);
}
checker.end();
process.exitCode = all_pass ? 0 : 1;
