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

const needed = wanted.flatMap(filesIn), hash = crypto.createHash("sha256");
for (const name of needed) hash.update(name).update(fs.readFileSync(path.join(site, name)));
const text = fs.readFileSync(template, "utf-8").replace("\"{version}\"", JSON.stringify(hash.digest("hex").slice(0, 16)))
  .replace("\"{needed}\"", JSON.stringify(needed));
fs.writeFileSync(path.join(site, path.basename(template)), text);
