// Runs a driver of the WebAssembly module: the few calls of WASI (snapshot preview 1, wasi.dev) that it makes,
// without files. One instance per run, so nothing is left of the last one.

class Exit {
  constructor(status) { this.status = status; }
}

// args: ["bloom", "--bloom-radius", "3"]. Returns the exit status, what the driver printed and said, the rows of its
// tables as texts by column, its picture (width, height, rgba; the last one if there are several) or null, and how it
// ended (see live.c) or null. tell(part) gets each row, {row}, and each picture, {picture}, while the driver runs.
function runDriver(module, args, tell = () => {}) {
  const result = {status: 0, printed: "", said: "", rows: [], picture: null, finish: null};
  const encoded = args.map((arg) => new TextEncoder().encode(arg + "\0"));
  const texts = {1: new TextDecoder(), 2: new TextDecoder()};
  let memory = null, row = {};
  const view = () => new DataView(memory.buffer);
  const bytes = (from, size) => new Uint8Array(memory.buffer, from, size);
  const text = (from) => {
    const rest = new Uint8Array(memory.buffer, from);
    return new TextDecoder().decode(rest.subarray(0, rest.indexOf(0)));
  };
  const SUCCESS = 0, BAD_DESCRIPTOR = 8, NOT_FOUND = 44;
  const wasi = {
    args_sizes_get(count, size) {
      view().setUint32(count, encoded.length, true);
      view().setUint32(size, encoded.reduce((sum, text) => sum + text.length, 0), true);
      return SUCCESS;
    },
    args_get(pointers, to) {
      for (const text of encoded) {
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
        text += texts[descriptor].decode(bytes(view().getUint32(vectors + 8 * i, true), size), {stream: true});
        sum += size;
      }
      result[descriptor === 1 ? "printed" : "said"] += text;
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
    picture(rgba, width, height) {
      result.picture = {width, height, rgba: bytes(rgba, 4 * width * height).slice()};
      tell({picture: result.picture});
    },
    cell(column, cell, last) {
      row[text(column)] = text(cell);
      if (!last) return;
      result.rows.push(row);
      tell({row});
      row = {};
    },
    finish(yaw, pitch, distance, build, render) { result.finish = {yaw, pitch, distance, build, render}; },
  };
  // All other calls would need a file.
  const imports = {raykit, wasi_snapshot_preview1: new Proxy(wasi, {get: (calls, name) => calls[name] || (() => NOT_FOUND)})};
  const instance = new WebAssembly.Instance(module, imports);
  memory = instance.exports.memory;
  try {
    instance.exports._start();
  } catch (error) {
    if (!(error instanceof Exit)) throw error;
    result.status = error.status;
  }
  return result;
}
