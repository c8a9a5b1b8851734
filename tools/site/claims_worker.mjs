// Runs claims, each in an instance of its own: a worker of a page, or of Node.js. It gets {module, claim} and sends what
// runSuite returns, with the claim and its seconds, and before that the parts of what is printed, {printed} or {said}. Who started it ends it when that takes too long.
import {runSuite} from "./instance.mjs";

const port = globalThis.postMessage ? globalThis : (await import("node:worker_threads")).parentPort;

function run({module, claim}) {
  const started = performance.now(), result = runSuite(module, ["--only", claim], {}, (part) => port.postMessage(part));
  port.postMessage({...result, claim, seconds: (performance.now() - started) / 1000});
}

if (port === globalThis) port.onmessage = ({data}) => run(data);
else port.on("message", run);
