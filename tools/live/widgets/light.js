// The lamp from above, to be moved and resized, and the error of its light as samples are added: the pictures of
// parallelogram_light --growth, each shown as it is drawn.
({make, Plot}) => class {
  constructor(figure, box) {
    Object.assign(this, {figure, points: [], earlier: [], now: null});
    this.plan = new Plot("the room from above", {low: 0, high: 1, hidden: true}, {low: 0, high: 1, hidden: true},
      {height: 200, margin: {left: 126, right: 126, top: 6, bottom: 6}});
    this.plan.handle("point", "the lamp's middle", {
      place: () => ({...this.middle(), text: `moved by ${this.given("lamp-x", 0)} and ${this.given("lamp-z", 0)}`, now: this.given("lamp-x", 0)}),
      move: ({x, y}, done) => this.move(x - this.rest.x, y - this.rest.y, done),
      step: (way, upright) => this.move(this.given("lamp-x", 0) - (upright ? 0 : .05 * way), this.given("lamp-z", 0) + (upright ? .05 * way : 0), true),
    });
    this.plan.handle("point", "the lamp's size", {
      place: () => ({...this.corner(), text: `${this.given("lamp-size", 1)} times its size`, now: this.given("lamp-size", 1)}),
      move: ({x, y}, done) => {
        const {x: mx, y: my} = this.middle();
        this.resize(Math.max(Math.abs(x - mx) / this.half.x, Math.abs(y - my) / this.half.y), done);
      },
      step: (way) => this.resize(this.given("lamp-size", 1) + .1 * way, true),
    });
    this.error = new Plot("the error by the number of samples", {low: 1, high: 64, log: true, ticks: [1, 2, 4, 8, 16, 32, 64], label: "samples on the light"},
      {low: 1e-3, high: .3, log: true, label: "error"}, {height: 210});
    this.error.handle("x", "the number of samples shown", {
      place: () => ({x: this.given("light-samples", 1), text: `${this.given("light-samples", 1)} samples`}),
      move: ({x}) => this.choose(this.points.reduce((best, point) =>
        Math.abs(Math.log(point.samples / x)) < Math.abs(Math.log(best.samples / x)) ? point : best, this.points[0])),
      step: (way) => this.choose(this.points[this.points.findIndex(({samples}) => samples === this.given("light-samples", 1)) + way]),
    });
    this.says = make("p", {className: "numbers"});
    this.says.setAttribute("role", "status");
    box.append(this.plan.element, this.error.element, this.says);
    this.rest = {x: 0, y: 0};
    this.half = {x: .1, y: .1};
  }
  given(name, usual) { return Number(this.figure.args.get(name) ?? usual); }

  asks(args) {
    const growth = new Map(args);
    for (const name of ["light-samples", "debug", "pixel"]) growth.delete(name);
    return [...growth, ["growth", true], ["most", 64], ["reference", 512]];
  }
  begin() {
    this.earlier = this.points;
    this.points = [];
    this.says.textContent = "A reference of 512 samples is drawn in the background …";
    this.draw();
  }
  tell({row, picture}) {
    if (picture) this.picture = picture;
    else if ("light" in row) this.place(row);
    else {
      this.points.push({samples: Number(row.samples), rmse: Number(row.rmse), row, picture: this.picture});
      this.choose(this.points[this.points.length - 1]);
    }
  }

  // Where the lamp would be without --lamp-x and others, and half its sides; plans have z upwards, as y.
  place(row) {
    const number = (name) => Number(row[name]), size = this.given("lamp-size", 1);
    const across = {x: number("edge01_x") + number("edge02_x"), y: number("edge01_z") + number("edge02_z")};
    this.half = {x: Math.abs(across.x) / 2 / size, y: Math.abs(across.y) / 2 / size};
    this.rest = {x: number("x") + across.x / 2 - this.given("lamp-x", 0), y: number("z") + across.y / 2 - this.given("lamp-z", 0)};
    Object.assign(this.plan.x, {low: number("high_x"), high: number("low_x")}); // as the camera sees it, x grows to the left
    Object.assign(this.plan.y, {low: number("low_z"), high: number("high_z")});
    this.draw();
  }
  middle() { return {x: this.rest.x + this.given("lamp-x", 0), y: this.rest.y + this.given("lamp-z", 0)}; }
  corner() {
    const {x, y} = this.middle(), size = this.given("lamp-size", 1);
    return {x: x - size * this.half.x, y: y + size * this.half.y};
  }
  round(value) { return Math.round(100 * value) / 100; }
  move(x, z, done) {
    this.figure.change("lamp-x", this.round(Math.max(-.4, Math.min(.4, x))), false);
    this.figure.change("lamp-z", this.round(Math.max(-.4, Math.min(.4, z))), done);
    this.draw();
  }
  resize(size, done) {
    this.figure.change("lamp-size", this.round(Math.max(.1, Math.min(3, size))), done);
    this.draw();
  }
  choose(point) {
    if (!point || !this.figure.take("light-samples", point.samples, point.picture)) return;
    this.now = point;
    this.says.replaceChildren(make("b", {textContent: `${point.row.samples} ${point.samples === 1 ? "sample" : "samples"}`}),
      `: error ${point.row.rmse}, the root of the mean square over all channels, by ${point.row.shadow_rays} shadow rays`);
    Plot.brief(this.says);
    this.draw();
  }
  follow() { this.draw(); }

  draw() {
    const {plan, error} = this, a = this.corner(), m = this.middle(), b = {x: 2 * m.x - a.x, y: 2 * m.y - a.y};
    const rectangle = (name, x1, y1, x2, y2) => plan.node("rect", {class: name, x: Math.min(plan.px(x1), plan.px(x2)), y: Math.min(plan.py(y1), plan.py(y2)),
      width: Math.abs(plan.px(x2) - plan.px(x1)), height: Math.abs(plan.py(y2) - plan.py(y1))});
    plan.draw(rectangle("room", plan.x.low, plan.y.low, plan.x.high, plan.y.high), rectangle("lamp", a.x, a.y, b.x, b.y),
      plan.text(plan.px(plan.x.high) + 8, plan.py(plan.y.high) + 14, "the back wall", "start"),
      plan.text(plan.px(plan.x.high) + 8, plan.py(plan.y.low) - 6, "the camera's side", "start"));
    const curve = (points) => points.map((point) => [point.samples, point.rmse]);
    const guide = this.points.length ? [1, 64].map((samples) => [samples, this.points[0].rmse / Math.sqrt(samples)]) : [];
    const rows = (lamp, points) => curve(points).map((point) => [lamp, ...point]);
    error.tell(["lamp", "samples on the light", "error, RMSE of radiance"], [...rows("now", this.points), ...rows("before it was moved", this.earlier)]);
    error.draw(...(guide.length ? [error.curve(guide, "guide"), error.text(error.px(64) - 4, error.py(guide[1][1]) - 6, "1/√N", "end")] : []),
      error.curve(curve(this.earlier), "plain"), error.curve(curve(this.points), "one"),
      ...this.points.map((point) => error.dot(point.samples, point.rmse, "one", point === this.now ? 5 : 3)));
  }
}
