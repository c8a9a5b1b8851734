// Live figures: controls for a driver's options, and pictures that it draws here. The page holds the driver's own
// picture; this replaces it when the reader comes near, and if anything is missing, the picture stays.
// modules: WebAssembly by driver, compressed, in base64; kit is that of all others. worker: source of a worker.
// widgets: parts that only one chapter's figure has (widgets/*.js), by name. steps: the code of the steps that explain
// a pixel, by "FILE, FUNCTION: LINE", as --pixel-code names them.
(modules, worker, widgets, steps) => {
  const style = `
    .live { --gap: 1.2rem; }
    .live .stage { display: grid; grid-template-columns: repeat(auto-fit, minmax(15rem, 1fr)); gap: var(--gap); align-items: start; }
    .live .screen { position: relative; }
    .live .below { margin-top: var(--gap); }
    @media (max-width: 36rem) { .live .left { display: contents; } .live .below { order: 1; margin: 0; } }
    .live .scale { margin-bottom: .6rem; }
    .live canvas { display: block; width: 100%; border-radius: 3px; touch-action: pan-y; cursor: grab; }
    .live canvas.still { cursor: crosshair; }
    .live canvas:focus-visible { outline: 2px solid var(--link); outline-offset: 2px; }
    .live .mark { position: absolute; width: 13px; height: 13px; margin: -7px 0 0 -7px; border: 1px solid #fff; outline: 1px solid #000; pointer-events: none; }
    .live .rays { position: absolute; inset: 0; width: 100%; height: 100%; overflow: hidden; pointer-events: none; }
    .live .rays line, .live .legend line { stroke-width: 2; stroke-linecap: round; vector-effect: non-scaling-stroke; }
    .live line.reflected { stroke: #fff; }
    .live line.shadow { stroke: #4da3ff; }
    .live line.occluded { stroke: #ff9a2e; }
    .live .screen line.under, .live .legend line.under { stroke: #000; stroke-width: 4; opacity: .55; }
    .live line.occluded:not(.under) { stroke-dasharray: 5 5; }
    .live .legend { font: .75rem/1.4 "Helvetica Neue", "Arial", sans-serif; color: var(--soft); margin: .4rem 0 0; display: flex; flex-wrap: wrap; gap: 0 1rem; }
    .live .legend:empty { display: none; }
    .live .legend svg { width: 2rem; height: .8rem; vertical-align: middle; margin-right: .35rem; }
    .live .controls { color-scheme: light dark; display: grid; grid-template-columns: auto minmax(5rem, 1fr) 4.5em; gap: .4rem .7rem; align-items: center; font: .78rem/1.3 "Helvetica Neue", "Arial", sans-serif; }
    .live .controls input, .live .controls select { width: 100%; margin: 0; font: inherit; }
    .live .controls input[type=checkbox] { width: auto; justify-self: start; }
    .live .controls select { grid-column: 2 / 4; }
    .live .controls .off { opacity: .45; }
    .live .controls output.off { visibility: hidden; }
    .live output { text-align: right; font-variant-numeric: tabular-nums; }
    .live .line { display: flex; gap: .6rem; align-items: baseline; margin-top: .9rem; }
    .live .line code { flex: 1; overflow-wrap: anywhere; font-size: .72rem; background: var(--panel); padding: .25rem .5rem; border-radius: 3px; }
    .live .line span { white-space: nowrap; }
    .live button { font: .75rem "Helvetica Neue", "Arial", sans-serif; color: var(--ink); background: var(--panel); border: 1px solid var(--line); border-radius: 3px; padding: .15rem .5rem; cursor: pointer; }
    .live .story { margin-top: .8rem; font: .75rem/1.4 "Helvetica Neue", "Arial", sans-serif; }
    .live .story pre { white-space: pre-wrap; overflow-wrap: anywhere; margin: .4rem 0 0; max-height: 15rem; overflow: auto; font-size: .68rem; line-height: 1.45; padding: .5rem 0; }
    .live .story pre span { display: block; padding: 0 .7rem; }
    .live .story .place { color: var(--soft); }
    .live .story .code .now { box-shadow: inset 3px 0 var(--link); }
    .live .story pre span.now { background: var(--line); }
    .live .converging { font: .75rem/1.4 "Helvetica Neue", "Arial", sans-serif; color: var(--soft); margin: .4rem 0 0; }
    .live .says { font: .75rem/1.4 "Helvetica Neue", "Arial", sans-serif; color: var(--soft); margin: .5rem 0 0; }
    .live .widget { --one: #2b7bd6; --two: #d6453d; font: .78rem/1.4 "Helvetica Neue", "Arial", sans-serif; margin-bottom: 1rem; }
    .live .widget svg { display: block; width: 100%; height: auto; overflow: visible; }
    .live .widget text { font-size: 11px; fill: var(--soft); }
    .live .widget p { margin: .3rem 0; min-height: 2.8em; }
    .live .widget b { font-weight: 600; }
    .live .widget .grid { stroke: var(--line); }
    .live .widget .room { fill: var(--panel); stroke: var(--soft); }
    .live .widget .lamp { fill: #f2c84b; stroke: var(--ink); }
    .live .widget .curve { fill: none; stroke-width: 2; stroke: var(--soft); }
    .live .widget .thin { stroke: var(--soft); stroke-width: 1; }
    .live .widget .thick { stroke: var(--two); stroke-width: 4; }
    .live .widget .lens { fill: var(--one); opacity: .6; }
    .live .widget rect.box { fill: none; stroke: var(--two); stroke-width: 1.5; }
    .live .widget rect.full { fill: var(--two); }
    .live .widget rect.span { fill: var(--one); opacity: .2; }
    .live .widget .curve.guide { stroke-dasharray: 4 4; stroke-width: 1; }
    .live .widget .curve.plain { opacity: .5; }
    .live .widget rect.one, .live .widget rect.two { opacity: .35; }
    .live .widget .dot.plain, .live .widget rect.plain { fill: var(--soft); }
    .live .widget .dot.least { fill: none; stroke: var(--ink); stroke-width: 1.5; }
    .live .widget .one { fill: var(--one); }
    .live .widget .two { fill: var(--two); }
    .live .widget .curve.one, .live .widget line.one { fill: none; stroke: var(--one); }
    .live .widget .curve.two, .live .widget line.two { fill: none; stroke: var(--two); }
    .live .widget span.one { border-bottom: 3px solid var(--one); }
    .live .widget span.two { border-bottom: 3px solid var(--two); }
    .live .fold { position: relative; overflow: hidden; aspect-ratio: 4 / 3; border-radius: 3px; background: #000; container-type: inline-size; margin-bottom: .6rem; touch-action: pan-y; cursor: grab; }
    .live .fold:focus-visible { outline: 2px solid var(--link); outline-offset: 2px; }
    .live .fold div { position: absolute; transform-style: preserve-3d; width: 25cqw; height: 25cqw; }
    .live .fold .eye { inset: 0; width: auto; height: auto; perspective: 50cqw; transform-style: flat; }
    .live .fold .face canvas { width: 100%; height: 100%; border-radius: 0; cursor: inherit; }
    .live .fold .face::after { content: attr(data-name); position: absolute; left: 4px; top: 2px; font-weight: 600; color: #fff; text-shadow: 0 0 2px #000, 0 0 2px #000; }
    .live .data { margin: .2rem 0 .8rem; }
    .live .data .rows { max-height: 15rem; overflow: auto; margin: .4rem 0; }
    .live .data table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
    .live .data caption { text-align: left; color: var(--soft); }
    .live .data th, .live .data td { text-align: right; padding: .1rem .8rem .1rem 0; font-weight: 400; }
    .live .data th { border-bottom: 1px solid var(--line); vertical-align: bottom; }
    .live .data .save { margin-left: .5rem; }
    .live .handle { cursor: grab; touch-action: none; outline: none; }
    .live .handle .reach { stroke: transparent; stroke-width: 24; fill: transparent; }
    .live .handle .bar { stroke: var(--ink); stroke-width: 1.5; }
    .live .handle .knob { fill: var(--paper); stroke: var(--ink); stroke-width: 1.5; }
    .live .handle:focus-visible .knob { stroke: var(--link); stroke-width: 3; }
    @media (pointer: coarse) {
      .live button { min-width: 2.6rem; min-height: 2.5rem; }
      .live .controls input[type=range], .live .controls select { height: 2.4rem; }
      .live .controls input[type=checkbox] { width: 1.5rem; height: 1.5rem; }
      .live .story pre span { padding-top: .2rem; padding-bottom: .2rem; }
    }
    @media print { .live .handle, .live .widget button { display: none; } }
    @media print { .live .controls, .live .line button, .live .mark { display: none; } }`;

  // --- the module, unpacked and compiled once ---------------------------------------------------

  const compiled = new Map();
  const compile = (name) => compiled.get(name) || compiled.set(name, (async () => {
    const packed = Uint8Array.from(atob(modules[name]), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return {
      module: await WebAssembly.compile(await new Response(stream).arrayBuffer()),
      source: URL.createObjectURL(new Blob([worker], {type: "text/javascript"})),
    };
  })()).get(name);

  // One run at a time; it is ended after a while, because a student's unit may not end.
  const PATIENCE = 30; // seconds
  class Runner {
    constructor(kit) {
      this.kit = kit;
      this.next = 0;
    }
    run(args, tell = null, part = "begins") { // tell(part): rows and pictures while the driver runs; part: see run.js
      return new Promise((resolve, reject) => {
        if (!this.worker) {
          this.worker = new Worker(this.kit.source);
          this.worker.postMessage({module: this.kit.module});
        }
        const id = ++this.next;
        const wait = () => {
          clearTimeout(this.limit);
          this.limit = setTimeout(() => {
            this.stop();
            resolve({status: 3, printed: "", rows: [], said: `no picture within ${PATIENCE} seconds`, picture: null, mean: null, finish: null});
          }, 1000 * PATIENCE);
        };
        wait();
        this.worker.onmessage = ({data}) => {
          if (data.id !== id) return;
          if (data.part) {
            wait();
            return tell(data);
          }
          clearTimeout(this.limit);
          resolve(data);
        };
        this.worker.onerror = (event) => reject(new Error(event.message));
        this.worker.postMessage({id, args, tells: tell !== null, part});
      });
    }
    stop() { // a promise that waits for it stays open, and is forgotten
      clearTimeout(this.limit);
      if (this.worker) this.worker.terminate();
      this.worker = null;
    }
  }

  // --- controls ---------------------------------------------------------------------------------

  // A slider's 0 to 1000 and a number; over two decades or more it is logarithmic.
  function scale(low, high, whole) {
    const logarithmic = low > 0 && high / low >= 100;
    const round = (x) => whole ? Math.round(x) : Number(x.toPrecision(3));
    return {
      value: (at) => round(logarithmic ? low * (high / low) ** (at / 1000) : low + (high - low) * at / 1000),
      at: (value) => 1000 * (logarithmic ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low)),
    };
  }

  // The label, the control and the value of one option; changed(value, done): null stands for the default.
  function control({name, limits, views}, rows, args, changed) {
    const row = rows[name];
    const given = args.has(name) ? args.get(name) : row.value;
    const label = make("label", {textContent: name.replaceAll("-", " "), title: row.help});
    if (views) label.title += `; goes with debug ${views.map((view) => view || "none").join(" or ")}`;
    const finish = (element) => {
      element.name = name;
      element.title = label.title;
      label.htmlFor = element.id = `live-${++control.count}`;
      return element;
    };
    if (row.kind === "flag") {
      const box = finish(make("input", {type: "checkbox", checked: Boolean(given)}));
      box.onchange = () => changed(name, box.checked || null, true);
      return [label, box, make("output", {})];
    }
    if (row.kind !== "uint" && row.kind !== "float") {
      const values = new Set(limits !== undefined ? limits.split("|") : row.names).add(given || "");
      const list = finish(make("select", {}, ...[...values].map((value) =>
        make("option", {value, textContent: value || "none", selected: value === (given || "")}))));
      list.onchange = () => changed(name, list.value || null, true);
      return [label, list];
    }
    const [low, high] = limits ? limits.split("..").map(Number) : [row.low, row.high];
    const on = scale(low, high, row.kind === "uint");
    const shown = make("output", {textContent: given === null ? "own" : given});
    const slider = finish(make("input", {type: "range", min: 0, max: 1000, step: "any", value: on.at(Number(given))}));
    const move = (done) => {
      shown.textContent = on.value(Number(slider.value));
      changed(name, shown.textContent, done);
    };
    slider.oninput = () => move(false);
    slider.onchange = () => move(true);
    slider.onkeydown = (event) => { // steps that are seen
      const way = {ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1}[event.key];
      if (!way) return;
      event.preventDefault();
      const old = on.value(Number(slider.value));
      do slider.value = Number(slider.value) + 10 * way;
      while (on.value(Number(slider.value)) === old && slider.value > 0 && slider.value < 1000);
      move(true);
    };
    return [label, slider, shown];
  }
  control.count = 0;

  // --- a widget: it asks the driver for numbers of its own, in a worker of its own, and shows them ------------------

  // A widget has asks(args), the options of a run that puts tables, null for none; answer(result), or tell(part) for
  // each row and picture of a long run; and follow(args, result, preview), after each picture of the figure.
  class Widget {
    constructor(figure, kit, name) {
      this.figure = figure;
      this.runner = new Runner(kit);
      this.box = make("div", {className: "widget"});
      this.part = new (widgets[name]({make, Plot}))(figure, this.box);
      for (const plot of Object.values(this.part).filter((one) => Plot && one instanceof Plot)) {
        plot.numbers = new Numbers(plot.element.getAttribute("aria-label"));
        plot.element.after(plot.numbers.element);
      }
    }
    // Once per change of what it asks. A short answer is awaited first; a long run, which tells its parts, is ended.
    async ask() {
      const asked = this.part.asks ? this.part.asks(this.figure.args) : null;
      const args = asked && this.figure.wordsOf(new Map(asked));
      if (!args || args.join(" ") === this.asked) return;
      if (this.waits && !this.part.tell) return;
      if (this.waits) this.runner.stop();
      this.asked = args.join(" ");
      this.waits = true;
      if (this.part.begin) this.part.begin();
      const now = this.asked, tell = this.part.tell && ((part) => this.asked === now && this.part.tell(part));
      const result = await this.runner.run([this.figure.driver, ...args], tell);
      if (this.asked !== now) return;
      this.waits = false;
      if (result.status !== 0) this.figure.says.textContent = result.said;
      else if (this.part.answer) this.part.answer(result);
      this.figure.element.dataset.answered = this.asked;
      this.ask();
    }
  }
  const Plot = widgets.plot && widgets.plot(make);

  // --- one figure -------------------------------------------------------------------------------

  class Figure {
    constructor(element) {
      this.element = element;
      this.driver = element.dataset.driver;
      this.args = parseArguments(element.dataset.args);
      this.wanted = null; // {args, preview} that waits for the runner
      this.busy = null;   // the one that runs
      this.stays = null;  // where the steps of a pixel stay beside its picture: who is told which one is read
      this.clicked = null; // a pixel that waits for the runner
      this.lasts = 0;     // ms of the last full picture
      this.done = true;   // false while something is dragged
    }

    async start() {
      const kit = await compile(this.driver in modules ? this.driver : "kit");
      this.runner = new Runner(kit);
      const help = await this.runner.run([this.driver, "--help"]);
      this.rows = JSON.parse(help.printed);
      this.offers = this.element.dataset.options.split(/\s+/).map((word) => parseOffer(word, this.rows));
      const first = await this.runner.run([this.driver, ...this.wordsOf(this.args)]);
      if (first.status !== 0) throw new Error(first.said);
      this.camera = first.finish;
      if (this.element.dataset.widget) this.widget = new Widget(this, kit, this.element.dataset.widget);
      this.build();
      this.show(first, {preview: false, args: new Map(this.args)});
    }

    // What the driver is given: no options of other views.
    wordsOf(args) {
      return wordsOf(belonging(args, this.offers, this.rows));
    }

    // The controls of the present options; those of other views cannot be moved.
    offer() {
      this.controls.replaceChildren(...this.offers.flatMap((offer) => {
        const parts = control(offer, this.rows, this.args, (...change) => this.change(...change));
        parts[1].dataset.views = offer.views ? offer.views.join("|") : "all";
        return parts;
      }));
      this.grey();
    }

    grey() {
      const parts = [...this.controls.children];
      parts.forEach((part, i) => {
        const control = part.matches("label") ? parts[i + 1] : part.matches("output") ? parts[i - 1] : part;
        const off = control.dataset.views !== "all" && !control.dataset.views.split("|").includes(this.args.get("debug") || "");
        part.classList.toggle("off", off);
        if (part === control) part.disabled = off;
      });
    }

    reset() {
      this.args = parseArguments(this.element.dataset.args);
      this.offer();
      this.changed(true);
    }

    build() {
      const image = this.element.querySelector("img");
      this.canvas = make("canvas", {tabIndex: 0});
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", image.alt);
      this.mark = make("div", {className: "mark", hidden: true});
      this.controls = make("div", {className: "controls"});
      this.offer();
      this.steps = make("pre", {tabIndex: 0});
      this.steps.setAttribute("aria-label", "how the pixel gets its colour");
      this.code = make("pre", {tabIndex: 0, className: "code"});
      this.code.setAttribute("aria-label", "the code of this step");
      const step = (way, textContent, title) => make("button", {type: "button", textContent, title, onclick: () => this.step(way)});
      this.story = make("div", {className: "story", hidden: true}, step(-1, "◀", "the step before"), " ",
        step(1, "▶", "the next step"), " one step after the other, and its code", this.steps, this.code);
      this.command = make("code", {className: "command"});
      const copy = make("button", {type: "button", textContent: "Copy", title: "copy the command"});
      copy.onclick = () => navigator.clipboard.writeText(this.command.textContent).then(() => { copy.textContent = "Copied"; });
      this.says = make("p", {className: "says"});
      const reset = make("button", {type: "button", textContent: "Reset", title: "the options as they were", onclick: () => this.reset()});
      this.rays = new PixelRays();
      const screen = make("div", {}, make("div", {className: "screen"}, this.canvas, this.rays.element, this.mark), this.rays.legend);
      this.converging = Converging.suits(this) ? new Converging(this) : null;
      if (this.converging) screen.append(this.converging.element);
      this.bar = make("div", {className: "scale", hidden: true});
      const below = [this.bar, this.controls, make("div", {className: "line"}, this.command, copy, reset), this.says];
      image.replaceWith(make("div", {className: "stage"}, ...(this.widget
        ? [make("div", {className: "left"}, screen, make("div", {className: "below"}, ...below)), make("div", {}, this.widget.box, ...(this.stays ? [this.story] : []))]
        : [screen, make("div", {}, ...below)])), ...(this.stays ? [] : [this.story]));
      this.element.closest(".picture").querySelectorAll(".parameters").forEach((old) => old.remove());
      this.listen();
    }

    // Dragging turns the camera about its target; arrow keys do, too. A click asks about a pixel.
    listen() {
      const canvas = this.canvas, drags = this.element.dataset.drag !== "no", clicks = this.element.dataset.click !== "no";
      canvas.classList.toggle("still", !drags);
      let from = null, moved = false;
      const turn = (yaw, pitch, done) => {
        this.args.set("yaw", Math.round(yaw * 10) / 10);
        this.args.set("pitch", Math.round(Math.max(-89, Math.min(89, pitch)) * 10) / 10);
        this.changed(done);
      };
      const at = (name) => Number(this.args.has(name) ? this.args.get(name) : this.camera[name]);
      canvas.onpointerdown = (event) => {
        from = {x: event.clientX, y: event.clientY, yaw: at("yaw"), pitch: at("pitch")};
        moved = false;
        canvas.setPointerCapture(event.pointerId);
      };
      canvas.onpointermove = (event) => {
        if (!from || !drags) return;
        const x = event.clientX - from.x, y = event.clientY - from.y;
        moved = moved || Math.hypot(x, y) > 4;
        if (moved) turn(from.yaw + x / 2, from.pitch + y / 2, false);
      };
      canvas.onpointerup = (event) => {
        if (from && moved) this.changed(true);
        else if (from && clicks) this.ask(event);
        from = null;
      };
      canvas.onpointercancel = () => { from = null; };
      canvas.onkeydown = (event) => {
        const way = {ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5]}[event.key];
        if (!way || !drags) return;
        event.preventDefault();
        turn(at("yaw") + way[0], at("pitch") + way[1], true);
      };
    }

    change(name, value, done) {
      if (value === null) this.args.delete(name);
      else this.args.set(name, value);
      this.changed(done);
    }

    changed(done) {
      this.story.hidden = !this.stays;
      this.mark.hidden = true;
      this.rays.hide();
      this.clicked = null;
      this.done = done;
      if (this.converging) this.converging.end();
      this.grey();
      const args = new Map(this.args);
      const preview = !done && this.lasts > 200;
      if (preview) { // so small that it takes about 100 ms
        const part = Math.max(1 / 8, Math.sqrt(100 / this.lasts));
        for (const side of ["width", "height"]) args.set(side, Math.max(1, Math.round(part * args.get(side))));
        if (args.has("pixel")) args.set("pixel", args.get("pixel").split(",").map((x) => Math.floor(x * part)).join());
      }
      this.wanted = {args, preview};
      this.print();
      this.work();
    }

    // Takes a picture of the present options and this one, which a widget has; false while another is drawn.
    take(name, value, picture) {
      if (this.busy) return false;
      this.args.set(name, String(value));
      this.print();
      this.draw(picture);
      this.element.dataset.drawn = this.wordsOf(this.args).join(" ");
      return true;
    }

    // A newer job waits for a short one, and ends a long one.
    async work() {
      if (this.busy && (this.busy.preview || this.lasts < 200)) return;
      if (this.busy) this.runner.stop();
      while (this.wanted) {
        const job = this.busy = this.wanted;
        this.wanted = null;
        const result = await this.runner.run([this.driver, ...this.wordsOf(job.args)]);
        if (this.busy !== job) return;
        this.show(result, job);
      }
      this.goOn();
    }

    // What came while something else was drawn.
    goOn() {
      this.busy = null;
      if (this.wanted) this.work();
      else if (this.clicked) this.explain(this.clicked);
      else if (this.converging) this.converging.wait();
    }

    // Adds a picture of another seed to the mean; null if something newer has come.
    async add(seed) {
      const job = this.busy = {preview: false};
      const result = await this.runner.run([this.driver, ...this.wordsOf(new Map([...this.args, ["seed", seed]]))], null, "adds");
      return this.busy === job ? result : null;
    }

    print() {
      const parts = this.wordsOf(this.args).join(" ").split(/ (?=--)/); // an option and its value stay on one line
      this.command.replaceChildren(this.element.dataset.program, ...parts.flatMap((part) => [" ", make("span", {textContent: part})]));
    }

    show(result, job) {
      this.print();
      if (this.widget && (this.done || !this.widget.part.tell)) this.widget.ask(); // also of a picture that failed: a widget may know better options
      if (result.status !== 0) {
        this.says.textContent = result.said;
        return;
      }
      if (!job.preview && this.converging) this.converging.begin(result);
      if (!job.preview) this.lasts = result.ms;
      if (result.finish) this.camera = result.finish;
      if (result.picture) this.draw(result.picture);
      this.showScale(result.scale);
      const {width, height} = result.picture || {};
      const {drag, click} = this.element.dataset;
      const told = click === "draw" && !this.widget ? result.printed.split("\n").filter((line) => line && !/^\S+\.png: /.test(line)).join(" ") : "";
      this.says.textContent = `${told && told + ". "}${width} x ${height} pixels, drawn here in ${result.ms.toFixed(0)} ms by one thread. ` +
        (drag === "no" ? "" : "Drag the picture to turn the camera. ") + (click === "no" ? "" : click === "draw" ?
        "Click a pixel to see its rays." : "Click a pixel to see how it gets its colour.");
      if (!job.preview) this.element.dataset.drawn = this.wordsOf(job.args).join(" ");
      if (this.widget && this.widget.part.follow) this.widget.part.follow(this.args, result, job.preview);
    }

    // The bar of false colours, as the weaver draws it below a still figure (pictures.lua).
    showScale(text) {
      const [, marks, colours, unit] = text.match(/^([^#]*) (#[#\da-f ]*) ([^#]*)$/) || [];
      this.bar.hidden = !marks;
      if (!marks) return;
      const ramp = make("span", {className: "ramp"}), ticks = make("span", {className: "ticks"});
      ramp.style.background = `linear-gradient(to right, ${colours.replaceAll(" ", ", ")})`;
      for (const mark of marks.split(" ")) {
        const [value, place] = mark.split("@");
        const tick = make("span", {className: "tick", textContent: value.replace(/^-/, "−").replace(/\+$/, " and more")});
        tick.style.setProperty("--place", place);
        ticks.append(tick);
      }
      this.bar.replaceChildren(ramp, ticks, make("span", {className: "unit", textContent: unit}));
    }

    draw({width, height, rgba}) {
      Object.assign(this.canvas, {width, height});
      this.canvas.getContext("2d").putImageData(new ImageData(new Uint8ClampedArray(rgba.buffer), width, height), 0, 0);
    }

    // The driver's own explanation, each ray and light a step; click=draw draws the pixel's rays instead.
    ask(event) {
      const box = this.canvas.getBoundingClientRect();
      const place = [(event.clientX - box.left) / box.width * this.canvas.width,
        (event.clientY - box.top) / box.height * this.canvas.height].map(Math.floor);
      if (this.element.dataset.click === "draw" && this.args.has("debug")) return this.change("pixel", place.join(), true);
      this.explain(place);
    }

    async explain(place) {
      this.clicked = this.busy ? place : null;
      if (this.busy) return;
      const job = this.busy = {preview: false};
      const args = new Map([...this.args, ["pixel", place.join()], ["pixel-code", true], ["pixel-rays", true]]);
      args.delete("debug");
      const result = await this.runner.run([this.driver, ...this.wordsOf(args)], null, "leaves");
      if (this.busy !== job) return;
      const said = result.status === 0 ? result.printed.split("\n").filter((line) => !/^\S+\.png: /.test(line)).join("\n") : result.said;
      const lines = said.trimEnd().split("\n");
      this.tell(lines.filter((line) => !line.startsWith("@ ")));
      this.rays.show(lines, this.canvas);
      this.mark.hidden = false;
      Object.assign(this.mark.style, {left: `${100 * (place[0] + .5) / this.canvas.width}%`, top: `${100 * (place[1] + .5) / this.canvas.height}%`});
      this.element.dataset.explained = place.join();
      this.goOn();
    }

    // Shows these lines as steps, and the first of them, or another one.
    tell(lines, now = 0) {
      this.steps.replaceChildren(...this.stepsOf(lines));
      this.story.hidden = false;
      this.go(this.steps.children[Math.min(now, this.steps.children.length - 1)]);
    }

    // A line "# FILE, FUNCTION: LINE" begins a step, and so does one where deeper ones follow.
    stepsOf(lines) {
      const parts = [], indent = (line = "") => line.search(/\S/), deeper = (i) => indent(lines.slice(i + 1).find((line) => !line.startsWith("# "))) > indent(lines[i]);
      lines.forEach((line, i) => {
        const last = parts[parts.length - 1];
        if (line.startsWith("# ")) parts.push({code: line.slice(2), lines: []});
        else if (last && (last.lines.length === 0 || (indent(line) > 0 && !deeper(i)))) last.lines.push(line);
        else parts.push({code: "", lines: [line]});
      });
      return parts.map(({code, lines: texts}) => {
        const step = make("span", {textContent: texts.join("\n")});
        step.dataset.code = code;
        step.onclick = () => this.go(step);
        return step;
      });
    }

    step(way) {
      const all = [...this.steps.children], now = all.findIndex((step) => step.className === "now");
      this.go(all[Math.max(0, Math.min(all.length - 1, now + way))]);
    }

    go(now) {
      for (const step of this.steps.children) step.className = step === now ? "now" : "";
      this.steps.scrollTop = now.offsetTop - this.steps.offsetTop - 20;
      if (this.stays) this.stays([...this.steps.children].indexOf(now));
      const code = steps[now.dataset.code];
      this.code.hidden = !code;
      if (!code) return;
      this.code.replaceChildren(make("span", {className: "place", textContent: (this.driver in modules ? "the kit's " : "") + now.dataset.code.split(":")[0]}),
        ...code.text.split("\n").map((line, i) => make("span", {className: i === code.now ? "now" : "", textContent: `${String(code.numbers[i]).padStart(4)}  ${line}`})));
      this.code.scrollTop = this.code.children[code.now + 1].offsetTop - this.code.offsetTop - 60;
    }
  }

  // --- the page ---------------------------------------------------------------------------------

  if (!window.WebAssembly || !window.Worker || !window.DecompressionStream || !window.IntersectionObserver) return;
  document.head.append(make("style", {textContent: style}));
  const near = new IntersectionObserver((entries) => entries.filter((entry) => entry.isIntersecting).forEach(({target}) => {
    near.unobserve(target);
    new Figure(target).start().catch((error) => console.warn(`live figure ${target.dataset.driver}: ${error.message}`));
  }), {rootMargin: "300px"});
  document.querySelectorAll(".live").forEach((element) => near.observe(element));
};
