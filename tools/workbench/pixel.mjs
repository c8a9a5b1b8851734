// A pixel of the pictures: a crosshair that a click or the arrow keys move, the pixel's colours, and how the student's
// code and the kit's come to them, as trees of rays.
import {made} from "./elements.mjs";
import {scrollToMarks, showRayTrees} from "./ray_trees.mjs";
import {printed_in} from "./verdicts.mjs";

const MOVES = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
const FAR = 10; // pixels, with Shift

// What a driver says of a pixel, and before it what the unit has printed. What follows belongs to the whole picture.
function parts_of(text) {
  const [, printed, said] = text.match(/^([^]*?)(pixel \(\d+, \d+\) of [^]*?)(?:\n\n[^]*)?$/) || [text, "", text];
  return {printed, said};
}

export class Pixel {
  #place = [0, 0]; // x and y from the top left, in the student's picture
  #step = null;  // whose picture is shown
  #isView = false;
  #asks = false; // for the pixel's explanation

  // pictures: the element with the canvases {own, wanted}, and a third that is no colour, all of one shape; said: where
  // coordinates and colours stand; explained: where trees do. ask(place) asks for an explanation.
  constructor({pictures, own, wanted, said, explained}, ask) {
    Object.assign(this, {pictures, own, wanted, said, explained, ask});
    for (const canvas of pictures.querySelectorAll("canvas")) {
      canvas.onclick = ({offsetX, offsetY}) => {
        const at = [offsetX / canvas.clientWidth * canvas.width, offsetY / canvas.clientHeight * canvas.height];
        this.aim(at.map(Math.floor), canvas);
      };
      canvas.onkeydown = (event) => {
        if (event.ctrlKey || event.altKey || event.metaKey) return;
        if (MOVES[event.key]) this.#move(this.#place.map((at, axis) => at + MOVES[event.key][axis] * (event.shiftKey ? FAR : 1)));
        else if (event.key === "Enter") this.#explain();
        else return;
        event.preventDefault();
      };
      canvas.onfocus = () => this.#move(this.#place);
    }
  }

  // The pixel of a picture in which the middle of another one's pixel lies.
  #between(from, to, place) {
    const scale = [to.width / from.width, to.height / from.height];
    return place.map((at, axis) => Math.floor((at + 0.5) * scale[axis]));
  }

  // Asks for the explanation of a pixel, of the wanted picture's if that is given.
  aim(place, canvas = this.own) {
    this.#move(this.#between(canvas, this.own, place));
    this.#explain();
  }

  #move(place) {
    const size = [this.own.width, this.own.height];
    this.#place = place.map((at, axis) => Math.max(0, Math.min(size[axis] - 1, at)));
    this.pictures.classList.add("aimed");
    ["--x", "--y"].forEach((name, axis) => this.pictures.style.setProperty(name, `${100 * (this.#place[axis] + 0.5) / size[axis]}%`));
    this.#tell();
  }

  #tell() {
    const colours = [[this.own, "by your code"], [this.wanted, "wanted"]].flatMap(([canvas, whose]) => {
      const rgb = [...canvas.getContext("2d").getImageData(...this.#between(this.own, canvas, this.#place), 1, 1).data].slice(0, 3).join(", ");
      const swatch = made("span", {className: "swatch"});
      swatch.style.background = `rgb(${rgb})`;
      return [`${whose} `, swatch, ` (${rgb})`, ", "];
    });
    this.said.replaceChildren(`Pixel ${this.#place.join()}: `, ...colours.slice(0, -1));
  }

  #explain() {
    this.#asks = true;
    if (this.explained.dataset.of !== this.#place.join()) this.explained.replaceChildren("Explaining the pixel");
    this.ask(this.#place);
  }

  #close() {
    this.#asks = false;
    this.explained.replaceChildren();
    delete this.explained.dataset.of;
    this.pictures.classList.remove("aimed");
    this.said.replaceChildren("Click a pixel of a picture to see how it gets its colour; by keys, arrows aim and Enter asks.");
  }

  // There is another picture, of this step: if it was this step's before, the same pixel is explained again. isView: it
  // shows more than the scene, such as boxes of a tree.
  drawn(step, isView = false) {
    const {width, height} = this.own;
    if (step !== this.#step) {
      this.#place = [width >> 1, height >> 1];
      this.#close();
    } else if (this.pictures.classList.contains("aimed")) {
      this.#tell();
    }
    this.#step = step;
    this.#isView = isView;
    if (this.#asks) this.ask(this.#place);
  }

  // texts: the words of the student's driver, and of the kit's if the site has it.
  // isWritten: false if the unit lacks steps.
  show({pixel, texts, isWritten = true}) {
    if (pixel.join() !== this.#place.join()) return;
    const parts = texts.map(parts_of), [{printed}] = parts;
    showRayTrees(this.explained, parts.map(({said}) => said), ["your code", "the kit's"], isWritten);
    if (!isWritten) this.explained.prepend(made("p", {textContent: "Until all steps are written, the kit's own code stands in for some: the counts are not yours alone."}));
    if (this.#isView) this.explained.prepend(made("p", {textContent: "The picture shows the tree as well. This is how the scene alone gets its colour there."}));
    if (printed) this.explained.append(made("p", {textContent: "Printed by your code until then:"}), printed_in(printed));
    this.explained.prepend(made("button", {textContent: "Close the explanation", onclick: () => this.#close()}));
    const isAgain = this.explained.dataset.of === pixel.join();
    this.explained.dataset.of = pixel.join();
    if (!isAgain) this.explained.scrollIntoView({block: "nearest"});
    scrollToMarks(this.explained);
  }
}
