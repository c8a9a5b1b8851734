// The pages that a git host shows: README.md is short, and their links lead somewhere. Speaks TAP, for make
// check-readme. Arguments: the source folder, pandoc and Chromium ("" if missing).
"use strict";

const {execFileSync} = require("child_process");
const fs = require("fs");
const os = require("os");
const path = require("path");
const {Browser} = require("./browser.js");

if (process.argv.includes("--list")) process.exit(0); // the test driver asks for names of tests

const [source, pandoc, chromium] = process.argv.slice(2);
const SCREENS = 4, HEIGHT = 900; // of a screen, in pixels
// As git hosts show a README: the breadth of its column, its letters, and what they leave empty around them.
const STYLE = `body { margin: 0 auto; max-width: 900px; font: 16px/1.5 sans-serif; }
  h1, h2, h3 { margin: 24px 0 16px; line-height: 1.25; padding-bottom: .3em; border-bottom: 1px solid; } h1 { font-size: 2em; }
  p, ul, table, pre { margin: 0 0 16px; } td, th { padding: 6px 13px; border: 1px solid; } pre { padding: 16px; }
  table { display: block; width: max-content; max-width: 100%; overflow: auto; border-collapse: collapse; }
  pre, code { font-size: 85%; } code { padding: .2em .4em; } img { max-width: 100%; }`;
let count = 0;

function check(good, what, said = "") {
  if (!good) String(said).split("\n").forEach((line) => console.log(`# ${line}`));
  console.log(`${good ? "ok" : "not ok"} ${++count} - ${what}`);
  if (!good) process.exitCode = 1;
}

const made = new Map();
function html_of(page) {
  if (!made.has(page)) made.set(page, execFileSync(pandoc, ["--from", "gfm", "--to", "html5", path.join(source, page)], {encoding: "utf8"}));
  return made.get(page);
}

// Links and pictures of a page that lead nowhere, with the names of headings.
function lost(page) {
  const targets = [...html_of(page).matchAll(/\s(?:href|src)="([^"]*)"/g)].map(([, target]) => decodeURI(target));
  return targets.filter((target) => !/^https?:/.test(target)).filter((target) => {
    const [file, name] = target.split("#"), to = file ? path.join(path.dirname(page), file) : page;
    return !fs.existsSync(path.join(source, to)) || (name && !html_of(to).includes(`id="${name}"`));
  });
}

async function readme_is_short() {
  if (!chromium) return console.log(`ok ${++count} - README is short # SKIP Chromium is missing: ./bootstrap --pdf`);
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "raykit-readme-")), browser = new Browser(chromium, folder);
  try {
    const page = path.join(folder, "readme.html");
    fs.writeFileSync(page, `<!DOCTYPE html><meta charset="utf-8"><base href="file://${path.resolve(source)}/"><style>${STYLE}</style>${html_of("README.md")}`);
    await browser.open(`file://${page}`);
    await browser.view(1280, "light");
    await browser.until('document.readyState === "complete"');
    const [high, empty] = await browser.value(`[document.documentElement.scrollHeight,
      [...document.images].filter((image) => !image.naturalWidth).map((image) => image.src).join("\\n")]`);
    check(empty === "", "README's pictures can be seen", empty);
    check(high > HEIGHT && high <= SCREENS * HEIGHT, `README has at most ${SCREENS} screens`,
      `it is ${high} pixels high, at most ${SCREENS * HEIGHT} are wanted: move something to docs/commands.md`);
  } finally {
    await browser.quit();
    fs.rmSync(folder, {recursive: true, force: true});
  }
}

async function main() {
  if (!pandoc) return console.log("1..0 # SKIP pandoc is missing: ./bootstrap");
  // Chapters are woven, and have links of their own.
  const pages = ["README.md", "CONTRIBUTING.md", ...["commands", "machines", "speed", "teaching", "tools"].map((name) => `docs/${name}.md`)];
  for (const page of pages) check(lost(page).length === 0, `all links of ${page} lead somewhere`, lost(page).join("\n"));
  await readme_is_short();
  console.log(`1..${count}`);
}

main();
