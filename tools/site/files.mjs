// A student's files: one unit saved, or all as a workbook, as `make workbook DIR=mine` writes it; and opened again.
import {zipped} from "./archives.mjs";
import {asked, made} from "./elements.mjs";
import {units_of} from "./units.mjs";

export function download(name, contents, type) {
  const href = URL.createObjectURL(new Blob([contents], {type}));
  made("a", {href, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(href), 60000); // the browser may still be asking where to
}

// workbook: {folder, files: {NAME: text}}, with starters; text_of(stem) is the student's own or undefined.
export function save_all({folder, files}, stems, text_of) {
  const own = Object.fromEntries(stems.map((stem) => [`${stem}.c`, text_of(stem) ?? files[`${stem}.c`]]));
  const inside = Object.entries({...files, ...own}).map(([name, text]) => [`${folder}/${name}`, text]);
  download("workbook.zip", zipped(Object.fromEntries(inside)), "application/zip");
}

const list = (title, items) => items.length ? [made("p", {textContent: title}), made("ul", {}, ...items.map((item) => made("li", {}, item)))] : [];

// Asks before a student's own text is replaced, and before a single file goes elsewhere than into the open assignment.
// Returns the units to take.
async function agreed(units, {stem, title_of, is_own}) {
  const lost = units.filter((unit) => is_own(unit.stem)), elsewhere = units.filter((unit) => !unit.is_packed && unit.stem !== stem && !lost.includes(unit));
  const rest = units.filter((unit) => !lost.includes(unit) && !elsewhere.includes(unit));
  if (!lost.length && !elsewhere.length) return units;
  const named = (some) => some.map((unit) => `${unit.path}: ${title_of(unit.stem)}`);
  const answer = await asked(units.length > 1 ? "Open these files?" : "Open this file?", [
    ...list(`${lost.length > 1 ? "They take" : "It takes"} the place of your own text, which undo (Ctrl+Z) brings back:`, named(lost)),
    ...list(elsewhere.length > 1 ? "They belong to other assignments, and go there:" : "It belongs to another assignment, and goes there:", named(elsewhere))],
  {all: lost.length ? "Replace my text" : "Put them there", ...(rest.length ? {rest: "Open only the others"} : {}), "": "Cancel"});
  return answer === "all" ? units : answer === "rest" ? rest : [];
}

// list of File; page: {stem, stems, title_of(stem), text_of(stem), starter_of(stem), put(stem, text)}. Puts each unit
// into its assignment, and says what was taken unless the reader sees it.
export async function open_files(files, page) {
  const read = await Promise.all(files.map(async (file) => ({name: file.name, bytes: new Uint8Array(await file.arrayBuffer())})));
  const {units, refused} = units_of(read, page.stems), is_own = (stem) => page.text_of(stem) !== page.starter_of(stem);
  const same = units.filter(({stem, text}) => text === page.text_of(stem));
  const starters = units.filter((unit) => !same.includes(unit) && unit.is_packed && unit.text === page.starter_of(unit.stem));
  const others = units.filter((unit) => !same.includes(unit) && !starters.includes(unit));
  const taken = await agreed(others, {...page, is_own});
  for (const {stem, text} of taken) page.put(stem, text);
  if (taken.length === 1 && taken[0].stem === page.stem && units.length === 1 && !refused.length) return;
  const link = ({stem}) => made("a", {href: `workbench.html?${stem}`, textContent: page.title_of(stem)});
  const titles = (some) => page.stems.filter((stem) => some.some((unit) => unit.stem === stem)).map(page.title_of);
  await asked(taken.length ? "Opened" : "Nothing was changed", [
    ...list("Taken, each into its assignment:", taken.map(link)),
    ...list("Not taken, as you said:", titles(others.filter((unit) => !taken.includes(unit)))),
    ...list("The same as yours:", titles(same)),
    ...list("Starters, left out:", titles(starters)),
    ...list("Not taken:", refused.length > 8 ? [...refused.slice(0, 8), `and ${refused.length - 8} more`] : refused)], {"": "Close"});
}
