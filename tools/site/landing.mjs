// What of the course is kept in this browser, beside the links to its assignments.
import {made} from "./elements.mjs";
import {kept, last_kept} from "./kept.mjs";

function words_of({passed, claims}) {
  if (!claims) return "begun";
  return passed === claims ? `✓ all ${claims} claims hold` : `${passed} of ${claims} claims hold`;
}

const stem_of = (link) => new URL(link.href).search.slice(1);

// The first way leads on where something has been begun: to what was worked on last or, if that is solved, to the next.
function show_continue(links) {
  const at = links.findIndex((link) => stem_of(link) === last_kept()), begun = links[at] && kept(stem_of(links[at]));
  if (!begun) return;
  const is_solved = begun.claims && begun.passed === begun.claims, to = (is_solved && links[at + 1]) || links[at], work = kept(stem_of(to));
  const title = to.querySelector("b, strong")?.textContent || to.firstChild.textContent;
  Object.assign(document.querySelector(".ways .first"), {href: to.href, textContent: `Continue: ${title.trim()}${work ? `, ${words_of(work)}` : ""}`});
}

function show_progress() {
  const links = [...document.querySelectorAll(".course a")];
  for (const link of links) {
    const work = kept(stem_of(link));
    link.querySelector(".progress")?.remove();
    if (work) link.append(made("span", {className: "progress", textContent: words_of(work)}));
  }
  show_continue(links);
}

show_progress();
addEventListener("storage", show_progress);
addEventListener("pageshow", show_progress); // when the reader goes back to it
