// Makes what a page needs to check units, by the clang that the page will have.
//
// node objects.mjs --source FOLDER --out FOLDER --base "SOURCES" --suite "STEM SOURCES" ...; sources are named from the
// source folder; clang stands in OUT/clang (clang_package.mjs). Writes into OUT
//   kit.a               objects of the base library, and of what takes cmocka's and the system's place
//   suites/STEM.o       those, in one, of a suite: its claims, and the kit's units that it needs beside the student's
//   headers.json        the headers that a unit can include, as a tree of their texts
//   suites.json         for each suite its claims, in the order of points.tsv: {name, points, step}
//   objects/            all objects by the digest of what they are made of, for the next time
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {ToolError} from "./toolchain.mjs";
import {load_toolchain} from "./kit_files.mjs";
import {Maker, tree} from "./maker.mjs";
import {runSuite} from "./instance.mjs";

const OWN = ["tools/site/cmocka.c", "tools/site/memory.c", "tools/site/undefined.c"];
const OF_SUITES = ["tests/suite.c", "tests/likely_mistakes.c"];
const INCLUDE = ["src", "tests", "site", "site/include"];
const FLAGS = [`-DPACKAGE_VERSION="page"`];

// The claims in the order in which students meet them, each with its points and its step.
function claims_of(source, stem, names) {
  const folder = fs.readdirSync(path.join(source, "assignments")).find((name) => name.replace(/^\d+_/, "") === stem);
  const [, ...rows] = fs.readFileSync(path.join(source, "assignments", folder, "points.tsv"), "utf8").trim().split("\n");
  const claims = rows.map((row) => row.split("\t")).map(([name, points, step]) => ({name, points: Number(points), step: parseInt(step, 10) || 0}));
  const other = claims.map(({name}) => name).filter((name) => !names.includes(name)).concat(
    names.filter((name) => !claims.some((claim) => claim.name === name)));
  if (other.length) throw new ToolError(`points.tsv of ${stem} and its suite have different claims: ${other.join(" ")}`);
  return claims;
}

async function main() {
  const text = {type: "string"};
  const {values} = parseArgs({options: {source: text, out: text, base: text, suite: {...text, multiple: true}}});
  const {source, out} = values, toolchain = await load_toolchain(out);
  const headers = (folder) => tree(path.join(source, folder), /\.h$/);
  const maker = new Maker(toolchain, {source, store: path.join(out, "objects"), include: INCLUDE, flags: FLAGS,
    headers: {src: headers("src"), tests: headers("tests"), site: headers("tools/site")}});
  fs.mkdirSync(path.join(out, "suites"), {recursive: true});
  // Allocations are counted by the sanitizer's hooks; the kit's triangle test reads what a unit gives it.
  const is_checked = (file) => file === "tests/count_allocations.c" || file.startsWith("src/features/");
  const kit = toolchain.archive(maker.compile_all([...values.base.split(/\s+/).filter(Boolean), ...OWN,
    "tests/count_allocations.c"], is_checked));
  const suites = {};
  for (const suite of values.suite) {
    const [stem, ...sources] = suite.split(/\s+/).filter(Boolean), unit = `src/features/${stem}.c`;
    const object = toolchain.join(maker.compile_all([...OF_SUITES, ...sources.filter((file) => file !== unit)],
      (file) => file.startsWith("tests/")));
    fs.writeFileSync(path.join(out, "suites", `${stem}.o`), object);
    const {bytes, said: why} = toolchain.link({"unit.o": maker.compile(unit, true), "suite.o": object}, {"kit.a": kit});
    if (!bytes) throw new ToolError(`the suite ${stem} cannot be linked: ${why}`);
    const {printed, status, said, fault} = runSuite(new WebAssembly.Module(bytes), ["--list"]);
    if (status !== 0) throw new ToolError(`the suite ${stem} does not list its claims: ${said} ${fault}`);
    suites[stem] = claims_of(source, stem, printed.trim().split("\n"));
  }
  fs.writeFileSync(path.join(out, "kit.a"), kit);
  fs.writeFileSync(path.join(out, "headers.json"), JSON.stringify(maker.headers.src));
  fs.writeFileSync(path.join(out, "suites.json"), JSON.stringify(suites, null, 1));
}

try {
  await main();
} catch (error) {
  if (!(error instanceof ToolError)) throw error;
  console.error(`site: ${error.message}`);
  process.exitCode = 1;
}
