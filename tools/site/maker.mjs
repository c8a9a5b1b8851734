// Compiles the kit's sources by the clang that a page has, and keeps the objects for the next time.
import {createHash} from "node:crypto";
import fs from "node:fs";
import path from "node:path";
import {OBJECT_FLAGS, ToolError} from "./toolchain.mjs";

const PACKAGE = `-DPACKAGE_VERSION="page"`;
// Vectors as in live figures (tools/live/sse2). mkstemp is declared nowhere; tools/live/no_system.c has it.
const OF_DRIVERS = ["-target-feature", "+simd128", "-D__SSE2__", "-D_WASI_EMULATED_MMAN", PACKAGE, "-Wno-error=implicit-function-declaration"];

// A folder's files whose names end so, as a tree; what automake keeps there if it builds there begins with a dot.
function tree(folder, end) {
  const files = {};
  for (const entry of fs.readdirSync(folder, {withFileTypes: true})) {
    const at = path.join(folder, entry.name);
    if (entry.name.startsWith(".")) continue;
    if (entry.isDirectory()) files[entry.name] = tree(at, end);
    else if (end.test(entry.name)) files[entry.name] = fs.readFileSync(at, "utf8");
  }
  return files;
}

class Maker {
  // tools: the folder in which the sources are that `source`, a pack, lacks. store: the folder in which objects stand by
  // the digest of what they are made of. headers: trees by the folders that include names.
  constructor(toolchain, {source, tools, store, headers, include, flags}) {
    Object.assign(this, {toolchain, source, tools, store, headers, include, flags});
    this.inputs = createHash("sha256").update(JSON.stringify([headers, include, flags, OBJECT_FLAGS])).digest("hex");
    fs.mkdirSync(store, {recursive: true});
  }

  // Returns the object of a source; throws what the compiler says of it. lines: so that places in it can be found.
  compile(file, {checks = false, lines = checks} = {}) {
    const name = path.basename(file), folder = fs.existsSync(path.join(this.source, file)) ? this.source : this.tools;
    const text = fs.readFileSync(path.join(folder, file), "utf8");
    const beside = file.startsWith("assignments/") ? tree(path.join(this.source, path.dirname(file)), /\.h$/) : {};
    const parts = Object.keys(beside).length ? JSON.stringify(beside) : "";
    const digest = createHash("sha256").update(`${this.inputs} ${checks} ${lines} ${file}\n${parts}${text}`).digest("hex");
    const stored = path.join(this.store, `${digest}.o`);
    if (fs.existsSync(stored)) return new Uint8Array(fs.readFileSync(stored));
    const {object, said} = this.toolchain.compile({...this.headers, ...beside, [name]: text}, name,
      {include: this.include, flags: this.flags, checks, lines});
    if (!object) throw new ToolError(`${file} does not compile:\n${said}`);
    const part = `${stored}.${process.pid}.part`; // sites of several courses may be made at once
    fs.writeFileSync(part, object);
    fs.renameSync(part, stored);
    return object;
  }

  // Returns the objects of several, by names for a linker; options(file): compile's.
  compile_all(sources, options = () => ({})) {
    return Object.fromEntries(sources.map((file) => [file.replaceAll("/", "-").replace(/c$/, "o"), this.compile(file, options(file))]));
  }
}

// A pack's headers are the same, but it lacks those of instructors' tests.
const headers = (...folder) => tree(path.join(...folder), /\.h$/);

export function maker_of_suites(toolchain, {source, tools, store}) {
  return new Maker(toolchain, {source, tools, store, include: ["src", "tests", "site", "site/include"], flags: [PACKAGE],
    headers: {src: headers(tools, "src"), tests: headers(tools, "tests"), site: headers(tools, "tools/site")}});
}

export function maker_of_drivers(toolchain, {source, tools, store}) {
  return new Maker(toolchain, {source, tools, store, include: ["src", "sse2"], flags: OF_DRIVERS,
    headers: {src: headers(tools, "src"), sse2: headers(tools, "tools/live/sse2")}});
}
