// Zips, and what they hold: a zip, or a tar as a pack for students is, compressed by gzip or not.
import {gunzipSync, unzipSync, zipSync} from "fflate";

const BLOCK = 512; // bytes of a tar's header, and to which its files are filled up

// files: {PATH: text}. Returns a zip's bytes.
export function zipped(files) {
  const bytes = Object.entries(files).map(([path, text]) => [path, new TextEncoder().encode(text)]);
  return zipSync(Object.fromEntries(bytes));
}

const begins = (bytes, magic) => magic.every((byte, at) => bytes[at] === byte);
const is_zip = (bytes) => begins(bytes, [0x50, 0x4b]);
const is_gzip = (bytes) => begins(bytes, [0x1f, 0x8b]);
const is_tar = (bytes) => bytes.length >= BLOCK && new TextDecoder().decode(bytes.subarray(257, 262)) === "ustar";

export const is_archive = (bytes) => is_zip(bytes) || is_gzip(bytes) || is_tar(bytes);

// The plain files of a tar that are wanted; a name that is too long for a header stands before it, in an entry of its own.
function untarred(bytes, wanted) {
  const files = {}, text = (from, size) => new TextDecoder().decode(bytes.subarray(from, from + size)).replace(/\0.*/s, "");
  let long_name = "";
  for (let at = 0; at + BLOCK <= bytes.length && bytes[at] !== 0;) {
    const size = parseInt(text(at + 124, 12), 8), kind = text(at + 156, 1) || "0", prefix = text(at + 345, 155), contents = at + BLOCK;
    if (!(size >= 0) || contents + size > bytes.length) throw new Error("it ends too early");
    const path = long_name || (prefix ? `${prefix}/` : "") + text(at, 100);
    if (kind === "0" && wanted(path)) files[path] = bytes.slice(contents, contents + size);
    if (kind === "L") long_name = text(contents, size);
    else long_name = kind === "x" ? text(contents, size).match(/^\d+ path=(.*)$/m)?.[1] || "" : "";
    at = contents + Math.ceil(size / BLOCK) * BLOCK;
  }
  return files;
}

// Returns {PATH: bytes} of the files in an archive whose paths are wanted. Throws an Error if it cannot be read.
export function unpacked(bytes, wanted) {
  if (is_zip(bytes)) return unzipSync(bytes, {filter: ({name}) => wanted(name)});
  return untarred(is_gzip(bytes) ? gunzipSync(bytes) : bytes, wanted);
}
