// clang and lld as WebAssembly (@yowasp/clang), as functions, in Node.js and in a page. They are called by the commands
// behind clang's own, which would start them as processes after asking for the commands, in a run of its own.

// The same for objects made by `make site` and for units compiled in a page.
const TARGET = ["-triple", "wasm32-unknown-wasip1", "-mrelocation-model", "static", "-target-cpu", "generic",
  "-mframe-pointer=none", "-mconstructor-aliases", "-fvisibility=hidden", "-disable-free", "-clear-ast-before-backend",
  "-fgnuc-version=4.2.1", "-resource-dir", "/usr", "-internal-isystem", "/usr/include",
  "-internal-isystem", "/usr/include/wasm32-wasip1"];
// As configure's RK_CFLAGS; wasi-libc has processor time under no name.
const LANGUAGE = ["-std=c17", "-D_XOPEN_SOURCE=700", "-ffp-contract=off", "-fno-rounding-math",
  "-DCLOCK_THREAD_CPUTIME_ID=CLOCK_MONOTONIC"];
const OPTIMIZE = ["-O2", "-vectorize-loops", "-vectorize-slp"];
const WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wno-sign-conversion", "-Wreturn-type", "-Wtype-limits", "-Wvla",
  "-Wstrict-prototypes", "-Wmissing-prototypes",
  ...["parameter", "function", "variable"].map((what) => `-Wno-unused-${what}`)]; // as of starters (unfinished in grading.am)
const LINES = ["-debug-info-kind=line-tables-only", "-dwarf-version=4"];
// As -fsanitize=address,undefined, for tools/site/memory.c and undefined.c, without what the address sanitizer covers, as
// configure's grade_sanitize: it took two fifths of the time to compile.
const ADDRESSES = ["-fsanitize=address", "-mllvm", "-asan-instrumentation-with-call-threshold=0"];
const UNDEFINED = ["-fsanitize=alignment,array-bounds,bool,builtin,enum,integer-divide-by-zero,nonnull-attribute,return," +
  "returns-nonnull-attribute,shift-base,shift-exponent,signed-integer-overflow,unreachable,vla-bound"];
// For units alone: a write is checked though the same place was read before, and variables on the stack have margins.
// What is known of these stands behind the stack, a byte for 8, for the first 256 MB of memory, where other stacks are,
// and behind that a byte for each page (memory.c).
const STACK_BYTES = 8 << 20, KNOWN_BYTES = 256 << 20, PAGES = 1 << 20;
const OF_UNITS = ["asan-opt-same-temp=0", "asan-stack=1", `asan-mapping-offset=${STACK_BYTES}`,
  "asan-use-after-return=never", "asan-instrument-dynamic-allocas=0"].flatMap((option) => ["-mllvm", `-${option}`]);
// Variables that are given no value are filled with a pattern, so that they do not happen to have the right one.
const FILL = ["-ftrivial-auto-var-init=pattern", "-include", "base/filled.h"];
// An endless loop runs until the time limit tells it: C lets a compiler assume that most loops end, and clang would
// leave out what comes after one that it knows not to.
const LOOPS = ["-fno-finite-loops"];
// What an integer is made of that it has no room for has some value, the nearest that there is, and no other at each use.
const CASTS = ["-fno-strict-float-cast-overflow"];
// For a unit that does not end: memory.c has what it calls at each branch.
export const TRACED = ["-fsanitize-coverage-type=3", "-fsanitize-coverage-trace-pc", "-fsanitize-coverage-no-prune"];
const OF_KIT = ["-mllvm", "-asan-stack=0"];
// What objects depend on besides their sources.
export const OBJECT_FLAGS = [TARGET, LANGUAGE, OPTIMIZE, LINES, [...ADDRESSES, ...OF_KIT, ...UNDEFINED]];
const LINK = ["-m", "wasm32", "-z", `stack-size=${STACK_BYTES}`, "--stack-first",
  `--global-base=${STACK_BYTES + KNOWN_BYTES / 8 + PAGES}`, "--max-memory=4294967296",
  ...["malloc", "calloc", "realloc", "aligned_alloc", "free"].map((name) => `--wrap=${name}`)];
const LIBRARIES = "/usr/lib/wasm32-wasip1";

export class ToolError extends Error {}

export class Toolchain {
  #run;

