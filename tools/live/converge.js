// A live figure converges while nobody touches it: its picture becomes the mean of pictures that differ in their seed
// alone, each of them the driver's (mean.c). It stops at a number of samples, out of sight, and by a button, and anything
// new ends it. Where the reader chooses the number of samples, the noise of that many is to be seen, and it begins by the
// button. A picture that no seed changes is left as it is.
class Converging {
  static PAUSE = 500; // ms after the last touch
  static MOST = 256; // samples per pixel

  // Not of pictures that tell of something else, or that a widget draws with more samples itself.
  static suits(figure) {
    const views = figure.offers.find(({name}) => name === "debug");
    return !(figure.widget && figure.widget.part.tell) && (!figure.args.has("debug") || Boolean(views && views.limits && views.limits.split("|").includes("")));
  }

  constructor(figure) {
    this.figure = figure;
    this.shown = 0; // pictures in the mean that is seen
    this.pictures = 0; // and in the one that is kept; 0: nothing to go on from
    this.pressed = null; // true: the reader wants it to go on, false: to stop
    this.inSight = false;
    this.still = matchMedia("(prefers-reduced-motion: reduce)");
    this.says = make("span", {});
    this.button = make("button", {type: "button", onclick: () => this.press()});
    this.element = make("p", {className: "converging"}, this.says, " ", this.button);
    this.end();
    new IntersectionObserver((entries) => {
      this.inSight = entries[entries.length - 1].isIntersecting;
      this.wait();
    }).observe(figure.canvas);
    document.addEventListener("visibilitychange", () => this.wait());
  }
  goes() { return this.pressed ?? !(this.still.matches || this.control()); }

  // The control that has the number of samples, if there is one.
  control() {
    const {offers, args} = this.figure;
    return offers.find((one) => /(^|-)samples$|^glossy$/.test(one.name) && goesWith(one, args));
  }
  // The samples of a picture, in the control's words.
  count() {
    const {rows, args} = this.figure, name = (this.control() || {name: "samples"}).name;
    return {samples: Math.max(1, Number(args.get(name) ?? rows[name].value)), name: name === "glossy" ? "glossy rays" : name.replace("-", " ")};
  }

  // After the first picture of new options.
  begin({mean}) {
    this.end();
    if (!mean || this.figure.args.get("debug")) return;
    const {samples} = this.count();
    this.shown = this.pictures = 1;
    this.most = Math.ceil(Converging.MOST / samples);
    this.wait();
  }
  end() {
    clearTimeout(this.timer);
    this.pictures = 0;
    this.element.style.visibility = "hidden";
  }

  press() {
    this.pressed = !this.goes();
    this.tell();
    this.wait();
  }
  tell() {
    const {samples, name} = this.count(), left = this.shown < this.most;
    this.says.textContent = `${this.shown * samples} of ${this.most * samples} ${name}${this.shown > 1 ? `, by ${this.shown} seeds` : ""}`;
    this.button.textContent = this.goes() && left ? "Stop" : "Go on";
    this.button.disabled = !left;
    this.element.style.visibility = "visible";
  }

  // Whether there is noise is known after the second picture, which is drawn in any case, and is seen if it may go on.
  wait() {
    clearTimeout(this.timer);
    const wanted = this.pictures > 0 && this.pictures < this.most && (this.goes() || this.pictures === 1);
    if (wanted && this.inSight && !document.hidden) this.timer = setTimeout(() => this.go(), this.pictures === 1 ? Converging.PAUSE : 0);
  }
  async go() {
    const {figure, pictures} = this;
    if (figure.busy || figure.wanted || !figure.done) return; // and then waits again
    const result = await figure.add(Number(figure.args.get("seed") || 0) + pictures);
    if (!result) return;
    const {mean} = result, goesOn = this.pictures === pictures && mean && mean.pictures === pictures + 1 && mean.differ;
    if (!goesOn) this.end();
    else {
      this.pictures++;
      if (this.goes()) {
        this.shown = this.pictures;
        figure.draw(result.picture);
      }
      this.tell();
    }
    figure.goOn();
  }
}
