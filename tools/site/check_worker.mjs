// The worker of a page that checks units: it gets {site, stem} first, the addresses of what `make site` has made and
// the suite's name, then {text} for each save. It sends {loaded}, from 0 to 1, and of each text {id, said, built}, the
// compiler's words, then a {id, verdict} for each claim, and {id, ends} with the seconds that each part took. A newer
// text ends the claims of the last one.
import {Checker} from "./checker.mjs";
import {Toolchain} from "./toolchain.mjs";

const LIMIT = 10; // seconds for a claim
const WORKERS = Math.min(4, navigator.hardwareConcurrency || 1);

let ready = null, latest = null;

async function load(site, stem) {
  const fetched = async (name) => {
    const answer = await fetch(new URL(name, site));
    if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status} ${answer.statusText}`);
    return answer;
  };
  const bytes = async (name) => new Uint8Array(await (await fetched(name)).arrayBuffer());
  const [toolchain, archive, suite, headers, suites] = await Promise.all([
    Toolchain.load(new URL("clang/bundle.mjs", site).href, (part) => postMessage({loaded: 0.99 * part})),
    bytes("kit.a"), bytes(`suites/${stem}.o`),
    fetched("headers.json").then((answer) => answer.json()), fetched("suites.json").then((answer) => answer.json())]);
  const kit = {archive, headers, suites: {[stem]: {object: suite, claims: suites[stem]}}};
  const start = () => new Worker(new URL("claims_worker.mjs", import.meta.url), {type: "module"});
  const checker = new Checker(toolchain, kit, start, WORKERS);
  checker.compile(stem, `#include "features/${stem}.h"\n`); // the engine compiles clang while it runs
  postMessage({loaded: 1, claims: suites[stem]});
  return {checker, stem};
}

async function check({id, text}) {
  const {checker, stem} = await ready;
  if (id !== latest) return; // a newer one came meanwhile
  checker.end();
  const {object, said, seconds: compile} = checker.compile(stem, text);
  const {bytes, said: why, seconds: link} = object ? checker.link(stem, object) : {};
  postMessage({id, said: said + (why || ""), built: Boolean(bytes)});
  if (!bytes) return postMessage({id, ends: {compile, link}});
  const started = performance.now(), claims = checker.kit.suites[stem].claims.map(({name}) => name);
  const module = await WebAssembly.compile(bytes);
  if (id !== latest) return;
  await checker.run(module, bytes, claims, LIMIT, (verdict) => postMessage({id, verdict}));
  if (id === latest) postMessage({id, ends: {compile, link, run: (performance.now() - started) / 1000}});
}

onmessage = ({data}) => {
  if (data.site) {
    ready = load(data.site, data.stem);
    ready.catch((error) => postMessage({failed: error.message}));
  } else {
    latest = data.id;
    check(data).catch((error) => postMessage({id: data.id, failed: error.message}));
  }
};
