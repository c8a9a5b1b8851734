// What the claims say of one text of a unit: each beside the step that it belongs to, and the one to work on in the place
// that is seen first.
import {made, shown} from "./elements.mjs";
import {sentence} from "./task.mjs";

const PRINTED = 2000; // characters that are shown of what a claim prints

export const printed_in = (text) => made("pre", {className: "printed", tabIndex: 0,
  textContent: text.length > PRINTED ? `${text.slice(0, PRINTED)}\n(and more, not shown)` : text});

// place: an element, or a text, which may be "".
export function show_box(title, message, place, ...more) {
  shown("first").hidden = false;
  shown("first").classList.remove("old");
  shown("first").replaceChildren(made("strong", {textContent: title}), made("pre", {textContent: message}),
    ...(place ? [made("p", {}, "in ", place)] : []), ...more);
}

export class Verdicts {
  #told = new Map();

  // Those of the text before are old from now on. place_of(place) returns what is shown of a place in a file.
  constructor(task, place_of) {
    Object.assign(this, {task, place_of});
    for (const item of document.querySelectorAll(".claims li")) item.classList.add("old");
    shown("steps").classList.remove("old");
  }

  // Of how many claims, in the order of work, and how many of them hold.
  get names() { return [...this.task.steps.flatMap((step) => step.claims), ...this.task.kept]; }
  get size() { return this.#told.size; }
  get passed() { return [...this.#told.values()].filter(({verdict}) => verdict === "passed").length; }

  // The first claim in the order of work that does not hold, once all before it hold; or undefined.
  get first() {
    const told = this.names.map((name) => this.#told.get(name));
    return told[told.findIndex((one) => one?.verdict !== "passed")];
  }

  holds(name) { return this.#told.get(name)?.verdict === "passed"; }

  // Whether one of a step, or of one before it, is known not to hold.
  is_broken(number) {
    return this.task.steps.some((step) => step.number <= number && step.claims.some((name) => ["failed", "fault"].includes(this.#told.get(name)?.verdict)));
  }

  // {claim, verdict, message, place, printed}; verdict: "passed", "failed", "fault", or "late" if it may yet pass. Returns
  // whether this is news.
  put(told) {
    const {claim, verdict, message, place} = told, item = shown(claim), words = sentence(claim);
    if (!item || JSON.stringify(this.#told.get(claim)) === JSON.stringify(told)) return false; // what is unfolded stays so
    this.#told.set(claim, told);
    item.dataset.verdict = verdict;
    item.classList.remove("old");
    const said = verdict === "passed" ? [] : [made("small", {}, message, ...(place ? [" (", this.place_of(place), ")"] : []))];
    const more = [...said, ...this.#more(told)], open = Boolean(item.firstElementChild?.open || (said.length && item.closest(".current")));
    item.replaceChildren(more.length ? made("details", {open}, made("summary", {textContent: words}), ...more) : words);
    return true;
  }

  // Of a claim that does not hold its function, as the suite has it; and what was printed.
  #more({claim, verdict, printed}) {
    const [begin, end] = this.task.code[claim], text = this.task.suite.split("\n").slice(begin - 1, end).join("\n");
    const code = [made("details", {}, made("summary", {textContent: "The claim's code"}), made("pre", {textContent: text, tabIndex: 0}))];
    return [...(verdict === "passed" ? [] : code), ...(printed ? [made("p", {textContent: "Printed by your code:"}), printed_in(printed)] : [])];
  }

  // The first claim in the order of work that does not hold is the one to work on. Returns its verdict and its step's
  // number, or undefined.
  show_first() {
    const first = this.names.map((name) => this.#told.get(name)).find((told) => told && told.verdict !== "passed");
    shown("first").hidden = !first;
    const step = first && this.task.steps.find(({claims}) => claims.includes(first.claim))?.number;
    for (const item of shown("steps").children) {
      const is_current = item.id === `step-${step}`;
      if (is_current && !item.classList.contains("current")) for (const reason of item.querySelectorAll("[data-verdict]:not([data-verdict=passed]) > details")) reason.open = true;
      item.classList.toggle("current", is_current);
    }
    if (!first) return undefined;
    const {claim, message, place} = first;
    show_box(`${step ? `Step ${step}: ` : ""}${sentence(claim)}`, message, place && this.place_of(place), ...this.#more(first));
    return {...first, step};
  }

  // Says of a step that it is left to write; numbers: those that are.
  show_unwritten(numbers) {
    for (const {number, points} of this.task.steps) shown(`step-${number}`).querySelector(".points").textContent = `${points} points${numbers.includes(number) ? ", not written yet" : ""}`;
  }

  // What the unit printed, in all claims, in the order of work.
  show_printed() {
    const all = this.names.map((name) => this.#told.get(name)).filter((told) => told?.printed);
    const lines = all.reduce((sum, {printed}) => sum + printed.trimEnd().split("\n").length, 0);
    shown("printed").hidden = !lines;
    shown("printed").replaceChildren(made("summary", {textContent: `Your code printed ${lines} line${lines === 1 ? "" : "s"}`}),
      ...all.flatMap(({claim, printed}) => [made("p", {textContent: `${sentence(claim)}:`}), printed_in(printed)]));
  }

  show_solved() {
    for (const {number, claims} of this.task.steps) shown(`step-${number}`).classList.toggle("solved", claims.every((name) => this.holds(name)));
  }
}
