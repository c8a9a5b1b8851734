// The rays of an explained pixel as lines over its picture, from where the driver's --pixel-rays says that they are.
class PixelRays {
  static KINDS = {shadow: "shadow ray, reaches the light", occluded: "shadow ray, does not reach it", reflected: "reflected ray"};

  constructor() {
    this.element = PixelRays.node("svg", {class: "rays", preserveAspectRatio: "none", "aria-hidden": "true"});
    this.legend = make("p", {className: "legend"});
    this.hide();
  }
  static node(tag, attributes, ...children) {
    const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
    node.append(...children);
    return node;
  }
  // On a dark line, so that it is seen on any picture.
  static line(kind, x1, y1, x2, y2) {
    return ["under ", ""].map((under) => PixelRays.node("line", {class: under + kind, x1, y1, x2, y2}));
  }

  // lines: with those that begin with @; camera rays are points, which the page marks.
  show(lines, {width, height}) {
    const rays = lines.filter((line) => line.startsWith("@ ")).map((line) => line.slice(2).split(" "));
    const kinds = Object.keys(PixelRays.KINDS), seen = kinds.filter((kind) => rays.some((ray) => ray[0] === kind));
    this.element.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.element.replaceChildren(...kinds.flatMap((kind) => rays.filter((ray) => ray[0] === kind)).flatMap((ray) => PixelRays.line(...ray)));
    this.legend.replaceChildren(...seen.map((kind) => make("span", {},
      PixelRays.node("svg", {viewBox: "0 0 32 12", "aria-hidden": "true"}, ...PixelRays.line(kind, 2, 6, 30, 6)), PixelRays.KINDS[kind])));
  }
  hide() {
    this.element.replaceChildren();
    this.legend.replaceChildren();
  }
}
