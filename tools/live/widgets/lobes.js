// A surface from the side: light and eye are dragged around a point of it, and a polar plot has the light that is
// reflected in each direction: shading --radiance.
({make, Plot}) => class {
  constructor(figure, box) {
    Object.assign(this, {figure, rows: [], eye: 60});
    const margin = {left: 10, right: 10, top: 8, bottom: 26};
    this.plot = new Plot("the radiance that the surface reflects, by direction", {low: -1.2, high: 1.2, hidden: true},
      {low: 0, high: 1.2, hidden: true}, {height: 244, margin});
    const angle = ({x, y}) => Math.atan2(x, y) * 180 / Math.PI;
    this.plot.handle("point", "the light", {
      place: () => ({...this.at(-this.incidence(), 1.1), now: this.incidence(), text: `${this.incidence()} degrees from the normal`}),
      move: (place, done) => this.light(-angle(place), done),
      step: (way) => this.light(this.incidence() - way, true),
      range: [0, 89],
    });
    this.plot.handle("point", "the eye", {
      place: () => ({...this.at(this.eye, 1.1), now: this.eye, text: this.row() ? `${this.eye} degrees: radiance ${this.row().text.radiance}` : ""}),
      move: (place) => this.look(angle(place)),
      step: (way) => this.look(this.eye + .5 * way),
      range: [-90, 90],
    });
    this.says = make("p", {className: "numbers"});
    box.append(this.plot.element, this.says);
  }
  incidence() { return Number(this.figure.args.get("incidence")); }
  row() { return this.rows.find((row) => row.angle === this.eye); }
  // The place at an angle from the normal, to the right; the length is part of the plot's reach.
  at(degrees, length) {
    const angle = degrees * Math.PI / 180, reach = length * this.plot.y.high / 1.2;
    return {x: reach * Math.sin(angle), y: reach * Math.cos(angle)};
  }

  asks(args) { return [...args].filter(([name]) => !["debug", "width", "height"].includes(name)).concat([["radiance", true]]); }
  answer({rows}) {
    this.rows = rows.map((row) => ({...Object.fromEntries(Object.entries(row).map(([name, text]) => [name, Number(text)])), text: row}));
    this.draw();
  }
  follow() { this.draw(); }
  light(degrees, done) {
    this.figure.change("incidence", Math.round(Math.max(0, Math.min(89, degrees))), done);
    this.draw();
  }
  look(degrees) {
    this.eye = Math.round(2 * Math.max(-90, Math.min(90, degrees))) / 2;
    this.draw();
  }

  draw() {
    const {plot} = this, row = this.row();
    if (!row) return;
    const reach = Math.max(1.2, 1.15 * Math.max(...this.rows.map(({radiance}) => radiance)));
    Object.assign(plot.x, {low: -reach, high: reach});
    plot.y.high = reach;
    plot.tell(["angle from the normal, degrees", "radiance", "diffuse", "highlight"], this.rows.map((one) => [one.angle, one.radiance, one.diffuse, one.highlight]));
    const polar = (name) => this.rows.map((one) => [one[name] * Math.sin(one.angle * Math.PI / 180), one[name] * Math.cos(one.angle * Math.PI / 180)]);
    const line = (to, name) => plot.line(plot.px(0), plot.py(0), plot.px(to.x), plot.py(to.y), name);
    const light = this.at(-this.incidence(), 1.1), eye = this.at(this.eye, 1.1), mirror = this.at(this.incidence(), 1.2);
    const [sx, sy] = [Math.sin, Math.cos].map((part) => row.radiance * part(this.eye * Math.PI / 180));
    const word = (to, text) => plot.text(plot.px(to.x) + (to.x < 0 ? -14 : 14), plot.py(to.y) + 4, text, to.x < 0 ? "end" : "start");
    plot.draw(plot.line(plot.px(-reach), plot.py(0), plot.px(reach), plot.py(0), "thin"),
      line({x: 0, y: reach}, "grid"), line(mirror, "grid"), line(light, "thin"), line(eye, "thin"),
      plot.curve(polar("diffuse"), "guide"), plot.curve(polar("radiance"), "one"),
      line({x: sx, y: sy}, "thick"), plot.dot(sx, sy, "two", 4), word(light, "light"), word(eye, "eye"));
    const {radiance, diffuse, highlight} = row.text;
    this.says.replaceChildren(make("b", {textContent: `Radiance ${radiance}`}), ` at ${this.eye}°, with light at ${row.text.incidence}°: diffuse ${diffuse} and highlight ${highlight}.`);
    Plot.brief(this.says);
  }
}
