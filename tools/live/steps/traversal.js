// A ray through a tree of boxes: the scene from the side, the tree with the nodes visited, and the stack.
({once}, states, plot, {short}) => {
  const style = `
    .replay .ray { stroke: var(--three); stroke-width: 2; }
    .replay .ray.past { stroke-width: 1; stroke-dasharray: 2 4; }
    .replay .hit { fill: var(--three); stroke: var(--ink); }
    .replay .triangle { stroke: var(--ink); stroke-width: 2; }
    .replay .box.tested { stroke: var(--ink); stroke-width: 1.5; stroke-dasharray: 5 3; }
    .replay .node { fill: var(--paper); stroke: var(--soft); }
    .replay .node.visited { fill: var(--line); }
    .replay .node.tested { stroke: var(--ink); stroke-width: 2; }
    .replay .node.now + text, .replay .node.waits + text { fill: #fff; font-weight: 600; }
    .replay .node.now { fill: var(--one); }
    .replay .node.waits { fill: var(--two); }`;
  const {nodes, triangles, ray} = once, wide = 440;
  const low = nodes[0].box.corner[0], high = nodes[0].box.corner[1], side = wide / (high.x - low.x + 2), tall = side * (high.y - low.y + 1);
  const x = (value) => (value - low.x + 1.2) * side, y = (value) => tall - (value - low.y + .5) * side;
  const along = (t) => [x(ray.origin.x + t * ray.direction.x), y(ray.origin.y + t * ray.direction.y)];
  const place = []; // of each node in the tree: [x, y]
  let leaves = 0;
  const root = tall + 26;
  (function lay(n, depth) {
    const {first, count} = nodes[n];
    if (count) { place[n] = [leaves++, depth]; return place[n][0]; }
    place[n] = [(lay(first, depth + 1) + lay(first + 1, depth + 1)) / 2, depth];
    return place[n][0];
  })(0, 0);
  const deepest = Math.max(...place.filter(Boolean).map(([, depth]) => depth));
  const px = (n) => (place[n][0] + .5) * wide / leaves, py = (n) => root + 36 * place[n][1];
  const stackTop = root + 36 * deepest + 34;
  const visited = states.map(() => new Set());
  states.forEach((state, k) => {
    if (k) visited[k - 1].forEach((n) => visited[k].add(n));
    if (state.node != null) visited[k].add(state.node);
  });
  function draw(k, choose) {
    const {node, near, far, stack, hit} = states[k], waits = new Set((stack || []).map((entry) => entry.node)), tested = new Set([near, far].filter((n) => n != null));
    const kind = (n) => n === node ? "now" : tested.has(n) ? `tested ${waits.has(n) ? "waits" : ""}` : waits.has(n) ? "waits" : visited[k].has(n) ? "visited" : "";
    const box = (n) => {
      const [from, to] = nodes[n].box.corner;
      return plot.node("rect", {class: `box ${kind(n)}`, x: x(from.x), y: y(to.y), width: x(to.x) - x(from.x), height: y(from.y) - y(to.y)});
    };
    const all = Object.keys(place).map(Number), end = hit && typeof hit.t === "number" ? hit.t : null, far_end = 40;
    const shape = (n) => nodes[n].count ? plot.node("rect", {class: `node ${kind(n)}`, x: px(n) - 12, y: py(n) - 11, width: 24, height: 22})
      : plot.node("circle", {class: `node ${kind(n)}`, cx: px(n), cy: py(n), r: 12});
    return [...all.filter((n) => !kind(n) || kind(n) === "visited").map(box), ...all.filter((n) => kind(n) && kind(n) !== "visited").map(box),
      ...triangles.map(({a, c}) => plot.line(x(a.x), y(a.y), x(c.x), y(c.y), "triangle")),
      plot.line(...along(0), ...along(end ?? far_end), "ray"),
      ...(end === null ? [] : [plot.line(...along(end), ...along(far_end), "ray past"), plot.node("circle", {class: "hit", cx: along(end)[0], cy: along(end)[1], r: 4})]),
      plot.node("rect", {x: 0, y: tall, width: wide, height: 400, fill: "var(--paper)"}),
      ...all.filter((n) => !nodes[n].count).flatMap((n) => [nodes[n].first, nodes[n].first + 1].map((child) => plot.line(px(n), py(n), px(child), py(child), "line"))),
      ...all.map((n) => {
        const group = plot.node("g", choose && choose(n) ? {class: "choice"} : {}, shape(n), plot.text(px(n), py(n) + 4, n));
        if (choose && choose(n)) group.onclick = choose(n);
        return group;
      }),
      plot.text(4, stackTop + 15, stack ? stack.length ? "stack" : "the stack is empty" : "", "start", {class: "soft"}),
      ...(stack || []).flatMap((entry, j) => [plot.node("rect", {class: "node waits", x: 44 + 96 * j, y: stackTop, width: 90, height: 22}),
        plot.text(89 + 96 * j, stackTop + 15, `${entry.node} from t ${short(entry.enter)}`)])];
  }
  // A question before the first visit of each kind.
  const questions = new Map(), asked = new Set(), name = (n) => n == null ? "none: the search ends" : `node ${n}`;
  states.forEach((state, k) => {
    const begins = k > 0 && (state.enter_far !== states[k - 1].enter_far && state.enter_far != null || state.triangle_tests > (states[k - 1].triangle_tests ?? Infinity));
    const until = begins ? states.findIndex((later, j) => j > k && later.node !== state.node) : -1;
    if (until < 0) return;
    const inner = state.enter_far != null, next = states[until].node, {stack, hit} = state;
    if (inner && (state.enter_near === "inf" || state.enter_far === "inf")) return;
    if (!inner && nodes[state.node].count === 0) return;
    const left = stack.slice(0, next == null ? 0 : stack.findIndex((entry) => entry.node === next)), skips = !inner && stack.length > left.length + (next == null ? 0 : 1);
    const type = inner ? "enters" : skips ? "skips" : "pops";
    if (asked.has(type)) return;
    asked.add(type);
    const options = [...new Set([...(inner ? [state.near, state.far].sort((a, b) => a - b) : []), ...stack.map((entry) => entry.node)])];
    questions.set(k, {text: (inner ? `The ray enters node ${state.near} at t ${short(state.enter_near)} and node ${state.far} at t ${short(state.enter_far)}. `
      : `Leaf ${state.node} is tested, and ${hit.t === "inf" ? "nothing is hit so far" : `the nearest hit is at t ${short(hit.t)}`}. `) + "Which node is visited next?",
    choices: [...options, null].map(name), right: [...options, null].findIndex((n) => n === (next ?? null)), options, until});
  });
  return {style, height: stackTop + 30, label: "the ray and the boxes, the tree, and the stack", draw, questions, names: ["node", "near", "far", "enter_near", "enter_far", "next", "hit", "box_tests", "triangle_tests"],
    strides: {line: () => true, node: (k) => states[k].node !== states[k - 1].node}};
}
