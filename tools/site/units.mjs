// Which files are units of students, by their names, alone and in archives.
import {is_archive, unpacked} from "./archives.mjs";

const LARGEST = 1 << 20; // bytes, as for make grade
const PACK = /(^|\/)workbook\/[^/]*$/; // the student's own folder in a pack

const name_of = (path) => path.replace(/.*\//, "");

// A browser numbers a file that is downloaded again, as in normals (1).c.
function stem_of(path, stems) {
  return stems.find((stem) => new RegExp(`^${stem}(-\\d+| ?\\(\\d+\\))?\\.c$`).test(name_of(path)));
}

// Returns {text}, or {why} it is no unit's text.
function text_of(bytes) {
  if (is_archive(bytes)) return {why: "is an archive under the name of a C file: name it .zip or .tar.gz"};
  if (bytes.length > LARGEST) return {why: "is larger than 1 MB"};
  try {
    return {text: new TextDecoder("utf-8", {fatal: true}).decode(bytes).replace(/\r\n?/g, "\n")};
  } catch {
    return {why: "is not text in UTF-8: save it anew as UTF-8"};
  }
}

// The C files of an archive, {PATH: bytes}; of a pack those in its workbook, since the others are the kit's.
function sources_in(bytes) {
  const is_source = (path) => /\.[ch]$/.test(path) && !path.split("/").some((part) => part.startsWith(".") || part === "__MACOSX");
  const files = Object.entries(unpacked(bytes, is_source)), own = files.filter(([path]) => PACK.test(path));
  return own.length ? own : files;
}

// files: [{name, bytes}]. Returns {units: [{stem, path, text, is_packed}], refused: ["what, why"]}.
export function units_of(files, stems) {
  const found = [], refused = [];
  for (const {name, bytes} of files) {
    if (!is_archive(bytes)) {
      if (/\.(zip|tar|gz|tgz)$/i.test(name)) refused.push(`${name} is damaged, or no archive: save or download it again`);
      else found.push({path: name, bytes, is_packed: false});
      continue;
    }
    try {
      const sources = sources_in(bytes);
      found.push(...sources.map(([path, contents]) => ({path, bytes: contents, is_packed: true})));
      if (!sources.length) refused.push(`${name} holds no C file`);
    } catch (error) {
      refused.push(`${name} cannot be read (${error.message}): unpack it, and open the C files in it`);
    }
  }
  const units = [];
  for (const {path, bytes, is_packed} of found) {
    const stem = stem_of(path, stems), same = found.filter((other) => stem && stem_of(other.path, stems) === stem);
    const {text, why} = stem ? text_of(bytes) : {why: "is not named after an assignment, like normals.c"};
    if (why) refused.push(`${path} ${why}`);
    else if (same.length > 1) refused.push(`${path} is one of ${same.length} for ${stem}: open the right one alone`);
    else units.push({stem, path, text, is_packed});
  }
  return {units, refused};
}
