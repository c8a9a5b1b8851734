// The selection of the lowest keys: keys as bars, the part that goes on, and the pivot's round.
({once}, states, plot, {nth}) => {
  const style = `
    .replay .bar { fill: var(--soft); opacity: .45; }
    .replay .bar.low { fill: var(--one); opacity: 1; }
    .replay .bar.high { fill: var(--two); opacity: 1; }
    .replay .bar.pivot { fill: var(--three); opacity: 1; }
    .replay .bar.out { opacity: .15; }`;
  const count = states[0].keys.length, wide = 400 / count, floor = 150;
  const at = (k) => 20 + wide * (k + .5);
  const mark = (name, k, y) => k == null ? [] : [plot.node("path", {d: `M${at(k)} ${y - 13}l4 6h-8z`, fill: "currentColor"}), plot.text(at(k), y + 3, name)];
  function draw(k) {
    const {keys, begin, end, pivot, boundary, i} = states[k], from = begin ?? 0, to = end ?? count;
    const kind = (j) => j < from || j >= to ? "out" : pivot == null ? "" : j === from && keys[j] === pivot ? "pivot" : boundary == null ? ""
      : j > from && j <= boundary ? "low" : j > boundary && i != null && j < i ? "high" : "";
    return [...keys.flatMap((key, j) => [
      plot.node("rect", {class: `bar ${kind(j)}`, x: at(j) - wide * .4, y: floor - 5 * key - 5, width: wide * .8, height: 5 * key + 5}),
      plot.text(at(j), floor + 12, key)]),
    plot.line(20 + wide * once.wanted, 4, 20 + wide * once.wanted, floor + 16, "guide"), plot.text(15 + wide * once.wanted, 12, `the ${once.wanted} lowest go left of this line`, "end", {class: "soft"}),
    ...mark("begin", begin, floor + 30), ...mark("end", end, floor + 30), ...mark("boundary", boundary, floor + 50), ...mark("i", i, floor + 70)];
  }
  const questions = new Map();
  states.forEach((state, k) => {
    if (k === 0 || state.pivot == null || states[k - 1].pivot != null) return;
    const until = states.findIndex((later, j) => j > k && (later.begin !== state.begin || later.end !== state.end));
    if (until < 0) return;
    questions.set(k, {text: `The pivot is the ${nth(state.pivot)}-lowest of all keys, and the ${once.wanted} lowest are wanted. Which part will need another round?`,
      choices: ["the keys before the pivot", "the keys behind it"], right: states[until].end !== state.end ? 0 : 1, until});
  });
  return {style, height: 225, label: `${count} keys as bars, as tall as their rank`, draw, questions, names: ["begin", "end", "pivot", "boundary", "i", "key"],
    strides: {line: () => true, key: (k) => states[k].i !== states[k - 1].i, round: (k) => states[k].end !== states[k - 1].end || states[k].begin !== states[k - 1].begin}};
}
