// Draws the picture of a step as a page does: links a unit that Checker has compiled with its driver, and runs that in a
// worker, which is ended when it takes too long. The unit keeps its checks of memory, which cost a picture less time than
// compiling it again would.

// Returns a driver's options for a picture of this size.
export function sized(args, {width, height}) {
  const others = args.filter((word, i) => ![word, args[i - 1]].some((name) => name === "--width" || name === "--height"));
  return [...others, "--width", String(width), "--height", String(height)];
}

const EXPLAINS = /^camera ray$/m, NO_PIXEL = "there is no pixel to explain"; // the latter of views without a scene
const OF_A_VIEW = /: --([\w-]+) goes with --debug/;

// The options without one, and without its value.
function without(args, option) {
  const at = args.indexOf(option), isAlone = (args[at + 1] ?? "--").startsWith("--");
  return at < 0 ? args : [...args.slice(0, at), ...args.slice(at + (isAlone ? 1 : 2))];
}

export class Drawer {
  #worker = null;
  #stop = null;

  // kit: what `make site` has made: {archives: {"drivers.a", "kit.a"}, drivers: {STEM: object}}. startWorker() starts
  // draw_worker.mjs as a Web Worker, or as what has its interface.
  constructor(toolchain, kit, startWorker) { Object.assign(this, {toolchain, kit, startWorker}); }

  // Returns {bytes, seconds}: the driver's module with this unit, or with {said} why it cannot be linked. others: further
  // units that it may take, note: what it says of them (others.mjs).
  link(stem, object, {others = {}, note = {}} = {}) {
    const started = performance.now();
    const {bytes, said} = this.toolchain.link({"unit.o": object, "driver.o": this.kit.drivers[stem], ...note},
      this.kit.archives, {wrap: ["rk_table_put"], others});
    return {bytes, said, seconds: (performance.now() - started) / 1000};
  }

  // Draws by a module; args: the driver's name and its options. Resolves to {width, height, pixels, printed, said,
  // status, fault, seconds} and what else runDriver has: pixels are RGBA, a Uint8ClampedArray, null if there is no picture;
  // or to null if end() or another draw() ended it. It may take `limit` seconds. Checker.verdict_of finds a fault's place.
  draw(module, args, limit) {
    if (this.#stop) this.end();
    return new Promise((resolve) => {
      const worker = this.#worker = this.#worker || this.startWorker();
      const late = () => {
        const stop = this.#stop;
        this.#stop = null;
        this.end();
        stop({width: 0, height: 0, pixels: null, printed: "", said: "", status: 4, seconds: limit, file: "", line: 0,
          stack: "", fault: `no picture after ${limit} s: a loop that never ends, or code that is very slow`});
      };
      const timer = setTimeout(late, 1000 * limit);
      this.#stop = (result) => {
        this.#stop = null;
        clearTimeout(timer);
        resolve(result);
      };
      worker.onmessage = ({data}) => this.#stop(data);
      worker.postMessage({module, args});
    });
  }

  // Resolves to the driver's explanation of a pixel, [x, y], of the picture that draw() would make, or to why there is
  // none; or to null as draw() does. Some debug views show the scene and do not explain it: then it is explained without them
  // and the options that go with them.
  async explain(module, args, pixel, limit) {
    const asked = async (words) => {
      const result = await this.draw(module, [...words, "--pixel", pixel.join(), "--quiet"], limit);
      return result && (result.fault || result.said + result.printed);
    };
    let words = args, said = await asked(words);
    for (let option = "debug"; said !== null && option && words.includes(`--${option}`) && !EXPLAINS.test(said) && !said.includes(NO_PIXEL);) {
      words = without(words, `--${option}`);
      said = await asked(words);
      [, option] = said?.match(OF_A_VIEW) || [];
    }
    return said;
  }

  // Ends the worker, and the drawing if there is one.
  end() {
    if (this.#worker) this.#worker.terminate();
    this.#worker = null;
    if (this.#stop) this.#stop(null);
  }
}
