// Runs a driver of the WebAssembly module: the few calls of WASI (snapshot preview 1, wasi.dev) that it makes,
// without files. One instance per run, so nothing is left of the last one but a scene that is kept on purpose.

class Exit {
  constructor(status) { this.status = status; }
}

// The options of each driver, by --help; by module.
const optionsOf = new WeakMap();

// The part of a command line that scene and tree depend on, as one text.
function sceneOf(module, [driver, ...words]) {
  if (!optionsOf.has(module)) optionsOf.set(module, {});
  const all = optionsOf.get(module), scene = [driver];
  all[driver] = all[driver] || JSON.parse(start(module, [driver, "--help"]).printed);
  for (let i = 0; i < words.length; i++) {
    const option = all[driver][words[i].slice(2)], takes = words[i + 1] !== undefined && !words[i + 1].startsWith("--");
    if (!option || option.of_scene) scene.push(words[i], ...(takes ? [words[i + 1]] : []));
    i += takes ? 1 : 0;
  }
  return scene.join("\n");
}

// args: ["bloom", "--bloom-radius", "3"]. Returns the exit status, what the driver printed and said, the rows of its
// tables as texts by column, its picture (width, height, rgba; the last one if there are several) or null, the scale of
// its false colours or "", and how it ended (see live.c) or null. tell(part) gets each row, {row}, and each picture, {picture}, while the driver runs.
// kept, an object of the caller, takes the instance with its scene and tree: the next run whose scene has the same
// options draws these again. part: what the picture is to the mean of pictures that differ in their seed alone (mean.c); the
// result's mean is {pictures, differ}, null if there is none.
function runDriver(module, args, tell = () => {}, kept = {}, part = "begins") {
  if (args.includes("--help")) return start(module, args, tell);
  const scene = sceneOf(module, args), again = kept.module === module && kept.scene === scene;
  const program = again ? kept.program : null;
  for (const name of Object.keys(kept)) delete kept[name];
  return start(module, args, tell, program, (now) => Object.assign(kept, {module, scene, program: now}), PARTS.indexOf(part));
}

const PARTS = ["begins", "adds", "leaves"]; // rk_mean_part

// program: that which draws again, or null. keep(program) gets one that could.
function start(module, args, tell = () => {}, again = null, keep = () => {}, part = 0) {
  const result = {status: 0, printed: "", said: "", rows: [], picture: null, scale: "", mean: null, finish: null, kept: again !== null};
  const encoded = args.map((arg) => new TextEncoder().encode(arg + "\0"));
  const run = {result, encoded, tell, texts: {1: new TextDecoder(), 2: new TextDecoder()}, row: {}, keeps: false};
  const program = again || instantiate(module);
  Object.assign(program.now, run);
  try {
    if (again) result.status = program.draw_kept(part);
    else program.start();
  } catch (error) {
    if (!(error instanceof Exit)) throw error;
    result.status = error.status;
  }
  if (result.status === 0 && program.now.keeps) keep(program);
  return result;
}

// An instance; its calls serve the run that `now` describes.
function instantiate(module) {
  const now = {};
  let memory = null;
  const view = () => new DataView(memory.buffer);
  const bytes = (from, size) => new Uint8Array(memory.buffer, from, size);
  const text = (from) => {
    const rest = new Uint8Array(memory.buffer, from);
    return new TextDecoder().decode(rest.subarray(0, rest.indexOf(0)));
  };
  const SUCCESS = 0, BAD_DESCRIPTOR = 8, NOT_FOUND = 44;
  const wasi = {
    args_sizes_get(count, size) {
      view().setUint32(count, now.encoded.length, true);
      view().setUint32(size, now.encoded.reduce((sum, text) => sum + text.length, 0), true);
      return SUCCESS;
    },
    args_get(pointers, to) {
      for (const text of now.encoded) {
        view().setUint32(pointers, to, true);
        bytes(to, text.length).set(text);
        pointers += 4;
        to += text.length;
      }
      return SUCCESS;
    },
    environ_sizes_get(count, size) {
      view().setUint32(count, 0, true);
      view().setUint32(size, 0, true);
      return SUCCESS;
    },
    environ_get: () => SUCCESS,
    clock_time_get(clock, precision, time) {
      view().setBigUint64(time, BigInt(Math.round(performance.now() * 1e6)), true);
      return SUCCESS;
    },
    fd_write(descriptor, vectors, count, written) {
      let sum = 0, text = "";
      for (let i = 0; i < count; i++) {
        const size = view().getUint32(vectors + 8 * i + 4, true);
        text += now.texts[descriptor].decode(bytes(view().getUint32(vectors + 8 * i, true), size), {stream: true});
        sum += size;
      }
      now.result[descriptor === 1 ? "printed" : "said"] += text;
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
  const raykit = {
    scale(shown) { now.result.scale = text(shown); },
    mean(pictures, differ) { now.result.mean = {pictures, differ: differ !== 0}; },
    picture(rgba, width, height) {
      now.result.picture = {width, height, rgba: bytes(rgba, 4 * width * height).slice()};
      now.tell({picture: now.result.picture});
    },
    cell(column, cell, last) {
      now.row[text(column)] = text(cell);
      if (!last) return;
      now.result.rows.push(now.row);
      now.tell({row: now.row});
      now.row = {};
    },
    keep() { now.keeps = true; },
    finish(yaw, pitch, distance, build, render) { now.result.finish = {yaw, pitch, distance, build, render}; },
  };
  // All other calls would need a file.
  const imports = {raykit, wasi_snapshot_preview1: new Proxy(wasi, {get: (calls, name) => calls[name] || (() => NOT_FOUND)})};
  const {exports} = new WebAssembly.Instance(module, imports);
  memory = exports.memory;
  return {now, start: exports._start, draw_kept: exports.draw_kept};
}
