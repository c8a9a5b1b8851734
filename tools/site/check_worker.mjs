// The worker of a page that checks units: it gets {site, stem} first, the addresses of what `make site` has made and
// the suite's name, then {id, text} for each save. It sends {loaded}, from 0 to 1, and of each text {id, said, built}, the
// compiler's words, then a {id, verdict} for each claim, and {id, ends} with the seconds that each part took; when asked
// to {draw: step} it, {id, drawn} with the picture of the first step from there on that has one. A newer text ends the
// claims and the picture of the last one.
import {Checker} from "./checker.mjs";
import {Drawer, sized} from "./drawer.mjs";
import {Toolchain} from "./toolchain.mjs";

const LIMIT = 10; // seconds for a claim
const SHORT_LIMIT = 1; // after LATE_CLAIMS that did not end: a loop that the others run into as well
const LATE_CLAIMS = 2;
const PICTURE_LIMIT = 30;
const WORKERS = Math.min(4, navigator.hardwareConcurrency || 1);

let ready = null, latest = null, built = null;

async function load(site, stem) {
  const fetched = async (name) => {
    const answer = await fetch(new URL(name, site));
    if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status} ${answer.statusText}`);
    return answer;
  };
  const bytes = async (name) => new Uint8Array(await (await fetched(name)).arrayBuffer());
  const json = (name) => fetched(name).then((answer) => answer.json());
  const [toolchain, archive, suite, headers, suites, drivers, driver, looks] = await Promise.all([
    Toolchain.load(new URL("clang/bundle.mjs", site).href, (part) => postMessage({loaded: 0.99 * part})),
    bytes("kit.a"), bytes(`suites/${stem}.o`),
    json("headers.json"), json("suites.json"), bytes("drivers.a"), bytes(`drivers/${stem}.o`), json("looks.json")]);
  const kit = {archive, headers, suites: {[stem]: {object: suite, claims: suites[stem]}}};
  const start = (name) => () => new Worker(new URL(name, import.meta.url), {type: "module"});
  const checker = new Checker(toolchain, kit, start("claims_worker.mjs"), WORKERS);
  const drawer = new Drawer(toolchain, {archives: {"drivers.a": drivers, "kit.a": archive}, drivers: {[stem]: driver}},
    start("draw_worker.mjs"));
  checker.compile(stem, `#include "features/${stem}.h"\n`); // the engine compiles clang while it runs
  postMessage({loaded: 1, claims: suites[stem]});
  return {checker, drawer, stem, looks: looks[stem]};
}

// The step's own picture, or that of the next step which has one, or else the last.
async function draw(id, step) {
  const {checker, drawer, stem, looks} = await ready;
  if (id !== latest || !built) return;
  const look = looks.find((other) => other.step >= step) || looks[looks.length - 1], {bytes, said} = drawer.link(stem, built);
  if (!bytes) return postMessage({id, drawn: {look, said}});
  const module = await WebAssembly.compile(bytes);
  if (id !== latest) return;
  const drawn = await drawer.draw(module, [stem, ...sized(look.args, look.wanted)], PICTURE_LIMIT);
  if (!drawn || id !== latest) return;
  const place = drawn.fault ? checker.verdict_of(bytes, drawn).place : "";
  postMessage({id, drawn: {...drawn, look, place}}, drawn.pixels ? [drawn.pixels.buffer] : []);
}

async function check({id, text}) {
  const {checker, drawer, stem} = await ready;
  if (id !== latest) return; // a newer one came meanwhile
  checker.end();
  drawer.end();
  const {object, said, seconds: compile} = checker.compile(stem, text);
  built = object;
  const {bytes, said: why, seconds: link} = object ? checker.link(stem, object) : {};
  postMessage({id, said: said + (why || ""), built: Boolean(bytes)});
  if (!bytes) return postMessage({id, ends: {compile, link}});
  const started = performance.now(), claims = checker.kit.suites[stem].claims.map(({name}) => name);
  const module = await WebAssembly.compile(bytes);
  if (id !== latest) return;
  let late = 0;
  await checker.run(module, bytes, claims, () => late < LATE_CLAIMS ? LIMIT : SHORT_LIMIT, (verdict) => {
    late += verdict.seconds >= LIMIT;
    postMessage({id, verdict});
  });
  if (id === latest) postMessage({id, ends: {compile, link, run: (performance.now() - started) / 1000}});
}

onmessage = ({data}) => {
  if (data.site) {
    ready = load(data.site, data.stem);
    ready.catch((error) => postMessage({failed: error.message}));
  } else if (data.draw) {
    draw(data.id, data.draw).catch((error) => postMessage({id: data.id, failed: error.message}));
  } else {
    latest = data.id;
    check(data).catch((error) => postMessage({id: data.id, failed: error.message}));
  }
};
