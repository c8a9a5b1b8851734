// The path of the first moving object, and the time in which the shutter is open: its ends are dragged, or a point along the
// path, which moves both. Positions and bounds are those of motion_blur --positions.
({make, Plot}) => class {
  constructor(figure, box) {
    Object.assign(this, {figure, path: [], shutter: null});
    this.plot = new Plot("the path of the moving object", {low: -.2, high: .5, label: "time, and displacement along x, to the left in the picture"},
      {low: -.5, high: .5, label: "displacement upwards"}, {height: 250});
    const end = (name, label) => this.plot.handle("x", label, {
      place: () => ({x: this.time(name), text: `at ${this.time(name)}`}),
      move: ({x}, done) => this.open({[name]: x}, name, done),
      step: (way) => this.open({[name]: this.time(name) + .01 * way}, name, true),
    });
    end("shutter-open", "when the shutter opens");
    end("shutter-close", "when the shutter closes");
    this.plot.handle("point", "the middle of that time, on the path", {
      place: () => ({x: this.middle(), y: this.height(this.middle()), text: `at ${this.middle()}`}),
      move: ({x}, done) => this.shift(x - this.middle(), done),
      step: (way) => this.shift(.01 * way, true),
    });
    this.says = make("p", {className: "numbers"});
    box.append(this.plot.element, this.says);
  }
  time(name) { return Number(this.figure.args.get(name)); }
  middle() { return (this.time("shutter-open") + this.time("shutter-close")) / 2; }
  // On the path, for the handle: between two of its points.
  height(x) {
    const right = this.path.findIndex((row) => row.time >= x);
    if (right <= 0) return this.path.length ? this.path[0].y : 0;
    const [a, b] = [this.path[right - 1], this.path[right]];
    return a.y + (b.y - a.y) * (x - a.time) / (b.time - a.time);
  }

  asks(args) { return [...args].filter(([name]) => name === "scene" || name.startsWith("shutter")).concat([["positions", true]]); }
  answer({rows}) {
    this.path = rows.filter((row) => row.object === "0" && "time" in row).map(({time, x, y}) => ({time: Number(time), x: Number(x), y: Number(y)}));
    this.shutter = rows.find((row) => row.object === "0" && "open" in row);
    this.draw();
  }
  follow() { this.draw(); }

  shift(by, done) {
    const {low, high} = this.plot.x, ends = ["shutter-open", "shutter-close"].map((name) => this.time(name));
    const inside = Math.max(low - ends[0], Math.min(high - ends[1], by));
    this.open({"shutter-open": ends[0] + inside, "shutter-close": ends[1] + inside}, "", done);
  }
  // The end that moves takes the other one along.
  open(ends, moved, done) {
    const round = (x) => Math.round(1000 * Math.max(this.plot.x.low, Math.min(this.plot.x.high, x))) / 1000;
    const open = round(ends["shutter-open"] ?? this.time("shutter-open")), close = round(ends["shutter-close"] ?? this.time("shutter-close"));
    this.figure.change("shutter-open", moved === "shutter-close" ? Math.min(open, close) : open, false);
    this.figure.change("shutter-close", moved === "shutter-open" ? Math.max(open, close) : close, done);
    this.draw();
  }

  draw() {
    const {plot, shutter} = this, open = this.time("shutter-open"), close = this.time("shutter-close");
    if (!shutter) return;
    const heights = this.path.map((row) => row.y), number = (name) => Number(shutter[name]);
    Object.assign(plot.y, {low: Math.min(...heights) - .05, high: Math.max(...heights) + .05});
    const rectangle = (name, x1, y1, x2, y2) => plot.node("rect", {class: name, x: plot.px(x1), y: plot.py(y2),
      width: Math.max(1, plot.px(x2) - plot.px(x1)), height: Math.max(1, plot.py(y1) - plot.py(y2))});
    const during = this.path.filter((row) => row.time >= open && row.time <= close).map((row) => [row.x, row.y]);
    plot.tell(["time", "displacement along x, world units", "displacement upwards, world units"], this.path.map((row) => [row.time, row.x, row.y]));
    plot.draw(rectangle("span", open, plot.y.low, close, plot.y.high), plot.curve(this.path.map((row) => [row.x, row.y])),
      plot.curve([[open, this.height(open)], ...during, [close, this.height(close)]], "one"),
      ...(open < close ? [rectangle("box", number("low_x"), number("low_y"), number("high_x"), number("high_y"))] : []));
    const place = (end) => `(${shutter[`${end}_x`]}, ${shutter[`${end}_y`]})`;
    this.says.replaceChildren(...(shutter.open === shutter.close
      ? [make("b", {textContent: "One time"}), `, ${shutter.open}: the first object is displaced by ${place("from")}. Drag an end away to open the shutter for longer.`]
      : [make("b", {textContent: `Open from ${shutter.open} to ${shutter.close}`}), `: the first object is displaced from ${place("from")} to ${place("to")}, within the red bounds.`]));
    Plot.brief(this.says);
  }
}
