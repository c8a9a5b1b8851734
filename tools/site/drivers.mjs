// Makes what a page needs to draw with a unit, by the clang that the page will have.
//
// node drivers.mjs --source FOLDER --out FOLDER --base "SOURCES" --driver "STEM SOURCES" ... --features "STEM ..."; sources
// are named from the source folder; clang stands in OUT/clang (clang_package.mjs). Writes into OUT
//   drivers.a           objects of the renderer and of what drivers share, with what takes the system's place
//   drivers/STEM.o      those, in one, of a driver, and of all features but the one that is the student's to write
//   looks.json          for each driver its steps' pictures, by look.tsv: {step, args, caption, size, wanted, picture};
//                       size: as large as the student's is natively, wanted: of the picture of that name
//   wanted/STEM-STEP.png
//   objects/            all objects by the digest of what they are made of, for the next time
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {load_toolchain} from "./kit_files.mjs";
import {Maker, tree} from "./maker.mjs";
import {ToolError} from "./toolchain.mjs";

const INCLUDE = ["src", "sse2"];
// Vectors as in live figures (tools/live/sse2). mkstemp is declared nowhere; tools/live/no_system.c has it.
const FLAGS = ["-target-feature", "+simd128", "-D__SSE2__", "-D_WASI_EMULATED_MMAN",
  `-DPACKAGE_VERSION="page"`, "-Wno-error=implicit-function-declaration"];
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
  const {values} = parseArgs({options: {source: text, out: text, base: text, features: text, driver: {...text, multiple: true}}});
  const {source, out} = values, toolchain = await load_toolchain(out), headers = (folder) => tree(path.join(source, folder), /\.h$/);
  const maker = new Maker(toolchain, {source, store: path.join(out, "objects"), include: INCLUDE, flags: FLAGS,
    headers: {src: headers("src"), sse2: headers("tools/live/sse2")}});
  for (const folder of ["drivers", "wanted"]) fs.mkdirSync(path.join(out, folder), {recursive: true});
  const archive = toolchain.archive(maker.compile_all(words(values.base))), looks = {};
  // Here it is decided whose units the others are: the kit's. In the site of a course, those that its students are still
  // to write would come from starters, as in a pack's drivers.
  const unit = (stem) => `src/features/${stem}.c`;
  for (const driver of values.driver) {
    const [stem, ...sources] = words(driver), others = words(values.features).filter((feature) => feature !== stem).map(unit);
    fs.writeFileSync(path.join(out, "drivers", `${stem}.o`), toolchain.join(maker.compile_all([...sources, ...others])));
    looks[stem] = looks_of(source, out, stem);
  }
  fs.writeFileSync(path.join(out, "drivers.a"), archive);
  fs.writeFileSync(path.join(out, "looks.json"), JSON.stringify(looks, null, 1));
}

try {
  await main();
} catch (error) {
  if (!(error instanceof ToolError)) throw error;
  console.error(`site: ${error.message}`);
  process.exitCode = 1;
}
