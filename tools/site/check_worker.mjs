// The worker of a page that checks units: it gets {site, stem} first, the addresses of what `make site` has made and the
// suite's name, then {id, text, others} for each save, others: the texts of the course's other units. It sends {looks},
// the steps with a picture, {loaded}, from 0 to 1, and of each text {id, said, built}, the compiler's words, then a
// {id, verdict} for each claim, {id, ends} with the seconds that each part took, and {id, located}, the verdict of a claim
// that did not end with its place; when asked to {draw: step} it, {id, drawn} with the picture of the first step from
// there on that has one, and to {explain: pixel}, {id, explained: {pixel, texts}}: how the unit comes to that
// pixel, and how the kit's does if the site has it. A newer text ends the claims and the picture of the last one; that
// one will come is told by {typing: true}. A text that was built at the last visit is checked and drawn before clang is
// loaded.
import {Builds} from "./builds.mjs";
import {Checker} from "./checker.mjs";
import {Drawer, sized} from "./drawer.mjs";
import {Others} from "./others.mjs";
import {unpacked} from "./packed.mjs";
import {TRACED, Toolchain} from "./toolchain.mjs";

const LIMIT = 10; // seconds for a claim
const SHORT_LIMIT = 1; // after LATE_CLAIMS that did not end: a loop that the others run into as well
const LATE_CLAIMS = 2;
const PICTURE_LIMIT = 30;
const REST = 1000; // milliseconds without a question after which clang is used for itself
const EXTRA_BUILDS = 10;
const WORKERS = Math.min(4, navigator.hardwareConcurrency || 1);

let kit = null, tools = null, latest = null, texts = null, build = null, shown = null, reference = null;
let course = null, questions = 0, rest = null, extra_builds = 0; // of course: the Others, once clang is loaded
let located = null; // resolves when a claim that did not end has its place

async function fetched(name) {
  const answer = await fetch(new URL(name, kit.site));
  if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status} ${answer.statusText}`);
  return answer;
}

const json = async (name) => (await fetched(name)).json();
const packed = async (name) => unpacked(await fetched(`${name}.gz`));
const bytes = async (name) => new Uint8Array(await (await packed(name)).arrayBuffer());

async function begin({site, stem}) {
  const start = (name) => () => new Worker(new URL(name, import.meta.url), {type: "module"});
  kit = {site, stem, builds: new Builds(site, stem), suites: json_once("suites.json"), looks: json_once("looks.json"),
    checker: new Checker(null, {suites: {[stem]: {}}}, start("claims_worker.mjs"), WORKERS), drawer: new Drawer(null, {}, start("draw_worker.mjs"))};
  postMessage({looks: (await kit.looks()).map(({step, caption}) => ({step, caption}))});
}

function json_once(name) {
  let value = null;
  return () => value ??= json(name).then((all) => all[kit.stem]).catch((error) => {
    value = null; // the next text asks again
    throw error;
  });
}

// Loads clang and what it links units with, once. Resolves to the units of the course.
function loaded() {
  return tools ??= load().catch((error) => {
    tools = null;
    throw error;
  });
}

async function load() {
  const {site, stem, checker, drawer} = kit;
  const [toolchain, archive, object, headers, claims, open, drivers, driver] = await Promise.all([
    Toolchain.load(new URL("clang/bundle.mjs", site).href, (part) => postMessage({loaded: 0.99 * part})),
    bytes("kit.a"), bytes(`suites/${stem}.o`), packed("headers.json").then((answer) => answer.json()), kit.suites(), json("open.json"),
    bytes("drivers.a"), bytes(`drivers/${stem}.o`)]);
  const starters = Object.fromEntries(await Promise.all(open.stems.map(async (other) => [other, await bytes(`open/${other}.o`)])));
  Object.assign(checker, {toolchain, kit: {archive, headers, suites: {[stem]: {object, claims}}}});
  Object.assign(drawer, {toolchain, kit: {archives: {"drivers.a": drivers, "kit.a": archive}, drivers: {[stem]: driver}}});
  checker.compile(stem, `#include "features/${stem}.h"\n`); // the engine compiles clang while it runs
  postMessage({loaded: 1});
  return course = new Others(checker, open, starters);
}

// Engines optimize clang as it is used, and a page that rests has time for that: the last text is built some times more.
function build_again() {
  if (!course || !texts || extra_builds === EXTRA_BUILDS) return;
  extra_builds++;
  built(texts, course);
  rest = setTimeout(build_again, REST);
}

// The driver's module with this unit, linked when it is first drawn.
async function linked_driver() {
  if (build.driver || build.undrawn) return;
  const of = build, others = await loaded(), {bytes: driver, said} = others.driver(kit.drawer, kit.stem, of.object, texts.others);
  Object.assign(of, driver ? {driver} : {undrawn: said});
}

