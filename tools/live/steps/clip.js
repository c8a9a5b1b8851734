// A lamp clipped at the horizon of a surface: its corners from the side, so that heights are true, and below them the
// corners that are kept, in their order.
({once}, states, plot, {short}) => {
  const style = `
    .replay .ground { fill: var(--ink); opacity: .07; }
    .replay .horizon { stroke: var(--ink); stroke-width: 2; }
    .replay .lamp { fill: none; stroke: var(--soft); stroke-dasharray: 5 4; }
    .replay .edge { stroke: var(--ink); stroke-width: 3; }
    .replay .kept { fill: var(--one); fill-opacity: .15; stroke: var(--one); stroke-width: 2; }
    .replay .corner { fill: var(--paper); stroke: var(--soft); stroke-width: 1.5; }
    .replay .corner.old, .replay .slot.old rect { fill: var(--one); stroke: var(--one); }
    .replay .corner.new, .replay .slot.new rect { fill: var(--three); stroke: var(--three); }
    .replay .slot text { fill: #fff; font-weight: 600; }
    .replay .slot.new text { fill: #000; }
    .replay .free { fill: none; stroke: var(--line); }`;
  const {corners, n} = once, height = (p) => n.x * p.x + n.y * p.y + n.z * p.z, count = corners.length;
  const side = 68, level = 30 + side * Math.max(...corners.map(height)), low = level - side * Math.min(...corners.map(height)) + 34;
  const x = (p) => 40 + side * p.x, y = (p) => level - side * height(p), path = (list) => `M${list.map((p) => `${x(p)} ${y(p)}`).join("L")}`;
  const same = (p, q) => p.x === q.x && p.y === q.y && p.z === q.z, indexOf = (p) => corners.findIndex((corner) => same(corner, p));
  const middle = {x: corners.reduce((sum, p) => sum + x(p), 0) / count, y: corners.reduce((sum, p) => sum + y(p), 0) / count};
  const away = (p, by) => { // beside a corner, on the lamp's outside
    const long = Math.hypot(x(p) - middle.x, y(p) - middle.y) || 1;
    return [x(p) + by * (x(p) - middle.x) / long, y(p) + by * (y(p) - middle.y) / long + 4];
  };
  const dot = (p, kind) => plot.node("circle", {class: `corner ${kind}`, cx: x(p), cy: y(p), r: 5});
  const measure = (p, value, other) => value == null || value === 0 ? [] : [plot.line(x(p), level, x(p), y(p) + 6 * Math.sign(value), "guide"),
    plot.text(x(p) + (x(p) > x(other) ? 6 : -6), (level + y(p)) / 2 + 4, short(value), x(p) > x(other) ? "start" : "end", {class: "strong"})];
  function draw(k) {
    const {i, a, b, above_a, above_b, at, kept, left} = states[k], list = kept || [], slot = 62;
    const from = corners[i], to = corners[(i + 1) % count];
    return [plot.node("rect", {class: "ground", x: 0, y: level, width: 440, height: low - level}), plot.line(0, level, 440, level, "horizon"),
      plot.text(436, level - 6, "horizon", "end", {class: "soft"}), plot.line(40, level, 40, level - 52, "line"), plot.node("path", {d: `M40 ${level - 58}l-4 9h8z`, fill: "var(--soft)"}),
      plot.text(34, level - 46, "n", "end", {class: "strong"}), plot.node("circle", {cx: 40, cy: level, r: 4, fill: "var(--ink)"}), plot.text(6, level + 16, "surface point", "start", {class: "soft"}),
      plot.node("path", {class: "lamp", d: `${path(corners)}Z`}),
      ...(list.length > 1 ? [plot.node("path", {class: "kept", d: path(list) + (i == null ? "Z" : "")})] : []),
      ...(from ? [plot.line(x(from), y(from), x(to), y(to), "edge")] : []),
      ...(a && b ? [...measure(a, above_a, b), ...measure(b, above_b, a)] : []),
      ...(a && b && at != null ? [plot.text((x(a) + x(b)) / 2 + 10, (y(a) + y(b)) / 2 - 6, `at ${short(at)}`, "start", {class: "strong"})] : []),
      ...corners.map((p) => dot(p, list.some((q) => same(p, q)) ? "old" : "")), ...list.filter((p) => indexOf(p) < 0).map((p) => dot(p, "new")),
      ...corners.map((p, j) => plot.text(...away(p, 15), j)),
      ...(a ? [plot.text(...away(a, 30), "a", "middle", {class: "strong"}), plot.text(...away(b, 30), "b", "middle", {class: "strong"})] : []),
      plot.text(4, low + 24, "kept", "start", {class: "soft"}),
      ...[...Array(6).keys()].map((j) => plot.node("rect", {class: "free", x: 40 + (slot + 4) * j, y: low + 8, width: slot, height: 24})),
      ...list.map((p, j) => plot.node("g", {class: `slot ${indexOf(p) < 0 ? "new" : "old"}`}, plot.node("rect", {x: 40 + (slot + 4) * j, y: low + 8, width: slot, height: 24}),
        plot.text(40 + (slot + 4) * j + slot / 2, low + 24, indexOf(p) < 0 ? "new" : `corner ${indexOf(p)}`))),
      ...(left == null ? [] : [plot.node("path", {d: `M${40 + (slot + 4) * left + slot / 2} ${low + 35}l4 6h-8z`, fill: "currentColor"}), plot.text(40 + (slot + 4) * left + slot / 2, low + 51, "left")])];
  }

  // How many are left, and what an edge adds that crosses the horizon: one that comes up, and one that goes down.
  const questions = new Map(), final = states[states.length - 1].kept || [], first = states.findIndex(({i}) => i === 0);
  const numbers = [3, 4, 5, 6];
  if (numbers.includes(final.length)) questions.set(first, {text: "Two of the lamp's four corners are below the horizon. How many corners has the part above it?",
    choices: numbers.map(String), right: numbers.indexOf(final.length), until: states.length - 1});
  for (const rises of [true, false]) {
    const k = states.findIndex(({above_a, above_b}) => rises ? above_a < 0 && above_b > 0 : above_a > 0 && above_b < 0);
    if (k < 0) continue;
    const until = states.findIndex((later, j) => j > k && later.i !== states[k].i), before = states[k].kept.length, added = until < 0 ? [] : states[until].kept.slice(before).map((p) => indexOf(p) < 0 ? "new" : "old").join();
    const right = ["", "old", "new", "old,new"].indexOf(added);
    if (until < 0 || right < 0) continue;
    questions.set(k, {text: `Corner ${states[k].i} is at the height ${short(states[k].above_a)}, the next one at ${short(states[k].above_b)}. What does this edge add?`,
      choices: ["nothing", `corner ${states[k].i}`, "a new corner", `corner ${states[k].i}, then a new one`], right, until: until - 1});
  }
  return {style, height: low + 56, label: "the lamp's corners, the horizon, and the corners kept", draw, questions, names: ["i", "above_a", "above_b", "at", "left"],
    strides: {line: () => true, edge: (k) => states[k].i !== states[k - 1].i}};
}
