// The lens from the side: the focal plane and a point on the axis are dragged, and the cone of the point's light shows
// its circle of confusion. Below, the circle's diameter by distance: depth_of_field --circles.
({make, Plot}) => class {
  constructor(figure, box) {
    Object.assign(this, {figure, rows: [], column: [], point: null}); // point: the row of the distance that is shown
    const margin = {left: 40, right: 10, top: 8, bottom: 6};
    this.side = new Plot("the lens, the focal plane and the scene from the side", {low: 0, high: 1, hidden: true}, {low: -1, high: 1, hidden: true},
      {height: 224, margin});
    this.curve = new Plot("the circle of confusion by distance", {low: 0, high: 1, label: "distance from the lens"}, {low: 0, high: 1, label: "diameter, pixels"},
      {height: 190, margin: {...margin, bottom: 34}});
    const focus = {
      place: () => ({x: this.focus(), text: `focal distance ${this.focus()}`}),
      move: ({x}, done) => this.refocus(x, done),
      step: (way) => this.refocus(this.focus() + .05 * way, true),
    };
    this.side.handle("x", "the focal plane", focus);
    this.curve.handle("x", "the focal plane on the curve", focus);
    this.side.handle("point", "a point on the axis", {
      place: () => ({x: this.point ? this.point.distance : 0, y: 0, text: this.point ? `${this.point.text.diameter} pixels` : ""}),
      move: ({x}) => this.choose(this.nearest(x)),
      step: (way) => this.choose(this.rows[this.rows.indexOf(this.point) + way]),
    });
    this.says = make("p", {className: "numbers"});
    box.append(this.side.element, this.curve.element, this.says);
  }
  focus() { return Number(this.figure.args.get("focal-distance")); }
  aperture() { return Number(this.figure.args.get("aperture")) / 1000; }

  asks(args) {
    const lens = new Map(args);
    for (const name of ["debug", "lens-samples", "pixel"]) lens.delete(name);
    return [...lens, ["circles", true]];
  }
  answer({rows}) {
    const number = (row) => ({...Object.fromEntries(Object.entries(row).map(([name, text]) => [name, Number(text)])), text: row});
    this.rows = rows.filter((row) => "distance" in row).map(number);
    this.column = rows.filter((row) => "depth" in row).map(number);
    this.choose(this.nearest(this.point ? this.point.distance : 1.4 * this.focus()));
  }
  follow() { this.draw(); }

  nearest(x) { return this.rows.reduce((best, row) => Math.abs(row.distance - x) < Math.abs(best.distance - x) ? row : best, this.rows[0]); }
  refocus(x, done) {
    const value = Math.round(100 * Math.max(.2, Math.min(x, this.side.x.high))) / 100;
    this.figure.change("focal-distance", value, done);
    this.draw();
  }
  choose(row) {
    if (!row) return;
    this.point = row;
    const {distance, diameter} = row.text;
    this.says.replaceChildren(make("b", {textContent: `A circle of ${diameter} pixels`}), ` around a point at distance ${distance}. `,
      make("span", {className: "two", textContent: "Red"}), " points of the scene are out of focus, ",
      make("span", {className: "one", textContent: "blue"}), " ones are sharp: their circles are at most half a pixel wide.");
    Plot.brief(this.says);
    this.draw();
  }

  draw() {
    if (!this.point) return;
    const {side, curve} = this, far = this.rows[this.rows.length - 1].distance, f = this.focus(), half = this.aperture() / 2;
    const d = this.point.distance, tall = far * 210 / 390 / 2; // one scale for both axes
    for (const plot of [side, curve]) plot.x.high = far;
    Object.assign(side.y, {low: -tall, high: tall});
    curve.y.high = Math.max(2, 2.5 * this.rows[this.rows.length - 1].diameter);
    side.tell(["depth from the lens, world units", "height above the axis, world units", "diameter, pixels"], this.column.map(({depth, height, diameter}) => [depth, height, diameter]));
    const ray = (way, to) => side.line(side.px(0), side.py(way * half), side.px(to), side.py(way * half * (1 - to / d)), "thin");
    const cut = half * (1 - f / d), end = Math.max(f, d);
    side.draw(side.line(side.px(0), side.py(0), side.px(far), side.py(0), "grid"),
      side.node("ellipse", {class: "lens", cx: side.px(0), cy: side.py(0), rx: 4, ry: Math.max(2, Math.abs(side.py(half) - side.py(0)))}),
      ...this.column.map((row) => side.dot(row.depth, row.height, row.diameter > .5 ? "two" : "one", 2)),
      ray(1, end), ray(-1, end), side.line(side.px(f), side.py(cut), side.px(f), side.py(-cut), "thick"),
      side.text(side.px(0) - 6, side.py(0) + 4, "lens", "end"));
    const shown = this.rows.filter((row) => row.diameter <= curve.y.high);
    const points = shown.map((row) => [row.distance, row.diameter]);
    curve.tell(["distance from the lens, world units", "diameter, pixels"], points);
    curve.draw(curve.curve(points),
      ...(d > 0 && this.point.diameter <= curve.y.high ? [curve.dot(d, this.point.diameter, "two", 4.5)] : []));
  }
}
