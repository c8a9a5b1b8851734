// The histogram of the picture's luminance, and the threshold as a line over it, to be dragged: the numbers of
// bloom --histogram.
({make, Plot}) => class {
  constructor(figure, box) {
    this.figure = figure;
    this.bins = [];
    this.plot = new Plot("how many pixels have which luminance", {low: 1 / 64, high: 16, log: true, label: "luminance", ticks: [.1, 1, 10]},
      {low: .5, high: 1e6, log: true, label: "pixels"}, {height: 250, margin: {left: 56, right: 10, top: 8, bottom: 34}});
    this.plot.handle("x", "the threshold", {
      place: () => ({x: Math.max(this.plot.x.low, this.threshold()), now: this.threshold(),
        text: `${this.threshold()}, ${this.bright ? this.bright.bright : 0} bright pixels`}),
      move: ({x}, done) => this.choose(x, done),
      step: (way) => this.choose(this.threshold() * 2 ** (way / 8), true),
    });
    this.says = make("p", {className: "numbers"});
    box.append(this.plot.element, this.says);
  }
  threshold() { return Number(this.figure.args.get("bloom-threshold")); }

  // Of the picture without bloom, so neither radius nor intensity matters.
  asks(args) {
    return [...args].filter(([name]) => !["debug", "bloom-radius", "bloom-intensity", "pixel"].includes(name)).concat([["histogram", true]]);
  }
  answer({rows}) {
    this.bins = rows.filter((row) => "bin" in row).map(({low, high, pixels}) => ({low: Number(low), high: Number(high), pixels: Number(pixels)}));
    this.bright = rows.find((row) => "bright" in row);
    const {threshold, bright, pixels, most} = this.bright;
    this.says.replaceChildren(make("b", {textContent: `${bright} of ${pixels} pixels`}), ` have a luminance of at least ${threshold}: `,
      make("span", {className: "two", textContent: "they have halos"}), `. The brightest has ${most}.`);
    Plot.brief(this.says);
    this.draw();
  }
  follow() { this.draw(); }

  choose(x, done) {
    const {low, high} = this.plot.x;
    this.figure.change("bloom-threshold", Number(Math.max(low, Math.min(high, x)).toPrecision(3)), done);
    this.draw();
  }

  draw() {
    const {plot} = this, top = Math.max(10, ...this.bins.map((bin) => bin.pixels)), line = this.threshold();
    plot.y.high = 10 ** Math.ceil(Math.log10(top));
    plot.tell(["luminance from", "luminance to", "pixels"], this.bins.map(({low, high, pixels}) => [low, high, pixels]));
    const bar = (name, from, to, pixels) => plot.node("rect", {class: name, x: plot.px(from), width: Math.max(0, plot.px(to) - plot.px(from) - .6),
      y: plot.py(pixels), height: plot.py(plot.y.low) - plot.py(pixels)});
    plot.draw(...this.bins.filter((bin) => bin.pixels).flatMap(({low, high, pixels}) => high <= line ? [bar("plain", low, high, pixels)]
      : low >= line ? [bar("full", low, high, pixels)] : [bar("plain", low, line, pixels), bar("full", line, high, pixels)]));
  }
}
