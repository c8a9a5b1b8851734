// Copies what C needs of the package @yowasp/clang, packed: node clang_package.mjs PACKAGE OUT. Its headers and libraries
// are 30 MB, of which clang reads 3; each run of a program looks through all of them.
import fs from "node:fs";
import path from "node:path";
import {gzipSync} from "node:zlib";

const BLOCK = 512;
const KEPT = [/^include\/wasm32-wasip1\//, /^include\/(__)?std[a-z_]*\.h$/, /^include\/(float|limits|inttypes|iso646|tgmath|__float_\w+|wasm_simd128)\.h$/,
  /^lib\/wasm32-wasip1\/(crt1-command\.o|libc\.a|libc-printscan-long-double\.a)$/, /^lib\/wasm32-unknown-wasip1\/libclang_rt\.builtins\.a$/];
const LEFT_OUT = /^include\/wasm32-wasip1\/c\+\+\//;
const RESOURCES = "llvm-resources.tar";

// Returns the tar file with the files that are kept.
function kept(tar) {
  const parts = [];
  for (let at = 0; at + BLOCK <= tar.length && tar[at] !== 0;) {
    const text = (from, size) => tar.toString("latin1", at + from, at + from + size).replace(/\0.*/s, "");
    const name = text(0, 100), size = parseInt(text(124, 12), 8) || 0, end = at + BLOCK + Math.ceil(size / BLOCK) * BLOCK;
    const isFolder = text(156, 1) === "5";
    const isKept = KEPT.some((pattern) => pattern.test(name)) && !LEFT_OUT.test(name);
    if (isFolder ? !name.includes("c++") : isKept) parts.push(tar.subarray(at, end));
    at = end;
  }
  return Buffer.concat([...parts, Buffer.alloc(2 * BLOCK)]);
}

// Returns the package's module as one that fetches packed files, which are so many bytes.
function fetching_packed(text, count, bytes) {
  const wanted = /await fetch3\((new URL\("\.\/llvm[\w.-]*)", import\.meta\.url\)\)/g, size = /^var totalSize = \d+;$/m;
  if ([...text.matchAll(wanted)].length !== count || !size.test(text)) {
    console.error("site: this version of @yowasp/clang fetches its files in another way: correct tools/site/clang_package.mjs");
    process.exit(1);
  }
  return 'import {unpacked} from "./packed.mjs";\n' +
    text.replace(wanted, 'await fetch3($1.gz", import.meta.url)).then(unpacked)').replace(size, `var totalSize = ${bytes};`);
}

const [from, out] = process.argv.slice(2), gen = path.join(from, "gen");
fs.mkdirSync(out, {recursive: true});
let bytes = 0;
const fetched = fs.readdirSync(gen).filter((name) => /\.(wasm|tar)$/.test(name));
for (const name of fetched) {
  const whole = fs.readFileSync(path.join(gen, name)), packed = gzipSync(name === RESOURCES ? kept(whole) : whole);
  bytes += packed.length;
  fs.writeFileSync(path.join(out, `${name}.gz`), packed);
}
fs.copyFileSync(new URL("packed.mjs", import.meta.url), path.join(out, "packed.mjs"));
fs.writeFileSync(path.join(out, "bundle.mjs"), fetching_packed(fs.readFileSync(path.join(gen, "bundle.js"), "utf8"), fetched.length, bytes));
