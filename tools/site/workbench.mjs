// A page in which a unit is written and checked: workbench.html?STEM. On every pause in typing the text is compiled and
// its claims run (check_worker.mjs); what they say stands beside the step that they belong to. Nothing is sent anywhere.
import {Editor, with_text} from "./editor.mjs";
import {BLACK_AT, compare} from "./compared.mjs";
import {asked, html, made, shown} from "./elements.mjs";
import {download, open_files, save_all} from "./files.mjs";
import {keep, kept} from "./kept.mjs";
import {unpacked} from "./packed.mjs";
import {Pixel} from "./pixel.mjs";
import {UNWRITTEN, said_of_wanted, show_said, show_undrawn} from "./said.mjs";
import {link_functions, place_in_suite, show_task} from "./task.mjs";
import {Verdicts, show_box} from "./verdicts.mjs";
import {Work} from "./work.mjs";

const PAUSE = 300; // milliseconds without a key after which a text is checked

const stem = location.search.slice(1).match(/^[a-z_]+/)?.[0] || "normals";

const worker = new Worker(new URL("check_worker.mjs", import.meta.url), {type: "module"});
let id = 0, timer = null, typed = 0, is_loaded = false, starter = "", task = null, verdicts = null, course = [], findings = [], chosen = null, seen = "", drawable = [], is_empty = false;

const editor = new Editor(shown("text"), "your code, in C", () => {
  clearTimeout(timer);
  typed = performance.now();
  timer = setTimeout(check, PAUSE);
  worker.postMessage({typing: true});
  shown("shared").replaceChildren();
});

shown("text").inert = true; // what is typed before the kept text is there would be lost

// What another tab has changed is compiled when this one is seen.
const work = new Work(stem, editor, ({is_later, text}) => {
  if (is_later) {
    shown("shared").replaceChildren("Another tab changed this text at the same time. ",
      made("button", {textContent: "Take its text", onclick: () => editor.replace(text)}));
    return;
  }
  shown("shared").textContent = "Another tab changed this text, and this one was updated.";
  if (document.visibilityState === "visible") check();
  else addEventListener("visibilitychange", check, {once: true});
});

const no_room = () => { shown("shared").textContent = "This browser keeps no more: save the file"; };

// The texts of the other assignments that this browser keeps.
function others() {
  const texts = course.filter((other) => other.stem !== stem).map((other) => [other.stem, kept(other.stem)?.doc]);
  return Object.fromEntries(texts.filter(([, text]) => text !== undefined));
}

const BEFORE = ", from before your last change";

function check() {
  if (!task) return;
  if (!work.save()) no_room();
  shown("state").textContent = is_loaded ? "Checking" : "Loading the compiler";
  shown("drawn").textContent = "";
  if (!shown("whose").textContent.endsWith(BEFORE)) shown("whose").textContent += BEFORE;
  for (const name of ["first", "compiler", "pictures", "steps"]) shown(name).classList.add("old");
  const text = editor.text();
  is_empty = !text.trim();
  worker.postMessage({id: ++id, text, others: others()});
}

// --- Verdicts ---

const line_of = (place) => Number(place.match(new RegExp(`^${stem}\\.c:(\\d+)$`))?.[1] || 0);

// A button that leads to a line of the unit; for a place elsewhere its text.
function place_of(place) {
  const line = line_of(place);
  return line ? made("button", {className: "place", textContent: `line ${line}`, onclick: () => editor.show(line)}) : place_in_suite(task, place);
}

// Returns the step to draw: that of the claim to work on, or the last one. If the next picture is of one that is left to
// write, there is one before it of what was written.
function show_first() {
  const first = verdicts.show_first(), line = first ? line_of(first.place) : 0;
  if (line) editor.mark([...findings, {line, message: first.message, severity: "error"}]);
  const step = first?.step || task.steps[task.steps.length - 1].number;
  const is_open = is_unwritten(drawable.find((number) => number >= step) ?? step);
  return is_open && drawable.findLast((number) => number < step && !is_unwritten(number)) || step;
}

// --- The picture ---

const pixel = new Pixel({pictures: shown("pictures"), own: shown("own"), wanted: shown("wanted"), said: shown("pixel"),
  explained: shown("explained")}, (place) => {
  if (!shown("pictures").classList.contains("old")) worker.postMessage({id, explain: place});
});

const ORDINALS = ["First", "Second", "Third", "Fourth", "Fifth", "Sixth", "Seventh", "Eighth", "Ninth"]; // as starters say

const squeezed = (text) => text.replace(/\s+/g, " ");

// Whether this step is left to write: its claims fail, and what the starter has in its place stands in the text as it was.
function is_unwritten(step) {
  const claims = task.steps.find(({number}) => number === step)?.claims || [], text = squeezed(editor.text());
  const left = starter.match(new RegExp(`\\b${ORDINALS[step - 1]} step\\b[^]*?^\\}`, "gm")) || [];
  return !claims.every((name) => verdicts.holds(name)) && left.length > 0 && left.every((part) => text.includes(squeezed(part)));
}