  // run: the package's runLLVM.
  constructor(run) { this.#run = run; }

  // bundle: the address of the package's gen/bundle.js, beside which its modules and its files are. tell(part) gets how
  // much of them is loaded, from 0 to 1.
  static async load(bundle, tell = () => {}) {
    const {runLLVM} = await import(bundle);
    await runLLVM(null, {}, {fetchProgress: ({doneLength, totalLength}) => tell(Math.min(1, doneLength / totalLength))});
    return new Toolchain(runLLVM);
  }

  // Runs one of LLVM's programs on files, a tree of texts and bytes by their names. Returns its status, the files
  // afterwards, what it wrote to its standard output, as bytes, and what it said. Large output should come that way:
  // with each 4 kB of a file the package copies all that it has of it.
  run(args, files) {
    const said = [], parts = [], decoder = new TextDecoder();
    const options = {decodeASCII: false, synchronously: true,
      stdout: (bytes) => { if (bytes) parts.push(bytes.slice()); },
      stderr: (bytes) => { if (bytes) said.push(decoder.decode(bytes, {stream: true})); }};
    let status = 0, after = files;
    try {
      after = this.#run(args, files, options);
    } catch (error) {
      if (error.code === undefined) throw error; // a fault of the program
      status = error.code;
    }
    return {status, files: after, output: joined(parts), said: said.join("")};
  }

  // Compiles one file. checks: with those of addresses and of undefined behaviour; unit: with all of them, as a student's
  // file; lines: so that places can be found. Returns the object (null if the file has errors) and what the compiler said.
  compile(files, path, {include = [], flags = [], checks = true, unit = false, lines = true, warnings = false} = {}) {
    const folders = include.flatMap((folder) => ["-I", folder]);
    const checked = checks ? [...ADDRESSES, ...(unit ? [...OF_UNITS, ...FILL, ...LOOPS, ...CASTS] : OF_KIT), ...UNDEFINED] : [];
    const {status, output, said} = this.run(["clang", "-cc1", ...TARGET, "-emit-obj", ...OPTIMIZE, ...LANGUAGE,
      ...(lines ? LINES : []), ...checked, ...(warnings ? WARNINGS : ["-w"]), ...folders, ...flags,
      "-main-file-name", path.replace(/.*\//, ""), "-o", "-", "-x", "c", path], files);
    return {object: status === 0 ? output : null, said};
  }

  // Links objects, bytes by their names, and from archives, and before them from further objects, others, only what is
  // wanted. Returns {bytes, said}: the module, null if it cannot be linked, and why not. wrap: further functions in whose
  // place the objects have others, as for wasm-ld's --wrap.
  link(objects, archives, {wrap = [], others = {}} = {}) {
    const wrapped = wrap.map((name) => `--wrap=${name}`);
    const {status, output, said} = this.run(["wasm-ld", ...LINK, ...wrapped, `${LIBRARIES}/crt1-command.o`,
      ...Object.keys(objects), "--start-lib", ...Object.keys(others), "--end-lib", ...Object.keys(archives), "-L", LIBRARIES, "-lc-printscan-long-double", "-lc", "/usr/lib/wasm32-unknown-wasip1/libclang_rt.builtins.a",
      "-o", "-"], {...objects, ...others, ...archives});
    return {bytes: status === 0 ? output : null, said};
  }

  // Returns one object of several, bytes by their names.
  join(objects) {
    const {status, output, said} = this.run(["wasm-ld", "-m", "wasm32", "-r", ...Object.keys(objects), "-o", "-"], objects);
    if (status !== 0) throw new ToolError(`objects could not be joined: ${said}`);
    return output;
  }

  // Returns an archive of objects, bytes by their names.
  archive(objects) {
    const {status, files, said} = this.run(["ar", "rcs", "out.a", ...Object.keys(objects)], objects);
    if (status !== 0) throw new ToolError(`the archive could not be made: ${said}`);
    return files["out.a"];
  }

  // Returns the calls that an engine lists as offsets in a module's code, innermost first, as {file, line}.
  places(bytes, offsets) {
    const {output} = this.run(["symbolizer", "--obj=module.wasm", "--output-style=JSON", "--no-demangle",
      ...offsets.map((offset) => `0x${offset.toString(16)}`)], {"module.wasm": bytes});
    return JSON.parse(new TextDecoder().decode(output)).flatMap((call) => call.Symbol || [])
      .map(({FileName: file, Line: line}) => ({file, line}));
  }
}

function joined(parts) {
  const all = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    all.set(part, at);
    at += part.length;
  }
  return all;
}

