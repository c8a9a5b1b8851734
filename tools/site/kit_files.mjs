// Reads in Node.js what `make site` has made, as the checker takes it.
import fs from "node:fs";
import path from "node:path";
import {pathToFileURL} from "node:url";
import {Worker} from "node:worker_threads";
import {Toolchain} from "./toolchain.mjs";

export async function load_toolchain(site) {
  return Toolchain.load(pathToFileURL(path.resolve(site, "clang", "bundle.mjs")).href);
}

export function read_kit(site) {
  const read = (name) => fs.readFileSync(path.join(site, name));
  const claims = JSON.parse(read("suites.json"));
  const suites = Object.fromEntries(Object.keys(claims).map((stem) => [stem,
    {claims: claims[stem], object: new Uint8Array(read(`suites/${stem}.o`))}]));
  return {archive: new Uint8Array(read("kit.a")), headers: JSON.parse(read("headers.json")), suites};
}

// Returns what Drawer takes, and the pictures of the steps by stem (looks.json).
export function read_drivers(site) {
  const read = (name) => new Uint8Array(fs.readFileSync(path.join(site, name))), looks = JSON.parse(fs.readFileSync(path.join(site, "looks.json")));
  const drivers = Object.fromEntries(Object.keys(looks).map((stem) => [stem, read(`drivers/${stem}.o`)]));
  return {archives: Object.fromEntries(["drivers.a", "kit.a"].map((name) => [name, read(name)])), drivers, looks};
}

// A worker with the interface of a Web Worker.
export function start_worker(name = "claims_worker.mjs") {
  const worker = new Worker(new URL(name, import.meta.url));
  worker.on("message", (data) => worker.onmessage({data}));
  worker.on("error", (error) => { throw error; });
  return worker;
}
