// The splits of a node: its triangles from the side, the cost of each split below them, and a plane to be dragged
// over both. Numbers and triangles are those of sah_binning --splits.
({make, Plot}) => class {
  constructor(figure, box) {
    Object.assign(this, {figure, near: []});
    const margin = {left: 50, right: 10, top: 8, bottom: 6};
    this.side = new Plot("the triangles of the node, from the side", {low: 0, high: 1, hidden: true}, {low: 0, high: 1, hidden: true},
      {height: 190, margin});
    this.cost = new Plot("the cost of each split", {low: 0, high: 1}, {low: 0, high: 1, label: "expected cost of a ray"},
      {height: 200, margin: {...margin, bottom: 34}});
    for (const plot of [this.side, this.cost])
      plot.handle("x", plot === this.side ? "plane over the triangles" : "plane on the cost curve", {
        place: () => ({x: this.now ? this.now.plane : 0, now: this.now ? this.now.candidate : 0,
          text: this.now ? `cost ${this.now.cost}` : ""}),
        move: ({x}, done) => this.choose(this.nearest(x), done),
        step: (way) => this.choose(this.near[this.near.indexOf(this.now) + way], true),
      });
    const choose = make("button", {type: "button", textContent: "Go to the cheapest", onclick: () => this.choose(this.least, true)});
    this.says = make("p", {className: "numbers"});
    box.append(this.side.element, this.cost.element, this.says, choose);
  }

  // The tables depend on the tree alone.
  asks(args) {
    const tree = new Map(args);
    for (const name of ["candidate", "debug", "width", "height", "yaw", "pitch"]) tree.delete(name);
    return [...tree, ["splits", true]];
  }

  answer({rows}) {
    const numbers = rows.map((row) => Object.fromEntries(Object.entries(row).map(([name, text]) => [name, Number(text)])));
    this.all = numbers.filter((row, i) => { row.text = rows[i]; return "candidate" in row; });
    this.triangles = numbers.filter((row) => "triangle" in row);
    this.least = this.all.find((row) => row.cheapest) || this.all[0]; // an unsolved unit names none
    this.follow(this.figure.args);
    if (String(this.now.candidate) !== String(this.figure.args.get("candidate"))) this.choose(this.now, true);
  }

  // The candidate that the options name; beyond the last one, the cheapest.
  follow(args) {
    if (!this.all) return;
    this.now = this.all[Number(args.get("candidate"))] || this.least;
    this.draw();
  }

  nearest(x) { return this.near.reduce((best, row) => Math.abs(row.plane - x) < Math.abs(best.plane - x) ? row : best, this.near[0]); }

  choose(row, done) {
    if (!row) return;
    this.now = row;
    this.draw();
    this.figure.change("candidate", row.candidate, done);
  }

  draw() {
    const {axis, plane, left, right, cost} = this.now.text, k = Number(axis), up = k === 1 ? 0 : 1;
    this.near = this.all.filter((row) => row.axis === k);
    const extent = (axis) => [Math.min(...this.triangles.map((t) => t[`low${axis}`])), Math.max(...this.triangles.map((t) => t[`high${axis}`]))];
    const [low, high] = extent(k), [below, above] = extent(up), costs = this.near.map((row) => row.cost);
    for (const plot of [this.side, this.cost]) Object.assign(plot.x, {low, high});
    this.cost.x.label = `the plane's place on the ${"xyz"[k]} axis`;
    Object.assign(this.side.y, {low: below, high: above});
    Object.assign(this.cost.y, {low: 0, high: 1.1 * Math.max(...costs)});
    const {side} = this;
    this.side.draw(...this.triangles.map((t) => side.node("rect", {class: t[`centroid${k}`] < this.now.plane ? "one" : "two",
      x: side.px(t[`low${k}`]), y: side.py(t[`high${up}`]), width: Math.max(1, side.px(t[`high${k}`]) - side.px(t[`low${k}`])),
      height: Math.max(1, side.py(t[`low${up}`]) - side.py(t[`high${up}`]))})));
    const points = this.near.map((row) => [row.plane, row.cost]);
    this.cost.tell([`${this.cost.x.label}, world units`, this.cost.y.label], points);
    this.cost.draw(this.cost.curve(points), ...points.map((point) => this.cost.dot(...point, "plain", 2)),
      ...(this.least.axis !== k ? [] : [this.cost.dot(this.least.plane, this.least.cost, "least", 5),
        this.cost.text(this.cost.px(this.least.plane), this.cost.py(this.least.cost) + 18, "cheapest")]),
      this.cost.dot(this.now.plane, this.now.cost, "one", 4.5));
    const percent = (text) => `${(100 * Number(text)).toFixed(1)} %`;
    this.says.replaceChildren(make("b", {textContent: `cost ${cost}`}), ` = 1.5 + ${percent(this.now.text.left_area)} of the node's area · `,
      make("span", {className: "one", textContent: `${left} left`}), ` + ${percent(this.now.text.right_area)} · `,
      make("span", {className: "two", textContent: `${right} right`}), `; plane at ${plane}` + (this.now === this.least ? ", the cheapest" : ""));
    Plot.brief(this.says);
    this.figure.element.dataset.plane = plane;
  }
}
