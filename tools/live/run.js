// Runs a driver of the WebAssembly module: the few calls of WASI (snapshot preview 1, wasi.dev) that it makes,
// without files. One instance per run, so nothing is left of the last one but a scene that is kept on purpose.

class Exit {
  constructor(status) { this.status = status; }
}

// What a scene and its tree do not depend on.
const OF_FRAMES = ["--yaw", "--pitch", "--distance", "--fov", "--width", "--height"];

// The two parts of a command line: of the scene as one text, and of a frame.
function partsOf([driver, ...words]) {
  const scene = [driver], frame = [driver];
  for (let i = 0; i < words.length; i++) {
    const part = OF_FRAMES.includes(words[i]) ? frame : scene;
    part.push(words[i]);
    if (words[i + 1] !== undefined && !words[i + 1].startsWith("--")) part.push(words[++i]);
  }
  return {scene: scene.join("\n"), frame};
}

// args: ["bloom", "--bloom-radius", "3"]. Returns the exit status, what the driver printed and said, the rows of its
// tables as texts by column, its picture (width, height, rgba; the last one if there are several) or null, the scale of
// its false colours or "", and how it ended (see live.c) or null. tell(part) gets each row, {row}, and each picture, {picture}, while the driver runs.
// kept, an object of the caller, takes the instance with its scene and tree: the next run whose scene has the same
// options draws these again.
function runDriver(module, args, tell = () => {}, kept = {}) {
  const {scene, frame} = partsOf(args), again = kept.module === module && kept.scene === scene;
  const result = {status: 0, printed: "", said: "", rows: [], picture: null, scale: "", finish: null, kept: again};
  const encoded = (again ? frame : args).map((arg) => new TextEncoder().encode(arg + "\0"));
  const run = {result, encoded, tell, texts: {1: new TextDecoder(), 2: new TextDecoder()}, row: {}, keeps: false};
  const program = again ? kept.program : instantiate(module);
  Object.assign(program.now, run);
  for (const name of Object.keys(kept)) delete kept[name];
  try {
    if (again) result.status = program.draw_kept();
    else program.start();
  } catch (error) {
    if (!(error instanceof Exit)) throw error;
    result.status = error.status;
  }
  if (result.status === 0 && program.now.keeps) Object.assign(kept, {module, scene, program});
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
