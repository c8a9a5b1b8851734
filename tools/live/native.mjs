// The workbench as `make live-STEM` shows it: the student's file is edited elsewhere, and after each save the server
// (tools/live_loop.py) draws and checks it. It tells all that is known whenever something of it changes.
import {made, plain, shown} from "./elements.mjs";
import {Pixel} from "./pixel.mjs";
import {UNWRITTEN, said_of_wanted, show_said, show_undrawn} from "./said.mjs";
import {place_in_suite, show_task} from "./task.mjs";
import {Verdicts} from "./verdicts.mjs";

const PICTURES = ["own", "wanted", "difference"];

let known = {}, verdicts = null;

const button = (textContent, onclick, more = {}) => made("button", {textContent, onclick, ...more});
const answer = async (address) => {
  const reply = await fetch(address);
  if (!reply.ok) throw new Error(`${address}: ${reply.status} ${reply.statusText}`);
  return reply;
};
const place_of = (place) => place_in_suite(verdicts.task, place); // the student's editor is not ours to open

// Without an editor in the page, the pictures have its place.
shown("explained").before(shown("first"), shown("compiler"), shown("looks"), shown("pictures"), shown("drawn"), shown("pixel"));

const pixel = new Pixel({pictures: shown("pictures"), own: shown("own"), wanted: shown("wanted"), said: shown("pixel"),
  explained: shown("explained")}, async (place) => {
  if (!known.drawn) return shown("explained").replaceChildren("The pixel is explained once there is a picture of this save.");
  return pixel.show({pixel: place, texts: await (await answer(`/pixel?${place}`)).json()});
});

// --- The task ---

async function begin({kit, looks}) {
  const task = await (await answer("/task")).json();
  show_task(task, {element: plain, header_text: async (header) => (await answer(`/src/${header}`)).text()});
  verdicts = new Verdicts(task, place_of);
  shown("path").textContent = task.file;
  shown("looks").replaceChildren("Picture of ", ...looks.map(([number, caption]) => button(`step ${number}`, () => answer(`/look?${number}`), {title: caption, value: number})),
    button("the first that is not done", () => answer("/look?")));
  shown("pixels").textContent = kit ? "Where a picture averages several rays, the others may differ even if the one of a pixel that is explained is the same."
    : "The wanted picture comes with this pack, small.";
}

// --- The claims ---

function show_claims({held, broken, late, claims, failed, unwritten}, is_checking) {
  const told = [...held.map((claim) => ({claim, verdict: "passed"})), ...[...broken, ...late].map(({name, reason, place, is_open}) =>
    ({claim: name, verdict: is_open ? "late" : "failed", message: reason, place}))];
  const is_news = told.filter((one) => verdicts.put(one)).length > 0, is_open = is_checking && !broken.length && !late.length;
  if (!is_open && (is_news || !is_checking)) verdicts.show_first();
  verdicts.show_unwritten(unwritten);
  if (!is_checking) verdicts.show_solved();
  shown("first").classList.toggle("old", is_open); // that of the save before, until it is known
  shown("claims").textContent = (is_checking && claims ? "before this save:\n\n" : "") + claims;
  shown("claims").classList.toggle("old", is_checking);
  shown("verdict").hidden = !claims || Boolean(failed && claims.includes("does not compile")); // said above
}

function show_state({held, of, busy, seconds, failed, passed, stem, next}, is_checking) {
  const counted = is_checking ? `Checking: ${verdicts.size} of ${of}` : failed && !verdicts.size ? "The compiler found an error" : `${held.length} of ${of} claims hold`;
  const others = busy.replace(/checking the claims( and )?/, "").replace(/ and $/, "");
  const on = next ? [`. ${stem} has all its points: `, button(`go on to ${next}`, () => answer("/next"))] : [];
  shown("state").replaceChildren(counted, others && `, ${others}`, passed && `; ${passed}`, ...on);
  shown("seconds").textContent = is_checking || !verdicts.size ? "" : `Claims checked ${seconds} s after the save.`;
}

// --- The picture ---

async function put(canvas, address) {
  const image = new Image();
  image.src = address;
  await image.decode();
  Object.assign(canvas, {width: image.naturalWidth, height: image.naturalHeight});
  canvas.getContext("2d").drawImage(image, 0, 0);
}

async function show_pictures({pictures, step, stem, drawn, caption, command, task}, {pictures: before = {}, ...last}) {
  await Promise.all(PICTURES.map(async (name) => {
    const figure = shown(name).closest("figure");
    if (pictures[name] && pictures[name] !== before[name]) await put(shown(name), `/picture/${name}?${pictures[name]}`);
    figure.hidden = !pictures[name];
    figure.firstElementChild.classList.toggle("old", name !== "wanted" && !drawn);
  }));
  shown("pictures").hidden = PICTURES.every((name) => !pictures[name]);
  shown("pixel").hidden = shown("explained").hidden = !pictures.own;
  shown("whose").textContent = drawn ? "by your code" : "by your code, before this save";
  shown("caption").textContent = `wanted: ${caption}${task < step ? ` (step ${task} has no picture of its own; this is that of step ${step})` : ""}`;
  shown("command").textContent = command;
  for (const one of shown("looks").children) one.ariaPressed = one.value ? String(Number(one.value) === step) : null;
  if (drawn && !(last.drawn && last.step === step && last.stem === stem)) pixel.drawn(`${stem} ${step}`);
}

// "differs in 2 % of the pixels, most at 100,110", of the wanted picture, where a click explains that pixel.
function compared_words(compared) {
  const [, text, x, y] = compared.match(/^(.*?)(?: (\d+),(\d+))?$/);
  const place = x && button(`${x},${y}`, () => pixel.aim([x, y].map(Number), shown("wanted")), {className: "place"});
  return text ? [`the picture ${text}`, ...place ? [" ", place] : []] : [];
}

function show_drawn({step, drawn, undrawn, same, compared, says, unwritten}) {
  if (undrawn) return show_undrawn(`Step ${step}: your code draws nothing`, undrawn, {open: true});
  const words = unwritten.includes(step) ? [UNWRITTEN] : same ? [said_of_wanted(verdicts.is_broken(step))] : compared_words(compared);
  return shown("drawn").replaceChildren(...drawn ? [`Step ${step}: `, ...words, says && words.length ? "; " : "", says] : []);
}

// --- What the server tells ---

async function show(now) {
  const last = known, is_checking = now.busy.includes("checking");
  if (now.stem !== last.stem) await begin(now);
  else if (now.save !== last.save) verdicts = new Verdicts(verdicts.task, place_of);
  known = now;
  document.title = `${verdicts.task.title}, step ${now.task}: raykit`;
  show_claims(now, is_checking);
  show_said(now.failed || now.warned, !now.failed, place_of);
  show_state(now, is_checking);
  await show_pictures(now, now.stem === last.stem ? last : {});
  show_drawn(now);
}

let shown_before = Promise.resolve();
const events = new EventSource("/events");
events.onmessage = ({data}) => {
  shown("shared").textContent = "";
  shown_before = shown_before.then(() => show(JSON.parse(data))).catch((error) => { shown("shared").textContent = `It does not go on: ${error.message}`; });
};
events.onerror = () => { shown("shared").textContent = "The server does not answer: start it again by make."; };
