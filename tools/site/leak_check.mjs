// Is the code of a course's solutions in its site? Compiles the kit's units as they would be in a site, and looks for
// their functions in all files of the folder.
//
// node leak_check.mjs --tools FOLDER --pack FOLDER --site FOLDER --store FOLDER --open "STEM ..."; see objects.mjs. Of each
// function that the starter lacks, the longest piece that no linker changes is looked for. Prints their number; the status
// is 1 if one is found, or a module of another compiler, which would not be recognized.
import fs from "node:fs";
import path from "node:path";
import {parseArgs} from "node:util";
import {gunzipSync} from "node:zlib";
import {load_toolchain} from "./kit_files.mjs";
import {maker_of_drivers, maker_of_suites} from "./maker.mjs";

const LEAST = 24; // bytes that are no coincidence
const CUSTOM = 0, CODE = 10, PADDED = 5; // bytes of a number that a linker puts in
const WITH_ADDEND = [3, 4, 5, 8, 9, 11]; // kinds of relocations, by WebAssembly's "Object file linking"
const MODULE = Buffer.from("\0asm");

// Reads numbers of a format in LEB128, and jumps.
class Reader {
  constructor(bytes, at = 0) { Object.assign(this, {bytes, at}); }

  number() {
    let value = 0, scale = 1, byte;
    do {
      byte = this.bytes[this.at++];
      value += (byte & 0x7f) * scale;
      scale *= 128;
    } while (byte & 0x80);
    return value;
  }

  text() {
    const size = this.number();
    this.at += size;
    return Buffer.from(this.bytes.subarray(this.at - size, this.at)).toString();
  }
}

// The sections of an object: {kind, name, from, to}.
function sections_of(bytes) {
  const sections = [], reader = new Reader(bytes, 8); // behind the format's name and version
  while (reader.at < bytes.length) {
    const kind = bytes[reader.at++], to = reader.number() + reader.at, begin = reader.at, name = kind === CUSTOM ? reader.text() : "";
    sections.push({kind, name, from: kind === CUSTOM ? reader.at : begin, to});
    reader.at = to;
  }
  return sections;
}

// Where a linker puts numbers into a section, as offsets in it.
function places_of(bytes, {from}) {
  const reader = new Reader(bytes, from), places = [];
  reader.number(); // the section's
  for (let left = reader.number(); left > 0; left--) {
    const kind = reader.number();
    places.push(reader.number());
    reader.number();
    if (WITH_ADDEND.includes(kind)) reader.number();
  }
  return places;
}

// Returns of each function of an object the longest piece between such numbers, if it is long enough.
function pieces_of(bytes) {
  const sections = sections_of(bytes), code = sections.find(({kind}) => kind === CODE);
  if (!code) return [];
  const relocations = sections.find(({name}) => name === "reloc.CODE"), pieces = [];
  const places = relocations ? places_of(bytes, relocations).map((at) => at + code.from) : [];
  const reader = new Reader(bytes, code.from);
  for (let left = reader.number(); left > 0; left--) {
    const end = reader.number() + reader.at, inside = places.filter((at) => at >= reader.at && at < end);
    const begins = [reader.at, ...inside.map((at) => at + PADDED)], ends = [...inside, end];
    const [from, to] = begins.map((begin, i) => [begin, ends[i]]).reduce((best, piece) => piece[1] - piece[0] > best[1] - best[0] ? piece : best);
    if (to - from >= LEAST) pieces.push(Buffer.from(bytes.subarray(from, to)));
    reader.at = end;
  }
  return pieces;
}

function files_in(folder) {
  return fs.readdirSync(folder, {withFileTypes: true}).flatMap((entry) => {
    const at = path.join(folder, entry.name);
    return entry.isDirectory() ? files_in(at) : [at];
  });
}

const text = {type: "string"};
const {values: {tools, pack, site, store, open}} = parseArgs({options: {tools: text, pack: text, site: text, store: text, open: text}});
const toolchain = await load_toolchain(site), secrets = new Map();
for (const stem of open.split(/\s+/).filter(Boolean))
  for (const make of [maker_of_suites, maker_of_drivers])
    for (const options of make === maker_of_suites ? [{}, {lines: true}, {checks: true}] : [{}]) {
      const object = (source) => make(toolchain, {source, tools, store}).compile(`src/features/${stem}.c`, options);
      const starter = Buffer.from(object(pack));
      for (const piece of pieces_of(object(tools))) if (starter.indexOf(piece) < 0) secrets.set(piece.toString("latin1"), {stem, piece});
    }
const found = [];
for (const file of files_in(site).filter((name) => !name.startsWith(path.join(site, "clang", path.sep)))) {
  const packed = fs.readFileSync(file), bytes = file.endsWith(".gz") ? gunzipSync(packed) : packed;
  const stems = new Set([...secrets.values()].filter(({piece}) => bytes.indexOf(piece) >= 0).map(({stem}) => stem));
  for (const stem of stems) found.push(`${path.relative(site, file)}: this holds code of the solution of ${stem}`);
  if (bytes.subarray(0, MODULE.length).equals(MODULE) && !file.endsWith(".gz")) found.push(`${path.relative(site, file)}: this is a module whose units are not known`);
}
console.log(found.join("\n") || `Searched the site for ${secrets.size} pieces of the solutions' code: none found.`);
process.exitCode = found.length || secrets.size === 0 ? 1 : 0;
