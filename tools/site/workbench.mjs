// A page in which a unit is written and checked: workbench.html?STEM. On every pause in typing the text is compiled and
// its claims run (check_worker.mjs); what they say stands beside the step that they belong to. Nothing is sent anywhere.
import {Editor} from "./editor.mjs";
import {compare} from "./compared.mjs";
import {forget, keep, kept} from "./kept.mjs";

const PAUSE = 300; // milliseconds without a key after which a text is checked

const stem = location.search.slice(1).match(/^[a-z_]+/)?.[0] || "normals";
const shown = (id) => document.getElementById(id);
const made = (tag, more = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), more);
  element.append(...children);
  return element;
};
// Texts of this site's own files, made by site_tasks.py.
const html = (tag, text, more) => made(tag, {...more, innerHTML: text});
// Names of claims are sentences in C's spelling.
const sentence = (name) => name.replaceAll("_", " ");

const worker = new Worker(new URL("check_worker.mjs", import.meta.url), {type: "module"});
let id = 0, timer = null, typed = 0, is_loaded = false, starter = "", task = null;

const editor = new Editor(shown("text"), "your code, in C", () => {
  clearTimeout(timer);
  typed = performance.now();
  timer = setTimeout(check, PAUSE);
});

function check() {
  if (task && !keep(stem, editor.keep())) shown("state").textContent = "This browser keeps no more: save the file";
  if (!is_loaded || !task) return;
  shown("state").textContent = "Checking";
  shown("drawn").textContent = "";
  for (const name of ["first", "pictures", "steps"]) shown(name).classList.add("old");
  worker.postMessage({id: ++id, text: editor.text()});
}

// --- The task ---

function hint({title, text}) {
  return made("details", {}, html("summary", `Hint: ${title}`), html("div", text));
}

function step_of({number, write, given, hints, claims, points, sections}) {
  const reading = sections.map((section) => made("a", {href: `book/${task.chapter}${section}`, target: "_blank", rel: "noopener", textContent: section.slice(1).replaceAll("-", " ")}));
  return made("li", {id: `step-${number}`},
    made("h2", {}, `Step ${number} `, made("span", {className: "points", textContent: `${points} points`})),
    html("div", write), made("details", {}, made("summary", {textContent: "Given"}), made("ul", {}, ...given.map((text) => html("li", text)))),
    ...hints.map(hint), ...(task.has_book ? [made("p", {}, "Read: ", ...reading.flatMap((link, i) => i ? [", ", link] : [link]))] : []),
    made("ul", {className: "claims"}, ...claims.map(claim_of)));
}

const claim_of = (name) => made("li", {id: name, textContent: sentence(name)});

function show_task() {
  document.title = `${task.title}: raykit`;
  shown("title").textContent = task.title[0].toUpperCase() + task.title.slice(1);
  shown("goal").replaceChildren(html("div", task.goal), made("p", {textContent: `Time: ${task.hours}`}));
  const others = made("li", {}, made("h2", {textContent: "What holds from the beginning"}), made("ul", {className: "claims"}, ...task.kept.map(claim_of)));
  shown("steps").replaceChildren(...task.steps.map(step_of), ...(task.kept.length ? [others] : []));
}

// --- Verdicts ---

const claims = () => [...document.querySelectorAll(".claims li")];
const step_of_claim = (name) => task.steps.find((step) => step.claims.includes(name));

// A button that leads to a line of the unit; for a place elsewhere its text.
function place_of(place) {
  const line = place.match(new RegExp(`^${stem}\\.c:(\\d+)$`))?.[1];
  return line ? made("button", {className: "place", textContent: `line ${line}`, onclick: () => editor.show(Number(line))}) : place;
}

function show_verdict({claim, verdict, message, place}) {
  const item = shown(claim), said = verdict === "passed" ? [] : [made("small", {}, message, ...(place ? [" (", place_of(place), ")"] : []))];
  item.dataset.verdict = verdict;
  item.classList.remove("old");
  item.replaceChildren(sentence(claim), ...said);
}

// What is to be worked on, in the place that is seen first.
function show_box(title, message, place) {
  shown("first").hidden = false;
  shown("first").classList.remove("old");
  shown("first").replaceChildren(made("strong", {textContent: title}), made("pre", {textContent: message}),
    ...(place ? [made("p", {}, "in ", place_of(place))] : []));
}

// The first claim of the assignment's order that does not hold is the one to work on. Returns its step's number, or the
// last one's.
function show_first(verdicts) {
  const all = [...task.steps.flatMap((step) => step.claims), ...task.kept];
  const first = all.map((name) => verdicts.get(name)).find((verdict) => verdict && verdict.verdict !== "passed");
  shown("first").hidden = !first;
  for (const item of shown("steps").children) item.classList.remove("current");
  const last = task.steps[task.steps.length - 1].number;
  if (!first) return last;
  const step = step_of_claim(first.claim);
  if (step) shown(`step-${step.number}`).classList.add("current");
  show_box(`${step ? `Step ${step.number}: ` : ""}${sentence(first.claim)}`, first.message, first.place);
  const line = first.place.match(new RegExp(`^${stem}\\.c:(\\d+)$`))?.[1];
  if (line) editor.mark([{line: Number(line), message: first.message, severity: "error"}]);
  return step ? step.number : last;
}

// --- The picture ---

