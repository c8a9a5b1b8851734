// A plot that answers: SVG in the page's colours, and handles that are dragged, or moved by arrow keys.
(make) => class Plot {
  // label: for readers of screens. x, y: {low, high, log, label, ticks}. size: of the plot's own units, text is 11 of them high.
  constructor(label, x, y, {width = 440, height = 230, margin = {left: 46, right: 10, top: 8, bottom: 34}} = {}) {
    Object.assign(this, {x, y, width, height, margin});
    this.axes = this.node("g", {class: "axes"});
    this.content = this.node("g", {});
    this.handles = this.node("g", {});
    this.element = this.node("svg", {viewBox: `0 0 ${width} ${height}`, role: "group", "aria-label": label},
      this.axes, this.content, this.handles);
  }
  node(tag, attributes, ...children) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }

  // Shortens a text's numbers to four digits; all of them stay in their value.
  static brief(element) {
    const walker = document.createTreeWalker(element, NodeFilter.SHOW_TEXT), texts = [];
    while (walker.nextNode()) texts.push(walker.currentNode);
    for (const text of texts) {
      text.replaceWith(...text.data.split(/(-?\d+\.\d{4,}(?:e[-+]?\d+)?)/).map((part, i) => i % 2 === 0 ? part
        : make("data", {value: part, textContent: String(Number(Number(part).toPrecision(4)))})));
    }
  }

  // --- values and places ---
  part(axis, value) {
    const {low, high, log} = axis;
    return log ? Math.log(Math.max(value, low * 1e-3) / low) / Math.log(high / low) : (value - low) / (high - low);
  }
  value(axis, part) {
    const {low, high, log} = axis, inside = Math.max(0, Math.min(1, part));
    return log ? low * (high / low) ** inside : low + (high - low) * inside;
  }
  px(value) { return this.margin.left + this.part(this.x, value) * (this.width - this.margin.left - this.margin.right); }
  py(value) { return this.height - this.margin.bottom - this.part(this.y, value) * (this.height - this.margin.top - this.margin.bottom); }
  // The values under a pointer, at the nearest place inside the axes.
  at(event) {
    const box = this.element.getBoundingClientRect(), {left, right, top, bottom} = this.margin;
    const x = (event.clientX - box.left) / box.width * this.width, y = (event.clientY - box.top) / box.height * this.height;
    return {x: this.value(this.x, (x - left) / (this.width - left - right)),
      y: this.value(this.y, (this.height - bottom - y) / (this.height - top - bottom))};
  }

  // --- drawing ---
  ticks({low, high, log, ticks}) {
    if (ticks) return ticks;
    if (log) {
      const list = [];
      for (let power = Math.ceil(Math.log10(low) - 1e-9); 10 ** power <= high * 1.000001; power++) list.push(Number(`1e${power}`));
      return list;
    }
    const rough = (high - low) / 5, unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((k) => k * unit).find((size) => size >= rough), list = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(Number((k * step).toPrecision(6)));
    return list;
  }
  text(x, y, words, anchor = "middle", more = {}) {
    return this.node("text", {x, y, "text-anchor": anchor, ...more}, String(words));
  }
  line(x1, y1, x2, y2, name = "") { return this.node("line", {x1, y1, x2, y2, class: name}); }
  drawAxes() {
    const {left, right, top, bottom} = this.margin, floor = this.height - bottom, wall = this.width - right;
    const power = (value) => `10${[...String(Math.round(Math.log10(value)))].map((digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹⁻".charAt("0123456789-".indexOf(digit))).join("")}`;
    const short = (value) => value >= 1e4 && /^10*$/.test(value) ? power(value) : value;
    this.axes.replaceChildren(
      ...(this.x.hidden ? [] : this.ticks(this.x).flatMap((value) => [this.line(this.px(value), top, this.px(value), floor, "grid"),
        this.text(this.px(value), floor + 13, short(value))])),
      ...(this.y.hidden ? [] : this.ticks(this.y).flatMap((value) => [this.line(left, this.py(value), wall, this.py(value), "grid"),
        this.text(left - 5, this.py(value) + 4, short(value), "end")])),
      ...(this.x.label ? [this.text((left + wall) / 2, this.height - 5, this.x.label)] : []),
      ...(this.y.label ? [this.text(0, 0, this.y.label, "middle", {transform: `translate(11 ${(top + floor) / 2}) rotate(-90)`})] : []));
  }
  // points: [x, y] each.
  curve(points, name = "") {
    return this.node("polyline", {class: `curve ${name}`, points: points.map(([x, y]) => `${this.px(x)},${this.py(y)}`).join(" ")});
  }
  dot(x, y, name = "one", r = 3.5) { return this.node("circle", {cx: this.px(x), cy: this.py(y), r, class: `dot ${name}`}); }
  draw(...nodes) {
    this.drawAxes();
    this.content.replaceChildren(...nodes);
    for (const handle of this.handles.children) handle.place();
  }

  // For the table below the plot: column heads with units, and the values that are drawn, row by row.
  tell(heads, rows) { if (this.numbers) this.numbers.show(heads, rows); }

  // A line across the plot ("x": upright, "y": level), or a "point". place() returns its values {x, y, text}, text for
  // readers of screens; move({x, y}, done) is told where it is dragged; step(way, done) by how much a key moves it.
  handle(kind, label, {place, move, step, range = [0, 1]}) {
    const {left, right, top, bottom} = this.margin;
    const shapes = kind === "point"
      ? [this.node("circle", {r: 14, class: "reach"}), this.node("circle", {r: 6, class: "knob"})]
      : [this.node("line", {class: "reach"}), this.node("line", {class: "bar"}), this.node("circle", {r: 5.5, class: "knob"})];
    const handle = this.node("g", {class: `handle ${kind}`, tabindex: 0, role: "slider", "aria-label": label,
      "aria-valuemin": range[0], "aria-valuemax": range[1]}, ...shapes);
    handle.place = () => {
      const {x, y, now, text} = place();
      const cx = this.px(x ?? this.x.low), cy = this.py(y ?? this.y.low);
      for (const shape of shapes)
        if (shape.tagName === "line") {
          const ends = kind === "x" ? {x1: cx, x2: cx, y1: top, y2: this.height - bottom} : {x1: left, x2: this.width - right, y1: cy, y2: cy};
          Object.entries(ends).forEach(([name, value]) => shape.setAttribute(name, value));
        } else {
          shape.setAttribute("cx", kind === "y" ? this.width - right - 8 : cx);
          shape.setAttribute("cy", kind === "x" ? top + 8 : cy);
        }
      handle.setAttribute("aria-valuenow", now ?? (kind === "y" ? y : x));
      handle.setAttribute("aria-valuetext", text);
    };
    let held = false;
    handle.onpointerdown = (event) => {
      held = true;
      handle.setPointerCapture(event.pointerId);
      handle.focus();
      event.preventDefault();
    };
    handle.onpointermove = (event) => { if (held) move(this.at(event), false); };
    handle.onpointerup = (event) => {
      if (held) move(this.at(event), true);
      held = false;
    };
    handle.onpointercancel = () => { held = false; };
    handle.onkeydown = (event) => {
      const way = {ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1}[event.key];
      if (!way) return;
      event.preventDefault();
      step(way, event.key === "ArrowUp" || event.key === "ArrowDown");
    };
    this.handles.append(handle);
    return handle;
  }
}
