// Copies the modules of npm's packages that a module of the page imports, and all that these depend on, to a folder, and
// writes a page with the import map that says where each name is, as browsers find modules by addresses only.
//   node modules.mjs NODE_MODULES OUT PAGE MODULE...
// PAGE, with a line <!-- modules -->, is written to OUT; modules are copied to OUT/modules.
import fs from "node:fs";
import path from "node:path";

const IMPORTED = /^import .*from "([^."][^"]*)";$/gm; // not by "./"

const [packages, out, page, ...modules] = process.argv.slice(2);
const imports = {};
fs.mkdirSync(path.join(out, "modules"), {recursive: true});

function add(name) {
  if (name in imports) return;
  const folder = path.join(packages, name);
  if (!fs.existsSync(folder)) {
    console.error(`modules.mjs: npm's package ${name} is missing: run ./bootstrap --site`);
    process.exit(1);
  }
  const {module, main = "index.js", dependencies = {}} = JSON.parse(fs.readFileSync(path.join(folder, "package.json"), "utf-8"));
  const file = `modules/${name.replace("@", "").replaceAll("/", "-")}.js`;
  imports[name] = `./${file}`;
  fs.copyFileSync(path.join(folder, module || main), path.join(out, file));
  Object.keys(dependencies).forEach(add);
}

for (const file of modules) for (const [, name] of fs.readFileSync(file, "utf-8").matchAll(IMPORTED)) add(name);
const map = `<script type="importmap">${JSON.stringify({imports})}</script>`;
fs.writeFileSync(path.join(out, path.basename(page)), fs.readFileSync(page, "utf-8").replace("<!-- modules -->", () => map));
