// A point scrambled by the coins of a binary tree: its way through the tree, its digits before and after, and its place on
// the interval. Coins beside its way are read from where the unit takes each eighth.
({once, result}, states, plot) => {
  const style = `
    .replay .coin { fill: var(--paper); stroke: var(--three); stroke-width: 1.5; }
    .replay .coin.heads { fill: var(--three); }
    .replay .coin.now { stroke: var(--ink); stroke-width: 3; }
    .replay .branch { stroke: var(--line); stroke-width: 1.5; }
    .replay .branch.way { stroke: var(--one); stroke-width: 3; }
    .replay .eighth { fill: var(--one); opacity: .15; }
    .replay .eighth.upper { opacity: .45; }
    .replay .eighth.off { opacity: .1; }
    .replay .moves { stroke: var(--soft); fill: none; }
    .replay .point { fill: var(--two); stroke: var(--paper); }
    .replay .travels { stroke: var(--two); stroke-width: 2; fill: none; }
    .replay .reach { fill: none; stroke: var(--two); stroke-width: 2; }
    .replay .digit { font-family: monospace; }
    .replay .digit.flipped { font-weight: 700; fill: #fff; }
    .replay .flip { fill: var(--two); }
    .replay .cell { fill: var(--line); }`;
  const levels = 3, wide = 52, left = 12, top = 20, row = 46, from = top + levels * row - 8, to = from + 76, below = to + 62;
  const digit = (bits, place, width = 32) => Math.floor(bits / 2 ** (width - 1 - place)) % 2;
  const binary = (bits, width = 32) => bits.toString(2).padStart(width, "0");
  const at = (level, before) => left + wide * 8 * (before + .5) / 2 ** level, high = (level) => top + row * level;
  const x = (bits) => left + wide * 8 * (bits + .5) / 2 ** 32;
  const coin = (level, before) => { // of the node behind these digits
    const through = before * 2 ** (levels - level);
    return digit(result.eighths[through], level, levels) !== digit(through, level, levels);
  };
  const nodes = [...Array(levels).keys()].flatMap((level) => [...Array(2 ** level).keys()].map((before) => ({level, before})));
  const leads = ({level, before}) => Math.floor(once.bits / 2 ** (32 - level)) === before;
  const last = states.length - 1, tossed = [0]; // coins, after each step
  states.forEach(({before}, k) => { if (k) tossed[k] = tossed[k - 1] + (before == null && states[k - 1].before != null); });
  function draw(k) {
    const {digit: now, before, scrambled} = states[k], done = tossed[k];
    const nextRow = (n) => Math.floor(once.bits / 2 ** (32 - n)), reach = wide * 8 / 2 ** done;
    const after = scrambled ?? once.bits, starts = left + wide * 8 * Math.floor(after / 2 ** (32 - done)) / 2 ** done;
    return [
      ...nodes.flatMap(({level, before: p}) => [0, 1].map((side) => plot.line(at(level, p), high(level), at(level + 1, 2 * p + side), level + 1 < levels ? high(level + 1) : from,
        `branch ${level < done && nextRow(level + 1) === 2 * p + side ? "way" : ""}`))),
      ...nodes.map((node) => plot.node("circle", {class: `coin ${coin(node.level, node.before) ? "heads" : ""} ${now === node.level && before != null && leads(node) ? "now" : ""}`,
        cx: at(node.level, node.before), cy: high(node.level), r: 10})),
      plot.node("circle", {class: "coin heads", cx: 12, cy: 16, r: 7}), plot.text(24, 20, "heads: exchange", "start"), plot.node("circle", {class: "coin", cx: 12, cy: 36, r: 7}), plot.text(24, 40, "tails", "start"),
      ...(now != null && now < levels && before != null ? [plot.text(at(now, nextRow(now)) + 15, high(now) + 4, `before: ${before.toString(2)}`, "start", {class: "strong"})] : []),
      ...[from, to].flatMap((y, after_it) => [...Array(8).keys()].map((i) => {
        const source = after_it ? result.eighths.indexOf(i) : i, known = !after_it || k === last;
        return plot.node("g", {}, plot.node("rect", {class: `eighth ${!known ? "off" : source > 3 ? "upper" : ""}`, x: left + wide * i + 1, y, width: wide - 2, height: 20}), plot.text(left + wide * (i + .5), y + 14, known ? source : ""));
      })),
      plot.text(436, from + 34, "before", "end", {class: "soft"}), plot.text(436, to - 6, "after", "end", {class: "soft"}),
      ...(k === last ? result.eighths.map((place, i) => plot.line(left + wide * (i + .5), from + 20, left + wide * (place + .5), to, "moves")) : []),
      plot.node("path", {class: "travels", d: `M${x(once.bits)} ${from + 20}L${x(after)} ${to}`}),
      ...(scrambled == null ? [] : [plot.node("rect", {class: "reach", x: starts, y: to - 2, width: Math.max(reach, 1), height: 24})]),
      plot.node("circle", {class: "point", cx: x(once.bits), cy: from + 20, r: 4.5}), plot.node("circle", {class: "point", cx: x(after), cy: to, r: 4.5}),
      ...(scrambled == null ? [] : [plot.text(Math.min(Math.max(x(after), 30), 410), to + 36, (scrambled / 2 ** 32).toFixed(4), "middle", {class: "strong"})]),
      ...(now == null ? [] : [plot.node("rect", {class: "cell", x: 12 + 13 * now, y: below - 12, width: 13, height: 34})]),
      ...[...binary(once.bits)].map((value, j) => plot.text(18 + 13 * j, below, value, "middle", {class: "digit"})),
      ...(scrambled == null ? [] : [...binary(scrambled)].flatMap((value, j) => digit(once.bits, j) === Number(value) ? [plot.text(18 + 13 * j, below + 18, value, "middle", {class: "digit after"})]
        : [plot.node("rect", {class: "flip", x: 12 + 13 * j, y: below + 8, width: 13, height: 14}), plot.text(18 + 13 * j, below + 18, value, "middle", {class: "digit after flipped"})])),
      plot.text(6, below - 17, "the point's digits, and as they are scrambled", "start", {class: "soft"})];
  }

  // Where the point goes, and which coin a later digit gets.
  const questions = new Map(), end = states[last].scrambled, start = states.findIndex(({scrambled}) => scrambled != null);
  const settled = states.findIndex(({digit: now}) => now === levels), second = states.findIndex(({digit: now}) => now === 1);
  if (start > 0 && settled > 0) questions.set(start, {text: "The coins of the first three levels are tossed. To which eighth do they take the point, from interval 3?",
    choices: [...Array(8).keys()].map((i) => `interval ${i}`), right: Math.floor(end / 2 ** 29), until: settled});
  const seen = states.findIndex(({before}, k) => k > second && before != null), was = digit(once.bits, 0), is = second < 0 ? was : digit(states[second].scrambled, 0);
  const right = seen < 0 ? -1 : [2 + was, 2 + is, 1].indexOf(states[seen].before);
  if (second > 0 && was !== is && right >= 0) questions.set(second, {text: `The first digit was ${was} and has become ${is}. Which coin does the second digit get?`,
    choices: [`that of the node after ${was}`, `that of the node after ${is}`, "the root's again"], right, until: seen});
  return {style, height: below + 26, label: "the tree of coins, the point before and after, and its digits", draw, questions, names: ["digit", "before", "scrambled"],
    strides: {line: () => true, digit: (k) => states[k].digit !== states[k - 1].digit}};
}
