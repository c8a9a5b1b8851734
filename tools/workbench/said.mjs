// What the compiler says of a unit, and what a driver says of its picture.
import {made, shown} from "./elements.mjs";
import {show_box} from "./verdicts.mjs";

const FINDING = /^(?:.*\/)?([\w.]+\.[ch]):(\d+):\d+: (?:fatal )?(error|warning|note): (.*)$/gm;
const UNCLOSED = "expected '}'"; // a brace that is missing has other errors before it
const OPTION = / \[-W[^\]]*\]$/; // that has asked for a warning

// The linker names a function that is missing once for each call.
function without_repetitions(said) {
  const missing = [...new Set([...said.matchAll(/undefined symbol: (\w+)/g)].map(([, name]) => name))];
  return missing.length ? `Your file does not define ${missing.join(", ")}.` : said;
}

const line_of = ({file, line, severity, message}, place_of) => [place_of(`${file}:${line}`), `: ${severity}: ${message}`];

// Errors and warnings, each with the notes that follow it.
function items_of(findings, place_of) {
  const items = [];
  for (const finding of findings) {
    if (finding.severity !== "note" || !items.length) items.push(made("li", {}, ...line_of(finding, place_of)));
    else items[items.length - 1].append(made("div", {}, ...line_of(finding, place_of)));
  }
  return items;
}

// Returns what is found: {file, line, severity, message}. If the unit is not built, the first error is what is to be
// worked on; place_of is that of Verdicts.
export function show_said(words, is_built, place_of) {
  const said = without_repetitions(words);
  const findings = [...said.matchAll(FINDING)].map(([, file, line, severity, message]) =>
    ({file, line: Number(line), severity, message: message.replace(OPTION, "")}));
  shown("warned").textContent = is_built ? "The compiler warns:" : "The compiler says:";
  shown("findings").replaceChildren(...is_built ? items_of(findings, place_of) : []);
  shown("said").textContent = said;
  shown("said").parentElement.open = !is_built;
  shown("compiler").classList.remove("old");
  shown("compiler").hidden = !said || (!is_built && findings.length === 0); // the box has all of it
  if (!is_built) {
    const errors = findings.filter(({severity}) => severity === "error"), first = errors.find(({message}) => message === UNCLOSED) || errors[0];
    const rest = findings.slice(findings.indexOf(first) + 1), {file, line, message} = first || {message: said.trim()};
    const others = rest.findIndex(({severity}) => severity !== "note"), notes = rest.slice(0, others < 0 ? rest.length : others);
    show_box("The compiler found an error", message, file ? place_of(`${file}:${line}`) : "", ...notes.map((note) => made("p", {}, ...line_of(note, place_of))));
  }
  return findings;
}

// What to say of a picture whose step is left to write.
export const UNWRITTEN = "not written yet; this is what your code draws without it";

// What to say of a picture that is the wanted one.
export const said_of_wanted = (is_broken) => is_broken ? "the wanted picture, but some claims up to this step fail, which it does not show" : "the wanted picture";

// Why there is no picture, with the driver's words to unfold; more: what follows them.
export function show_undrawn(reason, words, {open, more = []}) {
  const detail = made("details", {open}, made("summary", {textContent: "What the program says"}), words, ...more);
  shown("drawn").replaceChildren(`${reason}.`, ...(words ? [detail] : []));
}
