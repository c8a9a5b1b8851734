// Draws by one module: a worker of a page, or of Node.js. It gets {module, args} and sends a runDriver result with its
// seconds. Who started it ends it when it takes too long.
import {runDriver} from "./instance.mjs";

const port = globalThis.postMessage ? globalThis : (await import("node:worker_threads")).parentPort;

function draw({module, args}) {
  const started = performance.now(), result = runDriver(module, args);
  port.postMessage({...result, seconds: (performance.now() - started) / 1000}, result.pixels ? [result.pixels.buffer] : []);
}

if (port === globalThis) port.onmessage = ({data}) => draw(data);
else port.on("message", draw);
