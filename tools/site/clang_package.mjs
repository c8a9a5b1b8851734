// Copies what C needs of the package @yowasp/clang: node clang_package.mjs PACKAGE OUT. Its headers and libraries are
// 30 MB, of which clang reads 3; each run of a program looks through all of them.
import fs from "node:fs";
import path from "node:path";

const BLOCK = 512;
const KEPT = [/^include\/wasm32-wasip1\//, /^include\/(__)?std[a-z_]*\.h$/, /^include\/(float|limits|inttypes|iso646|tgmath|__float_\w+|wasm_simd128)\.h$/,
  /^lib\/wasm32-wasip1\/(crt1-command\.o|libc\.a)$/, /^lib\/wasm32-unknown-wasip1\/libclang_rt\.builtins\.a$/];
const LEFT_OUT = /^include\/wasm32-wasip1\/c\+\+\//;

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

const [from, out] = process.argv.slice(2);
fs.mkdirSync(out, {recursive: true});
for (const name of fs.readdirSync(path.join(from, "gen")))
  if (name !== "llvm-resources.tar")
    fs.copyFileSync(path.join(from, "gen", name), path.join(out, name.replace(/^bundle\.js$/, "bundle.mjs"))); // a module by its name
fs.writeFileSync(path.join(out, "llvm-resources.tar"), kept(fs.readFileSync(path.join(from, "gen", "llvm-resources.tar"))));
