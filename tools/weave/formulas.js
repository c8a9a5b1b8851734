// Formulas for the book, by KaTeX, without any network.
//   node formulas.js KATEX_FOLDER <formulas >html
// The formulas come separated by the character 30, each begun by "I" (in a line) or "D" (displayed);
// the answers go out likewise, "H" and HTML, or "E" and what is wrong with a formula.
//   node formulas.js KATEX_FOLDER --css STYLESHEET >css
// prints KaTeX's stylesheet with the fonts in it, those that formulas in plain mathematics use. With a last argument,
// a folder beside the stylesheet, they are copied there instead, and a browser loads those that a page uses.
"use strict";
const fs = require("fs");
const path = require("path");

const separator = "\x1e";
const [folder, option, stylesheet, fonts] = process.argv.slice(2);

function html(formula) {
  const katex = require(folder);
  const options = { displayMode: formula[0] === "D", output: "htmlAndMathml", strict: "error" };
  try {
    return "H" + katex.renderToString(formula.slice(1), options);
  } catch (error) {
    return "E" + error.message;
  }
}

function address(font) {
  if (!fonts) return `data:font/woff2;base64,${fs.readFileSync(font).toString("base64")}`;
  fs.mkdirSync(fonts, {recursive: true});
  fs.copyFileSync(font, path.join(fonts, path.basename(font)));
  return `${path.basename(fonts)}/${path.basename(font)}`;
}

function css() {
  const needed = /KaTeX_(Main|Math|AMS|Size\d)-/;
  const face = /@font-face\s*{[^}]*}/g;
  return fs.readFileSync(stylesheet, "utf8").replace(face, (rule) => {
    const file = /url\(["']?([^"')]*\.woff2)/.exec(rule);
    if (!file || !needed.test(file[1])) return "";
    return rule.replace(/src:[^;}]*/, `src:url(${address(path.join(path.dirname(stylesheet), file[1]))}) format("woff2")`);
  });
}

if (option === "--css") {
  process.stdout.write(css());
} else {
  const formulas = fs.readFileSync(0, "utf8").split(separator);
  process.stdout.write(formulas.map(html).join(separator));
}
