// Triangles counted into bins, and the two sweeps over these: boxes above, the cost of each split below.
({once}, states, plot) => {
  const style = `
    .replay .part { fill: var(--soft); opacity: .3; }
    .replay .part.now { fill: var(--three); opacity: .8; }
    .replay .part.low { fill: var(--one); opacity: .6; }
    .replay .part.high { fill: var(--two); opacity: .6; }
    .replay .middle { fill: var(--ink); }
    .replay .least { fill: none; stroke: var(--three); stroke-width: 2; }`;
  const {references} = once, boxes = references.map(({box}) => box.corner), low = Math.min(...boxes.map(([from]) => from.x)), high = Math.max(...boxes.map(([, to]) => to.x));
  const bottom = Math.min(...boxes.map(([from]) => from.y)), top = Math.max(...boxes.map(([, to]) => to.y)), side = 410 / (high - low), floor = 20 + side * (top - bottom);
  const x = (value) => 15 + (value - low) * side, y = (value) => floor - 8 - (value - bottom) * side;
  const rect = ([from, to], kind) => plot.node("rect", {class: kind, x: x(from.x), y: y(to.y), width: x(to.x) - x(from.x), height: y(from.y) - y(to.y)});
  const final = states.findLast(({costs}) => costs), most = Math.max(...final.costs), cost = (value) => floor + 140 - 90 * value / most;
  const binOf = references.map((reference, i) => (states.findLast((state) => state.i === i && state.bin != null) || {}).bin), seen = states.find(({bins}) => bins);
  const edge = (b) => x(seen.low + b / seen.bins_per_unit), least = (costs) => costs.indexOf(Math.min(...costs));
  const named = (group) => group && group.count > 0 ? group.box.corner : null;
  function draw(k) {
    const {bins, filled, above, below, boundary, tried, costs, i, bin} = states[k], now = states[k].k, sweeps = above && above.some(({count}) => count > 0);
    const upper = sweeps ? named(above[boundary ?? now ?? above.findIndex(({count}) => count > 0)]) : null, lower = boundary == null ? null : named(below);
    const kind = (n) => n === i ? "now" : boundary != null && binOf[n] < boundary ? "low" : sweeps && binOf[n] >= (boundary ?? now ?? 0) ? "high" : "";
    const known = (costs || []).map((value, j) => [tried[j], value]).filter(([, value]) => value > 0);
    return [...(bins ? [...Array(bins + 1).keys()].map((b) => plot.line(edge(b), 8, edge(b), floor + 145, "guide")) : []),
      ...boxes.map((box, n) => rect(box, `part ${kind(n)}`)),
      ...references.map(({centroid}, n) => plot.node("circle", {class: "middle", cx: x(centroid.x), cy: y(centroid.y), r: n === i ? 3.5 : 2})),
      ...(bin != null && named(filled[bin]) ? [rect(named(filled[bin]), "box now")] : []),
      ...(upper ? [rect(upper, "box waits")] : []), ...(lower ? [rect(lower, "box now")] : []),
      ...(bins ? [plot.text(x(low) - 10, floor + 8, "bin", "start", {class: "soft"}), plot.text(x(low) - 10, floor + 24, "has", "start", {class: "soft"})] : []),
      ...(bins ? filled.flatMap(({count}, b) => [plot.text((edge(b) + edge(b + 1)) / 2, floor + 8, b, "middle", {class: "soft"}), plot.text((edge(b) + edge(b + 1)) / 2, floor + 24, count, "middle", b === bin ? {class: "strong"} : {})]) : []),
      ...known.flatMap(([b, value]) => [plot.node("circle", {class: "middle", cx: edge(b), cy: cost(value), r: 3.5}), plot.text(edge(b), cost(value) - 11, value.toPrecision(3))]), ...(known.length ? [plot.text(x(low) - 10, cost(most / 2), "cost", "start", {class: "soft"})] : []),
      ...(known.length ? [plot.node("circle", {class: "least", cx: edge(known[least(known.map(([, value]) => value))][0]), cy: cost(Math.min(...known.map(([, value]) => value))), r: 7})] : [])];
  }
  const questions = new Map(), first = states.findIndex(({i}) => i === 0), sweep = states.findIndex(({above}) => above && above.some(({count}) => count > 0));
  const counted = states.findIndex((state, j) => j > first && state.filled.some(({count}) => count > 0));
  questions.set(first, {text: "The first triangle's centre is the large dot. Which bin counts it?", choices: seen.bins ? [...Array(seen.bins).keys()].map((b) => `bin ${b}`) : [], right: binOf[0], until: counted});
  questions.set(sweep, {text: "The bins are filled. Where will a split cost least?", choices: [...Array(seen.bins - 1).keys()].map((b) => `between bins ${b} and ${b + 1}`),
    right: final.tried[least(final.costs)] - 1, until: states.length - 1});
  return {style, height: floor + 155, label: "the triangles' boxes, the bins, and the cost of each split", draw, questions, names: ["bins", "i", "bin", "k", "boundary"],
    strides: {line: () => true, triangle: (k) => states[k].i !== states[k - 1].i, boundary: (k) => states[k].boundary !== states[k - 1].boundary || states[k].k !== states[k - 1].k}};
}
