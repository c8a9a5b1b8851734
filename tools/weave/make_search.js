// The search of the book and the report: MiniSearch, and the index that it makes of a page's texts (search.lua).
//   node make_search.js MINISEARCH_FOLDER <texts >script
// The texts are JSON: {sections: [[page, name, title, chapter]], entries: [{id, at, name, title, kind, text}]}, where `at` is
// the entry's section. The script sets `raykitSections`, and `raykitFind`, which returns the entries that some words lead to.
"use strict";
const fs = require("fs");
const path = require("path");

const [folder] = process.argv.slice(2);
const MiniSearch = require(path.join(folder, "dist/cjs/index.cjs"));
const read = (file) => fs.readFileSync(path.join(folder, file), "utf8");

const options = {fields: ["title", "text"], storeFields: ["at", "name", "title", "kind", "text"]};
const {sections, entries} = JSON.parse(fs.readFileSync(0, "utf8"));
const search = new MiniSearch(options);
search.addAll(entries);

// Chapters, then sections, come before functions and tests of which a word is a part. Words may be beginnings, or have a wrong letter, from six letters on two, as two that are swapped. Places with all of them, if there are any.
function find(search, words) {
  const options = {prefix: true, fuzzy: (word) => word.length > 5 ? 2 : word.length > 3 ? 1 : 0, boost: {title: 3},
    boostDocument: (id, term, {kind}) => ({chapter: 4, section: 2})[kind] || 1};
  const found = search.search(words, {...options, combineWith: "AND"});
  return found.length ? found : search.search(words, options);
}

// It may stand within a page.
const json = (value) => JSON.stringify(value).replace(/</g, "\\u003c");
process.stdout.write(`/* MiniSearch, https://lucaong.github.io/minisearch\n${read("LICENSE.txt")}*/
${read("dist/umd/index.js").replace(/\/\/# sourceMappingURL.*\n?/, "").replace(/<\/script/g, "<\\/script")}
window.raykitSections = ${json(sections)};
{
  const search = MiniSearch.loadJS(${json(search)}, ${json(options)});
  window.raykitFind = (words) => (${find})(search, words);
}
`);
