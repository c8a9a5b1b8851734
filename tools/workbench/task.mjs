// The task of an assignment: its goal, and its steps with what is given, hints, links into the book, and their claims.
import {made, shown} from "./elements.mjs";

// Names of claims are sentences in C's spelling.
export const sentence = (name) => name.replaceAll("_", " ");

const claim_of = (name) => made("li", {id: name, textContent: sentence(name)});

async function show_header(header, name, header_text) {
  const text = await header_text(header);
  const at = name ? text.search(new RegExp(`\\b${name}\\(`)) : -1, mark = made("mark", {textContent: name});
  shown("header_name").textContent = header;
  shown("header_text").replaceChildren(...at < 0 ? [text] : [text.slice(0, at), mark, text.slice(at + name.length)]);
  shown("header").showModal();
  if (at >= 0) mark.scrollIntoView({block: "center"});
}

// A button for a place in the suite, "tests/test_normals.c:14", that shows the line; for a place elsewhere its text.
export function place_in_suite(task, place) {
  const [, name, line] = place.match(/([^/]*):(\d+)$/) || [];
  if (name !== `test_${task.stem}.c`) return place;
  return made("button", {className: "place", textContent: place, onclick() {
    const lines = task.suite.split("\n"), mark = made("mark", {textContent: `${lines[line - 1]}\n`}), before = lines.slice(0, line - 1);
    shown("header_name").textContent = `${name}, line ${line}`;
    shown("header_text").replaceChildren(before.map((text) => `${text}\n`).join(""), mark, lines.slice(line).join("\n"));
    shown("header").showModal();
    mark.scrollIntoView({block: "center"});
  }});
}

// The line on which a function's definition begins, or 0.
function line_of_function(text, name) {
  const found = /^\w+$/.test(name) && text.match(new RegExp(`^(?=[a-z])[^;{}()\\n]*\\b${name}\\([^;{}]*\\)\\s*\\{`, "m"));
  return found ? text.slice(0, found.index).split("\n").length : 0;
}

// Makes the task's names of functions that the starter defines buttons that show them. text() is the unit's, show(line)
// leads there.
export function link_functions(starter, text, show) {
  for (const code of shown("steps").querySelectorAll("code:not(.prototype)")) {
    const {textContent} = code, name = textContent.replace(/\(\)$/, "");
    if (line_of_function(starter, name)) code.replaceWith(made("button", {className: "place code", textContent, onclick: () => show(line_of_function(text(), name) || 1)}));
  }
}

// task: what task_page.py says of an assignment. element(tag, text, more) makes an element of one of its texts;
// header_text(name) resolves to a header of the kit.
export function show_task(task, {element, header_text}) {
  const hint = ({title, text}) => made("details", {}, element("summary", `Hint: ${title}`), element("div", text));

  // What is given, with its prototypes, and buttons that show its headers.
  function given_of({text, headers, prototypes}) {
    const name = prototypes.length ? prototypes[0].match(/(\w+)\(/)[1] : "";
    const buttons = headers.map((header) => made("button", {className: "place", textContent: header, onclick: () => show_header(header, name, header_text)}));
    return made("li", {}, element("span", text), ...prototypes.map((prototype) => made("code", {className: "prototype", textContent: prototype})),
      ...buttons.flatMap((button) => [" ", button]));
  }

  function step_of({number, write, given, hints, claims, points, sections}) {
    const reading = sections.map(({href, title}) => element("a", title, {href: `${task.book}${href}`, target: "_blank", rel: "noopener"}));
    return made("li", {id: `step-${number}`},
      made("h2", {}, `Step ${number} `, made("span", {className: "points", textContent: `${points} points`})),
      element("div", write), made("details", {}, made("summary", {textContent: "Given"}), made("ul", {}, ...given.map(given_of))),
      ...hints.map(hint), ...(task.book ? [made("p", {}, "Read: ", ...reading.flatMap((link, i) => i ? [", ", link] : [link]))] : []),
      made("ul", {className: "claims"}, ...claims.map(claim_of)));
  }

  document.title = `${task.title}: raykit`;
  shown("title").textContent = task.title[0].toUpperCase() + task.title.slice(1);
  shown("goal").replaceChildren(element("div", task.goal), made("p", {textContent: `Time: ${task.hours}`}));
  const others = made("li", {}, made("h2", {textContent: "What holds from the beginning"}), made("ul", {className: "claims"}, ...task.kept.map(claim_of)));
  shown("steps").replaceChildren(...task.steps.map(step_of), ...(task.kept.length ? [others] : []));
  shown("header_close").onclick = () => shown("header").close();
}