const STAND_IN = "the picture is traced through the renderer's own tree"; // says a driver

// Why a picture is not the student's work: {whose, why}; or null.
function instead({step, args}, said) {
  if (!args.includes("--debug") && said.includes(STAND_IN)) return {whose: "not by your code yet", why: "your tree finds no triangles yet, and the kit's is used in its place"};
  return is_unwritten(step) ? {whose: `by your code, without step ${step}`, why: UNWRITTEN} : null;
}

function said_of_picture({step}, share) {
  return share ? `${share} % of the pixels differ` : said_of_wanted(verdicts.is_broken(step));
}

function without_picture(step, words, place) {
  const reason = is_unwritten(step) ? "is not written yet, and draws nothing" : `draws nothing${place ? "" : ", and the program says why"}`;
  show_undrawn(`Step ${step} ${reason}`, words, {open: !is_unwritten(step), more: place ? [" (", place_of(place), ")"] : []});
}

// The driver's words of the units of a course that the picture lacks.
const starters_named = (said) => said.match(/^\w+(: .* still the starters?);/m)?.[1] || "";

async function show_drawn({look, pixels, width, height, said, fault, place, seconds}) {
  const of = id, canvases = Object.fromEntries(["own", "wanted", "difference"].map((name) => [name, shown(name)]));
  const differ = pixels ? await compare(canvases, {pixels, width, height}, look.picture) : 0, share = (100 * differ / (width * height)).toFixed(1);
  if (of !== id) return; // a newer text is checked
  shown("pictures").hidden = shown("pixel").hidden = shown("explained").hidden = !pixels;
  shown("pictures").classList.remove("old");
  shown("caption").textContent = `wanted: ${look.caption}`;
  for (const one of shown("looks").children) one.ariaPressed = one.value ? String(Number(one.value) === look.step) : null;
  if (!pixels) return without_picture(look.step, fault || said.trim(), place);
  const other = instead(look, said);
  shown("whose").textContent = other?.whose || "by your code";
  shown("legend").textContent = differ ? `where they differ: white is equal, black differs by ${BLACK_AT} of 255 or more` : "equal";
  shown("drawn").textContent = `Step ${look.step}: ${other?.why || said_of_picture(look, differ && share)}; drawn in ${seconds.toFixed(2)} s${starters_named(said)}`;
  pixel.drawn(look.step, look.args.includes("--debug"));
}

// What to do when all claims hold.
function next() {
  const other = course[course.findIndex((one) => one.stem === stem) + 1];
  const [href, textContent] = other ? [`workbench.html?${other.stem}`, `${other.number} ${other.title}`] : ["index.html", "all assignments"];
  return [`. ${other ? "Next" : "This was the last one"}: `, made("a", {href, textContent})];
}

function show_end({starters, ...seconds}) {
  const {passed, names: {length: all}} = verdicts, after = ((performance.now() - typed) / 1000).toFixed(2);
  verdicts.show_solved();
  verdicts.show_printed();
  verdicts.show_unwritten(task.steps.map(({number}) => number).filter(is_unwritten));
  if (!work.save({passed, claims: all})) no_room();
  const needed = starters.length ? [`. It needs ${starters.join(" and ")}, still the starter: solve that first`] : [];
  shown("state").replaceChildren(`${passed} of ${all} claims hold`, ...(passed === all ? next() : needed));
  shown("seconds").textContent = (typed ? `${after} s after the last key: ` : "") +
    Object.entries(seconds).filter(([, value]) => value !== undefined).map(([part, value]) => `${part} ${value.toFixed(2)} s`).join(", ");
  const step = show_first();
  worker.postMessage({id, draw: chosen || step});
}

// That the text is not built is said below the head as well, unless it is no text.
function show_unbuilt() {
  shown("state").textContent = is_empty ? "The file is empty" : "The compiler found an error";
  if (is_empty) show_box("The file is empty", "\"Start over\", at the top of this page, brings the starter back.", "");
}

// Buttons for each step's picture, and for the one to work on.
function show_looks(looks) {
  drawable = looks.map(({step}) => step);
  const button = (textContent, step, title = "") => made("button", {textContent, title, value: step || "", onclick() {
    chosen = step;
    if (!verdicts?.size) return; // it follows the verdict
    shown("pictures").classList.add("old");
    worker.postMessage({id, draw: step || show_first()});
  }});
  shown("looks").replaceChildren("Picture of ", ...looks.map(({step, caption}) => button(`step ${step}`, step, caption)),
    button("the first that is not done", null));
}

