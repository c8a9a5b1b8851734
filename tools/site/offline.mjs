// Writes the service worker of a site, with the files that it keeps for a visit without a network.
//   node offline.mjs SITE service_worker.js NEEDED...
// NEEDED: files and folders of the site.
import crypto from "node:crypto";
import fs from "node:fs";
import path from "node:path";

const [site, template, ...wanted] = process.argv.slice(2);

function filesIn(name) {
  const place = path.join(site, name);
  if (!fs.statSync(place).isDirectory()) return [name];
  return fs.readdirSync(place).sort().flatMap((child) => filesIn(`${name}/${child}`));
}

const VERSION = "version.json", ITSELF = [VERSION, path.basename(template)];
const all = fs.readdirSync(site).sort().flatMap(filesIn).filter((name) => !ITSELF.includes(name));
const needed = wanted.flatMap(filesIn), hash = crypto.createHash("sha256");
for (const name of all) hash.update(name).update(fs.readFileSync(path.join(site, name)));
const version = hash.digest("hex").slice(0, 16);
fs.writeFileSync(path.join(site, VERSION), JSON.stringify({version}));
const text = fs.readFileSync(template, "utf-8").replace("\"{version}\"", JSON.stringify(version))
  .replace("\"{needed}\"", JSON.stringify([...needed, VERSION]));
fs.writeFileSync(path.join(site, path.basename(template)), text);
