// Makes what a page needs to check units, by the clang that the page will have.
//
// node objects.mjs --tools FOLDER --source FOLDER --out FOLDER --store FOLDER --base "SOURCES" --suite "STEM SOURCES" ...
// --open "STEM ..."; tools: raykit's source folder, source: that or a pack, from which sources are named. clang stands in
// OUT/clang (clang_package.mjs), and STORE keeps all objects, by the digest of what they are made of, for the next time.
// Writes into OUT, packed by gzip (.gz) all that is no text,
//   kit.a               objects of the base library, and of what takes cmocka's and the system's place
//   suites/STEM.o       those, in one, of a suite: its claims, and the kit's units that it needs beside the student's
//   open/STEM.o         starters of the units of a pack that are open: the students' in a course, or those of a later time
//   headers.json        the headers that a unit can include, as a tree of their texts
//   suites.json         for each suite its claims, in the order of points.tsv: {name, points, step}
//   open.json           {stems, suites, starters, note}: which units are open, for each suite those that it may need, the
//                       texts of those that the course asks for, and src/driver/implementation_note.c
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {ToolError} from "./toolchain.mjs";
import {load_toolchain, write_packed} from "./kit_files.mjs";
import {maker_of_suites} from "./maker.mjs";
import {runSuite} from "./instance.mjs";

const OWN = ["tools/site/cmocka.c", "tools/site/memory.c", "tools/site/undefined.c"];
const OF_SUITES = ["tests/suite.c", "tests/likely_mistakes.c"];

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
  const text = {type: "string"}, words = (list) => list.split(/\s+/).filter(Boolean);
  const {values} = parseArgs({options: {tools: text, source: text, out: text, store: text, base: text, open: text, suite: {...text, multiple: true}}});
  const {tools, source, out, store} = values, toolchain = await load_toolchain(out);
  const maker = maker_of_suites(toolchain, {source, tools, store});
  for (const folder of ["open", "suites"]) {
    fs.rmSync(path.join(out, folder), {recursive: true, force: true}); // of an older site
    fs.mkdirSync(path.join(out, folder), {recursive: true});
  }
  // Allocations are counted by the sanitizer's hooks; the kit's triangle test reads what a unit gives it.
  const of_kit = (file) => ({checks: file === "tests/count_allocations.c" || file.startsWith("src/features/")});
  const of_suite = () => ({lines: true}); // natively their memory is not watched, either
  const unit = (stem) => `src/features/${stem}.c`, stems = words(values.open), isOpen = (file) => stems.map(unit).includes(file);
  const base = words(values.base), starters = Object.fromEntries(stems.map((stem) => [stem, maker.compile(unit(stem))]));
  const kit = toolchain.archive(maker.compile_all([...base.filter((file) => !isOpen(file)), ...OWN, "tests/count_allocations.c"], of_kit));
  const suites = {}, open = {stems, suites: {}, starters: {}, note: fs.readFileSync(path.join(source, "src/driver/implementation_note.c"), "utf8")};
  for (const suite of values.suite) {
    const [stem, ...all] = words(suite), sources = all.filter((file) => file !== unit(stem));
    const object = toolchain.join(maker.compile_all([...OF_SUITES, ...sources.filter((file) => !isOpen(file))], of_suite));
    write_packed(out, `suites/${stem}.o`, object);
    open.suites[stem] = [...sources, ...base].filter(isOpen).map((file) => path.basename(file, ".c")).filter((other) => other !== stem);
    if (stems.includes(stem)) open.starters[stem] = fs.readFileSync(path.join(source, "workbook", `${stem}.c`), "utf8");
    const others = Object.fromEntries(open.suites[stem].map((other) => [`other-${other}.o`, starters[other]]));
    const {bytes, said: why} = toolchain.link({"unit.o": maker.compile(unit(stem), {checks: true}), "suite.o": object}, {"kit.a": kit}, {others});
    if (!bytes) throw new ToolError(`the suite ${stem} cannot be linked: ${why}`);
    const {printed, status, said, fault} = runSuite(new WebAssembly.Module(bytes), ["--list"]);
    if (status !== 0) throw new ToolError(`the suite ${stem} does not list its claims: ${said} ${fault}`);
    suites[stem] = claims_of(source, stem, printed.trim().split("\n"));
  }
  write_packed(out, "kit.a", kit);
  for (const [stem, starter] of Object.entries(starters)) write_packed(out, `open/${stem}.o`, starter);
  fs.writeFileSync(path.join(out, "open.json"), JSON.stringify(open, null, 1));
  write_packed(out, "headers.json", JSON.stringify(maker.headers.src));
  fs.writeFileSync(path.join(out, "suites.json"), JSON.stringify(suites, null, 1));
}

try {
  await main();
} catch (error) {
  if (!(error instanceof ToolError)) throw error;
  console.error(`site: ${error.message}`);
  process.exitCode = 1;
}
