// Runs a program, a claim of a suite or a driver, in an instance of its own: the few calls of WASI (snapshot preview 1,
// wasi.dev) that it makes, without files.

class Exit {
  constructor(status) { Object.assign(this, {status, stack: String(new Error().stack)}); }
}

const ENDED = "ends the program, by exit or a function like it, while the claim runs: return from your functions instead";

// A trap by its error and by what the program said before it, in the words of tools/site/memory.c. Engines call them
// differently.
function said_of(error, said) {
  const text = String(error.message), [, asserted] = said.match(/^Assertion failed: (.*?)(?: \([^()]*: [^()]*: \d+\))?$/m) || [];
  if (asserted) return `the assertion ${asserted} does not hold`;
  if (/unreachable/.test(text)) return "stops itself, by abort, or where C has no meaning for what the compiler sees, such as a use of NULL";
  if (error instanceof RangeError || /call stack|recursion/.test(text)) return "the stack is used up: does a function call itself for ever?";
  if (/out of bounds|out-of-bounds/.test(text)) return "memory is used that the program does not have, or the stack is used up";
  if (/divi/.test(text)) return "an integer is divided by 0, or the quotient is beyond its type's range";
  return text;
}

const MOST = 1 << 16; // characters that are kept of what a program prints

// args: what a suite takes: ["--only", name], ["--list"]. Returns what runProgram does, and message, file and line of the
// claim that failed. Calls tell({printed}) or tell({said}) when something is printed.
export function runSuite(module, args, environment = {}, tell = () => {}) {
  const own = {message: "", file: "", line: 0, isTold: args[0] !== "--only"};
  const {isTold, ...result} = runProgram(module, ["suite", ...args], {environment, tell, result: own, calls: (result, {text}) => ({
    message(said) { result.message = text(said); },
    failed(file, line) { Object.assign(result, {file: text(file), line, isTold: true}); },
    passed() { result.isTold = true; },
    fault(what, file, line) { Object.assign(result, {fault: text(what), file: text(file), line}); },
  })});
  return isTold || result.fault ? result : {...result, status: 3, fault: ENDED};
}

// args: ["bloom", "--bloom-radius", "3"]. Returns what runProgram does, and the driver's picture: width, height and
// pixels, RGBA, null if it has drawn none, and the scale of its false colours or "".
export function runDriver(module, args) {
  const own = {file: "", line: 0, width: 0, height: 0, pixels: null, scale: ""};
  const result = runProgram(module, args, {result: own, calls: (result, {text, bytes}) => ({
    scale(shown) { result.scale = text(shown); },
    picture(rgba, width, height) {
      Object.assign(result, {width, height, pixels: new Uint8ClampedArray(bytes(rgba, 4 * width * height).slice().buffer)});
    },
    cell() {}, // of a table's row, which is printed too
    fault(what, file, line) { Object.assign(result, {fault: text(what), file: text(file), line}); },
  })});
  const {pixels, fault, said} = result;
  return pixels || fault || said.trim() || args.includes("--pixel") ? result : {...result, status: 3, fault: ENDED};
}

// Returns {status, printed, said, fault, stack}, printed and said as long as MOST, and what calls, the program's own imports, put into result; fault: what
// the code did that C does not define, or ""; stack: the engine's list of calls at the fault.
function runProgram(module, args, {environment = {}, tell = () => {}, result: own, calls}) {
  const result = {status: 0, printed: "", said: "", fault: "", stack: "", ...own};
  const encode = (words) => words.map((word) => new TextEncoder().encode(word + "\0"));
  const words = encode(args), variables = encode(Object.entries(environment).map((pair) => pair.join("=")));
  const decoders = {1: new TextDecoder(), 2: new TextDecoder()};
  let memory = null;
  const view = () => new DataView(memory.buffer);
  const bytes = (from, size) => new Uint8Array(memory.buffer, from >>> 0, size);
  const text = (from) => {
    const rest = new Uint8Array(memory.buffer, from >>> 0);
    return new TextDecoder().decode(rest.subarray(0, rest.indexOf(0)));
  };
  const SUCCESS = 0, BAD_DESCRIPTOR = 8, NO_SYSTEM = 52;
  const sizes = (list) => (count, size) => {
    view().setUint32(count, list.length, true);
    view().setUint32(size, list.reduce((sum, item) => sum + item.length, 0), true);
    return SUCCESS;
  };
  const items = (list) => (pointers, to) => {
    for (const item of list) {
      view().setUint32(pointers, to, true);
      bytes(to, item.length).set(item);
      pointers += 4;
      to += item.length;
    }
    return SUCCESS;
  };
  const wasi = {
    args_sizes_get: sizes(words), args_get: items(words),
    environ_sizes_get: sizes(variables), environ_get: items(variables),
    clock_time_get(clock, precision, time) {
      view().setBigUint64(time, BigInt(Math.round(performance.now() * 1e6)), true);
      return SUCCESS;
    },
    fd_write(descriptor, vectors, count, written) {
      if (!decoders[descriptor]) return BAD_DESCRIPTOR;
      const name = descriptor === 1 ? "printed" : "said";
      let sum = 0;
      for (let i = 0; i < count; i++) {
        const size = view().getUint32(vectors + 8 * i + 4, true);
        sum += size;
        if (result[name].length >= MOST) continue;
        const part = decoders[descriptor].decode(bytes(view().getUint32(vectors + 8 * i, true), size).slice(), {stream: true});
        result[name] += part;
        tell({[name]: part});
      }
      view().setUint32(written, sum, true);
      return SUCCESS;
    },
    fd_fdstat_get(descriptor, to) {
      if (descriptor > 2) return BAD_DESCRIPTOR;
      bytes(to, 24).fill(0);
      return SUCCESS;
    },
    fd_prestat_get: () => BAD_DESCRIPTOR,
    proc_exit(status) { throw new Exit(status); },
  };
  const imports = {raykit: calls(result, {text, bytes}), wasi_snapshot_preview1: new Proxy(wasi, {get: (calls, name) => calls[name] || (() => NO_SYSTEM)})};
  try {
    const {exports} = new WebAssembly.Instance(module, imports);
    memory = exports.memory;
    exports._start();
  } catch (error) {
    result.status = error instanceof Exit ? error.status : 3;
    if (!(error instanceof Exit)) result.fault = result.fault || said_of(error, result.said);
    result.stack = String(error.stack);
  }
  return result;
}
