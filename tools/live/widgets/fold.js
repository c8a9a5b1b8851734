// The environment as a cross of six faces, which a slider folds to the cube around the viewer; the viewer turns with
// the camera. The faces are cut from the driver's --debug cross.
({make}) => class {
  constructor(figure, box) {
    this.figure = figure;
    this.folded = 0;
    const face = (name, row, column, style) => {
      const element = make("div", {className: "face"});
      element.dataset.name = name;
      Object.assign(element.style, style);
      element.append(make("canvas", {}));
      return Object.assign(element, {row, column});
    };
    // Each face hangs on the edge of another, about which it folds.
    this.back = face("−z", 1, 1, {left: "25cqw", top: "25cqw"});
    this.right = face("+x", 1, 2, {left: "100%", top: "0", transformOrigin: "left"});
    this.front = face("+z", 1, 3, {left: "100%", top: "0", transformOrigin: "left"});
    this.left = face("−x", 1, 0, {right: "100%", top: "0", transformOrigin: "right"});
    this.top = face("+y", 0, 1, {left: "0", bottom: "100%", transformOrigin: "bottom"});
    this.bottom = face("−y", 2, 1, {left: "0", top: "100%", transformOrigin: "top"});
    this.faces = [this.back, this.right, this.front, this.left, this.top, this.bottom];
    this.right.append(this.front);
    this.back.append(this.right, this.left, this.top, this.bottom);
    this.room = make("div", {}, this.back);
    Object.assign(this.room.style, {left: "0", top: "0", width: "100cqw", height: "75cqw", transformOrigin: "37.5% 50%"});
    this.view = make("div", {className: "fold", tabIndex: 0}, make("div", {className: "eye"}, this.room));
    this.view.setAttribute("role", "img");
    this.view.setAttribute("aria-label", "the six faces of the environment");
    this.listen();
    const slider = make("input", {type: "range", min: 0, max: 100, value: 0, name: "fold"});
    slider.id = `fold-${Math.random().toString(36).slice(2)}`;
    slider.oninput = () => {
      this.folded = Number(slider.value) / 100;
      this.draw();
    };
    const label = make("label", {textContent: "fold", htmlFor: slider.id});
    this.says = make("p", {className: "numbers", textContent: "Fold the cross to the cube, then look around in it."});
    box.append(this.view, make("div", {className: "controls"}, label, slider, make("output", {})), this.says);
    this.draw();
  }

  asks(args) {
    const map = new Map(args);
    for (const name of [...map.keys()]) if (!["environment", "environment-filter", "side", "marked"].includes(name)) map.delete(name);
    return [...map, ["debug", "cross"], ["width", 512], ["height", 384]];
  }
  answer({picture}) {
    const size = picture.width / 4, whole = new ImageData(new Uint8ClampedArray(picture.rgba.buffer), picture.width, picture.height);
    for (const {firstChild, row, column} of this.faces) {
      Object.assign(firstChild, {width: size, height: size});
      firstChild.getContext("2d").putImageData(whole, -column * size, -row * size);
    }
  }
  follow() { this.draw(); }

  angle(name) { return Number(this.figure.args.get(name) ?? (this.figure.camera ? this.figure.camera[name] : 0)); }
  // Dragging and arrow keys turn the figure's camera, whose view this is.
  listen() {
    const turn = (yaw, pitch, done) => {
      this.figure.change("yaw", Math.round(10 * yaw) / 10, false);
      this.figure.change("pitch", Math.round(10 * Math.max(-89, Math.min(89, pitch))) / 10, done);
      this.draw();
    };
    let from = null;
    this.view.onpointerdown = (event) => {
      from = {x: event.clientX, y: event.clientY, yaw: this.angle("yaw"), pitch: this.angle("pitch")};
      this.view.setPointerCapture(event.pointerId);
    };
    this.view.onpointermove = (event) => {
      if (from) turn(from.yaw + (event.clientX - from.x) / 3, from.pitch + (event.clientY - from.y) / 3, false);
    };
    this.view.onpointerup = () => {
      if (from) this.figure.changed(true);
      from = null;
    };
    this.view.onpointercancel = () => { from = null; };
    this.view.onkeydown = (event) => {
      const way = {ArrowLeft: [-5, 0], ArrowRight: [5, 0], ArrowUp: [0, -5], ArrowDown: [0, 5]}[event.key];
      if (!way) return;
      event.preventDefault();
      turn(this.angle("yaw") + way[0], this.angle("pitch") + way[1], true);
    };
  }

  draw() {
    const between = (from, to) => Math.max(0, Math.min(1, (this.folded - from) / (to - from)));
    const quarter = 90 * between(0, .6), inside = between(.4, .8), turned = between(.8, 1);
    this.left.style.transform = `rotateY(${quarter}deg)`;
    this.right.style.transform = this.front.style.transform = `rotateY(${-quarter}deg)`;
    this.top.style.transform = `rotateX(${-quarter}deg)`;
    this.bottom.style.transform = `rotateX(${quarter}deg)`;
    // The eye is half the width in front of the page; the cube's middle comes there. The camera of yaw 0 looks along +z.
    const yaw = turned * (180 - this.angle("yaw")), pitch = turned * this.angle("pitch");
    this.room.style.transform = `translateX(${12.5 * inside}cqw) translateZ(${50 * inside}cqw) ` +
      `rotateX(${-pitch}deg) rotateY(${yaw}deg) translateZ(${-12.5 * inside}cqw)`;
  }
}
