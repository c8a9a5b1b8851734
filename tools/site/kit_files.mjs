// Reads in Node.js what `make site` has made, as the checker takes it.
import fs from "node:fs";
import path from "node:path";
import {pathToFileURL} from "node:url";
import {Worker} from "node:worker_threads";
import {gunzipSync, gzipSync} from "node:zlib";
import {Toolchain} from "./toolchain.mjs";

export async function load_toolchain(site) {
  return Toolchain.load(pathToFileURL(path.resolve(site, "clang", "bundle.mjs")).href);
}

const json = (site, name) => JSON.parse(fs.readFileSync(path.join(site, name), "utf8"));
const bytes = (site, name) => new Uint8Array(gunzipSync(fs.readFileSync(path.join(site, `${name}.gz`))));

// Writes bytes as a file of the site, packed.
export function write_packed(site, name, whole) { fs.writeFileSync(path.join(site, `${name}.gz`), gzipSync(whole)); }

export function read_kit(site) {
  const claims = json(site, "suites.json");
  const suites = Object.fromEntries(Object.keys(claims).map((stem) => [stem, {claims: claims[stem], object: bytes(site, `suites/${stem}.o`)}]));
  return {archive: bytes(site, "kit.a"), headers: JSON.parse(new TextDecoder().decode(bytes(site, "headers.json"))), suites};
}

// Returns what Drawer takes, and the pictures of the steps by stem (looks.json).
export function read_drivers(site) {
  const looks = json(site, "looks.json"), drivers = Object.fromEntries(Object.keys(looks).map((stem) => [stem, bytes(site, `drivers/${stem}.o`)]));
  return {archives: Object.fromEntries(["drivers.a", "kit.a"].map((name) => [name, bytes(site, name)])), drivers, looks};
}

// Returns open.json, and the objects of its starters.
export function read_open(site) {
  const open = json(site, "open.json");
  return {open, starters: Object.fromEntries(open.stems.map((stem) => [stem, bytes(site, `open/${stem}.o`)]))};
}

// Returns the texts of a folder's units that are open and asked for, by stem.
export function read_units(folder, {starters}) {
  const files = Object.keys(starters).map((stem) => [stem, path.join(folder || "", `${stem}.c`)]);
  return Object.fromEntries(files.filter(([, file]) => folder && fs.existsSync(file)).map(([stem, file]) => [stem, fs.readFileSync(file, "utf8")]));
}

// A worker with the interface of a Web Worker.
export function start_worker(name = "claims_worker.mjs") {
  const worker = new Worker(new URL(name, import.meta.url));
  worker.on("message", (data) => worker.onmessage({data}));
  worker.on("error", (error) => { throw error; });
  return worker;
}
