// Makes what a page needs to draw with a unit, by the clang that the page will have.
//
// node drivers.mjs --tools FOLDER --source FOLDER --out FOLDER --store FOLDER --base "SOURCES" --driver "STEM SOURCES" ...
// --features "STEM ..." --open "STEM ..." [--references]; as for objects.mjs. Writes into OUT
//   drivers.a           objects of the renderer and of what drivers share, with what takes the system's place
//   drivers/STEM.o      those, in one, of a driver, and of all features but the one that is the student's to write and
//                       those that are open
//   references/STEM.o   with --references, the kit's unit, whose explanation of a pixel stands beside the student's
//   looks.json          for each driver its steps' pictures, by look.tsv: {step, args, caption, size, wanted, picture,
//                       reference}; size: as large as the student's is natively, wanted: of the picture of that name;
//                       reference: its object's name, if there is one
//   wanted/STEM-STEP.png
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {load_toolchain, write_packed} from "./kit_files.mjs";
import {maker_of_drivers} from "./maker.mjs";
import {ToolError} from "./toolchain.mjs";

const SIDE = 800; // of a driver's picture without --width and --height

// Words of look.tsv are written without quotes.
function size_of(words) {
  const number = (name) => Number(words[words.indexOf(name) + 1]) * Number(words.includes(name)) || SIDE;
  return {width: number("--width"), height: number("--height")};
}

function png_size(file) {
  const png = fs.readFileSync(file);
  return {width: png.readUInt32BE(16), height: png.readUInt32BE(20)};
}

// The pictures of a driver's steps; copies the wanted ones, which tools/draw.py has made.
function looks_of(source, out, stem) {
  const folder = fs.readdirSync(path.join(source, "assignments")).find((name) => name.replace(/^\d+_/, "") === stem);
  const [, ...rows] = fs.readFileSync(path.join(source, "assignments", folder, "look.tsv"), "utf8").trim().split("\n");
  return rows.map((row) => row.split("\t")).map(([step, options, caption]) => {
    const args = options.split(/\s+/), wanted = path.join(source, "assignments", folder, "look", `${step}.png`);
    const picture = `wanted/${stem}-${step}.png`;
    if (/["'\\]/.test(options)) throw new ToolError(`look.tsv of ${stem}, step ${step}: options in quotes are not read here`);
    fs.copyFileSync(wanted, path.join(out, picture));
    return {step: Number(step), args, caption, size: size_of(args), wanted: png_size(wanted), picture};
  });
}

async function main() {
  const text = {type: "string"}, words = (list) => list.split(/\s+/).filter(Boolean);
  const {values} = parseArgs({options: {tools: text, source: text, out: text, store: text, base: text,
    features: text, open: text, references: {type: "boolean"}, driver: {...text, multiple: true}}});
  const {tools, source, out, store, references} = values, toolchain = await load_toolchain(out);
  const maker = maker_of_drivers(toolchain, {source, tools, store});
  for (const folder of ["drivers", "wanted", "references"]) {
    fs.rmSync(path.join(out, folder), {recursive: true, force: true}); // of an older site
    fs.mkdirSync(path.join(out, folder), {recursive: true});
  }
  const archive = toolchain.archive(maker.compile_all(words(values.base))), looks = {}, open = words(values.open);
  const solved = words(values.features).filter((feature) => !open.includes(feature)), unit = (stem) => `src/features/${stem}.c`;
  for (const driver of values.driver || []) {
    const [stem, ...sources] = words(driver), others = solved.filter((feature) => feature !== stem).map(unit);
    write_packed(out, `drivers/${stem}.o`, toolchain.join(maker.compile_all([...sources, ...others])));
    const reference = references ? {reference: `references/${stem}.o`} : {};
    if (references) write_packed(out, reference.reference, maker.compile(unit(stem)));
    looks[stem] = looks_of(source, out, stem).map((look) => ({...look, ...reference}));
  }
  write_packed(out, "drivers.a", archive);
  fs.writeFileSync(path.join(out, "looks.json"), JSON.stringify(looks, null, 1));
}

try {
  await main();
} catch (error) {
  if (!(error instanceof ToolError)) throw error;
  console.error(`site: ${error.message}`);
  process.exitCode = 1;
}