// The step's own picture, or that of the next step which has one, or else the last.
async function draw(id, step) {
  const {checker, drawer, stem} = kit, looks = await kit.looks();
  if (id !== latest || !build?.suite) return;
  await located; // the line first: a loop that does not end has no picture either
  await linked_driver();
  if (id !== latest) return;
  const look = looks.find((other) => other.step >= step) || looks[looks.length - 1], {driver, undrawn} = build;
  if (!driver) return postMessage({id, drawn: {look, said: undrawn}});
  const module = await WebAssembly.compile(driver);
  if (id !== latest) return;
  const drawn = await drawer.draw(module, [stem, ...sized(look.args, look.wanted)], PICTURE_LIMIT);
  if (!drawn || id !== latest) return;
  shown = {look, module};
  const place = drawn.fault ? checker.verdict_of(driver, drawn).place : "";
  postMessage({id, drawn: {...drawn, look, place}}, drawn.pixels ? [drawn.pixels.buffer] : []);
  keep();
}

// For the next visit; without the object, which is linked by then, and the seconds, which it will not take.
function keep() {
  const {object, seconds, ...kept} = build;
  kit.builds.keep(texts, {...kept, places: [...kit.checker.places], took: [...kit.checker.took]});
}

// The driver's module with the kit's unit, linked when it is first asked for.
async function linked_reference({reference: name}) {
  await loaded();
  const linked = kit.drawer.link(kit.stem, await bytes(name));
  if (!linked.bytes) throw new Error(`the kit's unit cannot be linked: ${linked.said}`);
  return WebAssembly.compile(linked.bytes);
}

async function explain(id, pixel) {
  const {look, module} = shown, args = [kit.stem, ...sized(look.args, look.wanted)];
  const of = (unit) => kit.drawer.explain(unit, args, pixel, PICTURE_LIMIT), explained = [await of(module)];
  if (look.reference && explained[0] !== null && id === latest) {
    reference = reference || await linked_reference(look);
    explained.push(await of(reference));
  }
  if (id === latest && !explained.includes(null)) postMessage({id, explained: {pixel, texts: explained}});
}

// Returns what the texts are built into: {said, why, suite, starters, seconds}, and the unit's object.
function built({text, others: other_texts}, others) {
  const {checker, stem} = kit, {object, said, seconds: compile} = checker.compile(stem, text);
  const {bytes: suite = null, said: why = "", seconds: link, starters} = object ? others.suite(stem, object, other_texts) : {};
  return {object, said, why, suite, starters, seconds: {compile, link}};
}

async function check({id, text, others}) {
  const {checker, drawer} = kit, asked = {text, others};
  checker.end();
  drawer.end();
  const kept = tools ? null : await kit.builds.kept(asked), units = kept ? null : await loaded();
  if (id !== latest) return; // a newer one came meanwhile
  texts = asked;
  build = kept || built(asked, units);
  checker.places = new Map(build.places);
  if (kept) checker.took = new Map(build.took);
  const {said, why, suite, starters, seconds} = build, claims = (await kit.suites()).map(({name}) => name);
  postMessage({id, said: said + why, built: Boolean(suite)});
  if (!suite) {
    postMessage({id, ends: seconds});
    return keep();
  }
  const started = performance.now(), module = await WebAssembly.compile(suite);
  if (id !== latest) return;
  let late = 0, unended = null;
  await checker.run(module, suite, claims, () => late < LATE_CLAIMS ? LIMIT : SHORT_LIMIT, (verdict) => {
    if (verdict.seconds >= LIMIT) {
      late++;
      unended ??= verdict;
    }
    postMessage({id, verdict});
  });
  if (id === latest) postMessage({id, ends: {...seconds, starters, run: (performance.now() - started) / 1000}});
  if (id === latest && unended) await (located = locate(id, unended));
}

// Says where in the unit a claim is that did not end: it runs again, and stops there after some seconds (memory.c).
async function locate(id, unended) {
  const {checker, stem} = kit, others = await loaded();
  if (id !== latest) return;
  const {object} = checker.compile(stem, texts.text, TRACED), {bytes: suite} = others.suite(stem, object, texts.others);
  const module = await WebAssembly.compile(suite);
  if (id !== latest) return;
  await checker.run(module, suite, [unended.claim], () => LIMIT, ({place}) => {
    if (place.startsWith(`${stem}.c:`)) postMessage({id, located: {...unended, place, message: `${unended.message}; when it ran again, it was still here after 5 s`}});
  });
}

async function answer(data) {
  if (data.site) return begin(data);
  if (data.draw) await draw(data.id, data.draw);
  else if (data.explain) await explain(data.id, data.explain);
  else await check(data);
  if (data.draw || !build?.suite) await loaded(); // no earlier: the two processors have a kept picture to draw
}

onmessage = async ({data}) => {
  clearTimeout(rest);
  if (data.typing) return;
  if (data.text !== undefined) latest = data.id;
  questions++;
  await answer(data).catch((error) => postMessage({id: data.id, failed: error.message}));
  questions--;
  clearTimeout(rest);
  if (questions === 0) rest = setTimeout(build_again, REST);
};