worker.onmessage = ({data}) => {
  if (data.id !== undefined && data.id !== id) return;
  if (data.failed) tell({message: data.failed});
  if (data.looks) show_looks(data.looks);
  if (data.loaded !== undefined) {
    shown("loaded").value = data.loaded;
    shown("loaded").hidden = is_loaded = data.loaded === 1;
  }
  if (data.said !== undefined) {
    verdicts = new Verdicts(task, place_of);
    seen = "";
    findings = show_said(data.said, data.built, place_of).filter(({file}) => file === `${stem}.c`)
      .map(({severity, ...finding}) => ({...finding, severity: severity === "note" ? "info" : severity}));
    editor.mark(findings);
    if (!data.built) show_unbuilt();
  }
  if (data.verdict) {
    verdicts.put(data.verdict);
    shown("state").textContent = `Checking: ${verdicts.size} of ${verdicts.names.length}`;
    const {claim, place} = verdicts.first || {};
    if (claim && `${claim} ${place}` !== seen) show_first();
    seen = `${claim} ${place}`;
  }
  if (data.ends && data.ends.run !== undefined) show_end(data.ends);
  if (data.located) {
    verdicts.put(data.located);
    show_first();
  }
  if (data.drawn) show_drawn(data.drawn);
  if (data.explained) pixel.show({...data.explained, isWritten: !task.steps.some(({number}) => is_unwritten(number))});
};
worker.onerror = () => { shown("state").textContent = "It does not go on: this browser has no workers that are modules"; };

// --- Files ---

function tell({message}) {
  const remedy = /network|failed to fetch/i.test(message) ? ". Reload this page when the network is back" : "";
  shown("state").textContent = `It does not go on: ${message}${remedy}`;
}

const text_of = (other) => other === stem ? editor.text() : kept(other)?.doc;
const task_of = async (name) => (await unpacked(await fetched(`tasks/${name}.json.gz`))).json();
const workbook = () => task_of("workbook");

const save = () => download(`${stem}.c`, editor.text(), "text/x-c");

async function open(files) {
  const starters = (await workbook()).files, starter_of = (other) => starters[`${other}.c`];
  await open_files(files, {stem, stems: course.map((other) => other.stem), starter_of,
    title_of: (wanted) => course.filter((other) => other.stem === wanted).map(({number, title}) => `${number} ${title}`)[0],
    text_of: (other) => text_of(other) ?? starter_of(other),
    put(other, text) {
      if (other === stem) {
        editor.replace(text);
        editor.focus();
      } else if (!keep(other, with_text(kept(other), starter_of(other), text))) no_room();
    }});
}

shown("save").onclick = save;
shown("save-all").onclick = () => workbook().then((all) => save_all(all, course.map((other) => other.stem), text_of)).catch(tell);
shown("open").onclick = () => shown("file").click();
shown("file").onchange = () => {
  const files = [...shown("file").files];
  shown("file").value = "";
  open(files).catch(tell);
};
addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.altKey || event.shiftKey || event.key !== "s") return;
  event.preventDefault();
  save();
});
shown("again").onclick = async () => {
  const answer = await asked("Start over?", [made("p", {textContent: "The starter takes the place of your text. Undo (Ctrl+Z) brings it back."})],
    {again: "Start over", "": "Cancel"});
  if (answer !== "again") return;
  editor.replace(starter);
  editor.foldGiven();
  editor.focus();
};

// --- The beginning ---

async function fetched(name) {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status} ${answer.statusText}`);
  return answer;
}

async function header_in(name) {
  return name.split("/").reduce((tree, part) => tree[part], await (await unpacked(await fetched("headers.json.gz"))).json());
}

async function begin() {
  course = await task_of("course");
  if (!course.some((other) => other.stem === stem)) throw new Error(`there is no assignment ${stem}: the first page lists them`);
  const [text, own] = await Promise.all([fetched(`starters/${stem}.c`).then((answer) => answer.text()), task_of(stem)]);
  starter = text;
  task = own;
  shown("save").textContent = `Save ${stem}.c`;
  shown("assignment").replaceChildren(...course.map(({stem: other, number, title}) =>
    made("option", {value: other, selected: other === stem, textContent: `${number} ${title}`})));
  shown("assignment").onchange = ({target}) => { location.search = target.value; };
  show_task(task, {element: html, header_text: header_in});
  link_functions(starter, () => editor.text(), (line) => editor.show(line));
  document.getElementById(decodeURIComponent(location.hash.slice(1)))?.scrollIntoView(); // from a chapter: #step-2
  if (!work.open(starter)) {
    editor.foldGiven();
    editor.showFirstStep();
  }
  shown("text").inert = false;
  check();
}

if ("serviceWorker" in navigator) navigator.serviceWorker.register("service_worker.js");
worker.postMessage({site: new URL("./", location.href).href, stem});
begin().catch((error) => {
  worker.terminate();
  tell(error);
});
