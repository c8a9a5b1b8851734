// Formulas for the book, by KaTeX, without any network.
//   node formulas.js KATEX_FOLDER <formulas >html
// The formulas come separated by the character 30, each begun by "I" (in a line) or "D" (displayed);
// the answers go out likewise, "H" and HTML, or "E" and what is wrong with a formula.
//   node formulas.js KATEX_FOLDER --css STYLESHEET >css
// prints KaTeX's stylesheet with the fonts in it, those that formulas in plain mathematics use.
"use strict";
const fs = require("fs");
const path = require("path");

const separator = "\x1e";
const [folder, option, stylesheet] = process.argv.slice(2);

function html(formula) {
  const katex = require(folder);
  const options = { displayMode: formula[0] === "D", output: "htmlAndMathml", strict: "error" };
  try {
    return "H" + katex.renderToString(formula.slice(1), options);
  } catch (error) {
    return "E" + error.message;
  }
}

function css() {
  const needed = /KaTeX_(Main|Math|AMS|Size\d)-/;
  const face = /@font-face\s*{[^}]*}/g;
  return fs.readFileSync(stylesheet, "utf8").replace(face, (rule) => {
    const file = /url\(["']?([^"')]*\.woff2)/.exec(rule);
    if (!file || !needed.test(file[1])) return "";
    const font = fs.readFileSync(path.join(path.dirname(stylesheet), file[1])).toString("base64");
    return rule.replace(/src:[^;}]*/, `src:url(data:font/woff2;base64,${font}) format("woff2")`);
  });
}

if (option === "--css") {
  process.stdout.write(css());
} else {
  const formulas = fs.readFileSync(0, "utf8").split(separator);
  process.stdout.write(formulas.map(html).join(separator));
}
