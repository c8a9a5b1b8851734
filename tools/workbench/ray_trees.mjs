// Explanations of a pixel as trees of lines, side by side, the first line that differs marked in each.
import {made} from "./elements.mjs";

// Lines that are indented deeper belong to the line above them.
function treeOf(text) {
  const root = {line: "", indent: -1, children: []}, open = [root];
  for (const line of text.trimEnd().split("\n")) {
    const node = {line: line.trim(), indent: line.search(/\S/), children: []};
    while (open[open.length - 1].indent >= node.indent) open.pop();
    open[open.length - 1].children.push(node);
    open.push(node);
  }
  return root;
}

// Pairs the lines of two trees in their order, and returns the pairs on the way to the first line that differs.
function compare(a, b, above = []) {
  const pair = [a, b], way = [...above, pair];
  let first = null;
  if (a && b && a.line === b.line) {
    for (let i = 0; i < Math.max(a.children.length, b.children.length); i++) {
      const found = compare(a.children[i], b.children[i], way);
      first = first || found;
    }
  } else {
    first = way;
  }
  for (const node of pair.filter((node) => node)) node.differs = first !== null;
  return first;
}

// What differs nowhere below is folded.
function draw(node, marked) {
  const isLeaf = !node.children.length, line = made(isLeaf ? "span" : "summary", {}, node === marked ? made("mark", {}, node.line) : node.line);
  if (node.differs && isLeaf) line.className = "differs";
  return isLeaf ? made("div", {}, line)
    : made("details", {open: node.differs !== false}, line, ...node.children.map((child) => draw(child, marked)));
}

function firstDifference(way, whose) {
  const lines = way[way.length - 1].map((node) => node ? node.line : "no such line");
  const rows = lines.map((line, i) => made("tr", {}, made("td", {}, whose[i]), made("td", {}, made("code", {}, line))));
  const names = way.slice(1, -1).map(([node]) => node.line);
  return [made("p", {}, `The first difference${names.length ? `, in ${names.join(" \u203a ")}` : ""}:`), made("table", {}, ...rows)];
}

// Shows one explanation, or two and, unless they are not to be compared, where they begin to differ, in an element; whose:
// their titles.
export function showRayTrees(element, texts, whose, isCompared = true) {
  const roots = texts.map(treeOf), areTwo = roots.length > 1 && isCompared, way = areTwo ? compare(...roots) : null;
  const trees = roots.map((root, i) => {
    if (!way) root.children.forEach(function unfold(node) { node.differs = undefined; node.children.forEach(unfold); });
    const nodes = root.children.map((node) => draw(node, way && way[way.length - 1][i]));
    return made("div", {}, made("b", {}, whose[i]), made("div", {className: "tree", tabIndex: 0}, ...nodes));
  });
  const same = areTwo && /^camera ray$/m.test(texts[0]) ? [made("p", {}, "Both explain this pixel alike, along the one camera ray that is shown.")] : [];
  element.replaceChildren(...way ? firstDifference(way, whose) : same, made("div", {className: "trees"}, ...trees));
}

// Scrolls the trees in an element to what is marked in them.
export function scrollToMarks(element) {
  for (const mark of element.querySelectorAll(".tree mark")) {
    const tree = mark.closest(".tree");
    tree.scrollTop += mark.getBoundingClientRect().top - tree.getBoundingClientRect().top - tree.clientHeight / 3;
  }
}