async function show_drawn({look, pixels, width, height, said, fault, place, seconds}) {
  shown("pictures").hidden = !pixels;
  shown("pictures").classList.remove("old");
  shown("caption").textContent = `wanted: ${look.caption}`;
  if (!pixels) {
    shown("drawn").replaceChildren(`Step ${look.step} draws nothing: ${fault || said.trim()}`, ...(place ? [" (", place_of(place), ")"] : []));
    return;
  }
  const canvases = Object.fromEntries(["own", "wanted", "difference"].map((name) => [name, shown(name)]));
  const differ = await compare(canvases, {pixels, width, height}, look.picture), share = (100 * differ / (width * height)).toFixed(1);
  shown("drawn").textContent = `Step ${look.step}: ${differ ? `${share} % of the pixels differ` : "the wanted picture"}; drawn in ${seconds.toFixed(2)} s`;
}

const FINDING = /^([\w.]+\.c):(\d+):\d+: (?:fatal )?(error|warning): (.*)$/gm;

// The linker names a function that is missing once for each call.
function without_repetitions(said) {
  const missing = [...new Set([...said.matchAll(/undefined symbol: (\w+)/g)].map(([, name]) => name))];
  return missing.length ? `Your file does not define ${missing.join(", ")}.` : said;
}

function show_said(words, built) {
  const said = without_repetitions(words);
  shown("said").textContent = said;
  shown("said").hidden = !said;
  editor.mark([...said.matchAll(FINDING)].filter(([, file]) => file === `${stem}.c`)
    .map(([, , line, severity, message]) => ({line: Number(line), severity, message})));
  for (const item of claims()) item.classList.add("old");
  shown("steps").classList.remove("old");
  if (built) return;
  const [, , line, , message] = [...said.matchAll(FINDING)].find(([, , , severity]) => severity === "error") || [];
  shown("state").textContent = "The compiler finds an error";
  show_box("The compiler finds an error", message || said.trim(), line ? `${stem}.c:${line}` : "");
}

let verdicts = new Map();

function show_end(seconds) {
  const passed = [...verdicts.values()].filter(({verdict}) => verdict === "passed").length;
  const after = ((performance.now() - typed) / 1000).toFixed(2);
  for (const step of task.steps) {
    const is_solved = step.claims.every((name) => verdicts.get(name)?.verdict === "passed");
    shown(`step-${step.number}`).classList.toggle("solved", is_solved);
  }
  const next = passed === claims().length ? ". Save the file, and choose the next assignment above." : "";
  shown("state").textContent = `${passed} of ${claims().length} claims hold${next}`;
  shown("seconds").textContent = `${after} s after the last key: ` +
    Object.entries(seconds).filter(([, value]) => value !== undefined).map(([part, value]) => `${part} ${value.toFixed(2)} s`).join(", ");
  worker.postMessage({id, draw: show_first(verdicts)});
}

worker.onmessage = ({data}) => {
  if (data.id !== undefined && data.id !== id) return;
  if (data.failed) shown("state").textContent = `It does not go on: ${data.failed}`;
  if (data.loaded !== undefined) shown("loaded").value = data.loaded;
  if (data.claims) {
    shown("loaded").hidden = is_loaded = true;
    check();
  }
  if (data.said !== undefined) {
    verdicts = new Map();
    show_said(data.said, data.built);
  }
  if (data.verdict) {
    verdicts.set(data.verdict.claim, data.verdict);
    show_verdict(data.verdict);
    shown("state").textContent = `Checking: ${verdicts.size} of ${claims().length}`;
    if (data.verdict.verdict !== "passed") show_first(verdicts);
  }
  if (data.ends && data.ends.run !== undefined) show_end(data.ends);
  if (data.drawn) show_drawn(data.drawn);
};
worker.onerror = () => { shown("state").textContent = "It does not go on: this browser has no workers that are modules"; };

// --- Files ---

shown("save").onclick = () => {
  const link = made("a", {href: URL.createObjectURL(new Blob([editor.text()], {type: "text/x-c"})), download: `${stem}.c`});
  link.click();
  URL.revokeObjectURL(link.href);
};
shown("open").onclick = () => shown("file").click();
shown("file").onchange = async () => {
  const [file] = shown("file").files;
  if (file) editor.replace(await file.text());
  shown("file").value = "";
};
shown("again").onclick = () => {
  if (!confirm("Put the starter in place of your text? Undo (Ctrl+Z) brings it back.")) return;
  editor.replace(starter);
  editor.foldGiven();
};

// --- The beginning ---

async function fetched(name) {
  const answer = await fetch(name);
  if (!answer.ok) throw new Error(`${name} cannot be loaded: ${answer.status} ${answer.statusText}`);
  return answer;
}

async function begin() {
  const [course, text, own] = await Promise.all([fetched("tasks/course.json").then((answer) => answer.json()),
    fetched(`starters/${stem}.c`).then((answer) => answer.text()), fetched(`tasks/${stem}.json`).then((answer) => answer.json())]);
  starter = text;
  task = own;
  shown("assignment").replaceChildren(...course.map(({stem: other, number, title}) =>
    made("option", {value: other, selected: other === stem, textContent: `${number} ${title}`})));
  shown("assignment").onchange = ({target}) => { location.search = target.value; };
  show_task();
  const before = kept(stem);
  try {
    editor.open(starter, before);
  } catch { // kept by an older page
    forget(stem);
    editor.open(starter);
  }
  if (!before) {
    editor.foldGiven();
    editor.showFirstStep();
  }
  check();
}

if ("serviceWorker" in navigator) navigator.serviceWorker.register("service_worker.js");
begin().catch((error) => { shown("state").textContent = `It does not go on: ${error.message}`; });
worker.postMessage({site: new URL("./", location.href).href, stem});
