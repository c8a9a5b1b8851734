// Checks a unit as a page does: compiles it, links it with its suite, and runs its claims, each in an instance of its
// own, in a worker that is ended when a claim takes too long.

export class Checker {
  places = new Map(); // "normals.c:12" by the calls that an engine lists, as far as they were asked for
  took = new Map(); // seconds, by claim, when it last passed
  #run = {is_ended: true};
  #slots; // {worker, stop, wait}: a worker, or null; what takes the result that is awaited, or null; and what waits anew

  // toolchain: may come later, if there are modules already. kit: what `make site` has made: {archive, headers, suites:
  // {STEM: {object, claims}}}. startWorker() starts
  // claims_worker.mjs as a Web Worker, or as what has its interface; there are at most so many.
  constructor(toolchain, kit, startWorker, workers) {
    Object.assign(this, {toolchain, kit, startWorker});
    this.#slots = Array.from({length: workers}, () => ({worker: null, stop: null}));
  }

  // A main of the unit's own would take the place of the suite's, and no claim would run.
  // Returns {object, said, seconds}; said: the compiler's warnings and errors, which name the file STEM.c; object is
  // null if there are errors.
  compile(stem, text, flags = []) {
    const started = performance.now(), name = `${stem}.c`;
    const {object, said} = this.toolchain.compile({src: this.kit.headers, [name]: text}, name, {include: ["src"], unit: true, warnings: true, flags});
    const line = text.split("\n").findIndex((line) => /\bmain\s*\(/.test(line)) + 1 || 1, isProgram = object && has_main(object);
    const error = isProgram ? `${name}:${line}:1: error: your file defines main, but the suite has one, which calls your functions: remove yours\n` : "";
    return {object: isProgram ? null : object, said: error + said, seconds: (performance.now() - started) / 1000};
  }

  // Returns {bytes, seconds}: the suite's module with this unit, or with {said} why it cannot be linked. others: further
  // units that it may take (others.mjs).
  link(stem, object, {others = {}} = {}) {
    const started = performance.now(), suite = this.kit.suites[stem];
    const {bytes, said} = this.toolchain.link({"unit.o": object, "suite.o": suite.object}, {"kit.a": this.kit.archive}, {others});
    return {bytes, said, seconds: (performance.now() - started) / 1000};
  }

  // Runs claims of a module, as many at once as there are workers: the first worker in order, the others those first that
  // took longest, so that none is left for the end. Calls tell(verdict) for each that ends, see verdict_of. A claim may
  // take limit() seconds, which is asked again after each verdict. Resolves when all have run, or when end() is called.
  async run(module, bytes, claims, limit, tell) {
    const left = [...claims], run = this.#run = {is_ended: false};
    await Promise.all(this.#slots.map(async (slot, number) => {
      while (left.length > 0 && !run.is_ended) {
        const [claim] = left.splice(number === 0 ? 0 : this.#longest(left), 1), result = await this.#run_one(slot, module, claim, limit);
        if (result?.status === 0) this.took.set(claim, result.seconds);
        if (run.is_ended) return;
        tell(this.verdict_of(bytes, result));
        for (const other of this.#slots) if (other.stop) other.wait();
      }
    }));
  }

  // Which claim took longest: the first one of which it is not known.
  #longest(claims) {
    const took = claims.map((claim) => this.took.get(claim) ?? Infinity);
    return took.indexOf(Math.max(...took));
  }

  // Ends the claims that are running, if any are.
  end() {
    this.#run.is_ended = true;
    for (const slot of this.#slots) {
      if (slot.worker) slot.worker.terminate();
      slot.worker = null;
      if (slot.stop) slot.stop(null);
    }
  }

  // Resolves to what claims_worker.mjs sends.
  #run_one(slot, module, claim, limit) {
    return new Promise((resolve) => {
      slot.worker = slot.worker || this.startWorker();
      const so_far = {printed: "", said: ""}, started = performance.now();
      let timer = 0, seconds = 0;
      const late = () => {
        slot.worker.terminate();
        slot.worker = null;
        slot.stop({...so_far, claim, status: 4, seconds, fault: `no verdict after ${seconds} s: a loop that never ends, or code that is very slow`, stack: ""});
      };
      slot.wait = () => {
        clearTimeout(timer);
        seconds = limit();
        timer = setTimeout(late, Math.max(0, started + 1000 * seconds - performance.now()));
      };
      slot.wait();
      slot.stop = (result) => {
        slot.stop = null;
        clearTimeout(timer);
        resolve(result);
      };
      slot.worker.onmessage = ({data}) => {
        if (data.claim) slot.stop?.(data);
        else for (const [name, part] of Object.entries(data)) so_far[name] += part;
      };
      slot.worker.postMessage({module, claim});
    });
  }

  // Returns a claim's verdict: {claim, verdict, message, place, printed, seconds}; verdict: "passed", "failed", or "fault"
  // for what the code did that C does not define. place: "normals.c:12" or "". printed: by the unit, to stdout and stderr.
  verdict_of(bytes, {claim, status, message, printed, said, file, line, fault, stack, seconds}) {
    const verdict = status === 0 ? "passed" : fault ? "fault" : "failed";
    const place = line ? `${file.replace(/.*\//, "")}:${line}` : verdict === "fault" ? this.#place_in(bytes, stack) : "";
    const words = fault || message || said.trim();
    return {claim, verdict, message: words, place, printed: printed + (fault || message || status === 0 ? said : ""), seconds};
  }

  // The innermost call of the engine's list that has a line in the unit or the suite.
  #place_in(bytes, stack) {
    const section = code_section(bytes);
    const offsets = [...stack.matchAll(/wasm-function\[\d+\]:0x([0-9a-f]+)/g)].map(([, at]) => parseInt(at, 16) - section);
    if (offsets.length === 0) return "";
    const calls = `${bytes.length} ${offsets}`;
    if (!this.places.has(calls) && this.toolchain) {
      const places = this.toolchain.places(bytes, offsets).filter(({line}) => line);
      const place = places.find(({file}) => file.endsWith(".c")) || places[0]; // not what a unit includes
      this.places.set(calls, place ? `${place.file.replace(/.*\//, "")}:${place.line}` : "");
    }
    return this.places.get(calls) || "";
  }
}

// clang calls it by its parameters.
export function has_main(object) { return /__main_(void|argc_argv)/.test(new TextDecoder("latin1").decode(object)); }

// Where the contents of a module's code section begin, from which its line numbers count.
function code_section(bytes) {
  const CODE = 10;
  let at = 8; // behind the format's name and version
  const number = () => { // LEB128
    let value = 0, scale = 1, byte;
    do {
      byte = bytes[at++];
      value += (byte & 0x7f) * scale;
      scale *= 128;
    } while (byte & 0x80);
    return value;
  };
  while (at < bytes.length) {
    const kind = bytes[at++], size = number();
    if (kind === CODE) return at;
    at += size;
  }
  return 0;
}
