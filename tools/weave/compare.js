// A row of two pictures of equal size becomes one, with a slider between them, their difference, and pixels
// enlarged in step. Differences are made by blending and SVG filters, which work on pictures from files as
// well, whose pixels a script may not read. Without it, and in print, the pictures stand side by side.
"use strict";
(() => {
  const make = (name, attributes, ...children) => {
    const element = document.createElement(name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    element.append(...children);
    return element;
  };
  const rows = [...document.querySelectorAll(".row.compare")];
  if (!rows.length) return;

  // The mean of the channels' differences, times eight, as colours: black, blue, red, yellow, white.
  document.body.insertAdjacentHTML("beforeend", `<svg width="0" height="0" class="filters" aria-hidden="true">
    <filter id="false-colours" color-interpolation-filters="sRGB">
    <feColorMatrix values="2.667 2.667 2.667 0 0  2.667 2.667 2.667 0 0  2.667 2.667 2.667 0 0  0 0 0 1 0"/>
    <feComponentTransfer><feFuncR type="table" tableValues="0 0.1 0.85 1 1"/>
    <feFuncG type="table" tableValues="0 0.2 0.15 0.85 1"/><feFuncB type="table" tableValues="0 0.9 0.25 0 1"/>
    </feComponentTransfer></filter></svg>`);

  const modes = { slider: "slider", beside: "side by side", difference: "difference × 8", colours: "error in colours" };
  const notes = {
    difference: "Black where the pictures are equal; differences are eight times as bright.",
    colours: "Black where the pictures are equal.",
  };
  const magnification = 8;

  // The bar of the false colours, as pictures of the drivers have one.
  const bar = () => make("div", { class: "scale" },
    make("span", { class: "ramp", style: "background: linear-gradient(to right, #000, rgb(26, 51, 230), rgb(217, 38, 64), rgb(255, 217, 0), #fff)" }),
    make("span", { class: "ticks" }, ...[0, 8, 16, 24, 32].map((value, i) =>
      make("span", { class: "tick", style: `--place: ${i / 4}` }, i < 4 ? String(value) : `${value} and more`))),
    make("span", { class: "unit" }, "mean difference of red, green and blue, of 255"));

  const start = (row) => {
    const [first, second] = row.querySelectorAll("figure img");
    if (!second) return; // a student's unit could not draw it
    const name = (image) => image.closest("figure").querySelector(".number")?.textContent ?? "";
    const layer = (image) => { // with its labels, or the part of it that is shown
      const copy = (image.closest(".labelled") ?? image.closest(".crop") ?? image).cloneNode(true);
      for (const copied of [copy, ...copy.querySelectorAll("img")]) if (copied.alt) copied.alt = "";
      return make("div", { class: "layer" }, copy);
    };
    const stack = make("div", { class: "stack" }, layer(second), layer(first));
    const range = make("input", { type: "range", min: 0, max: 100, value: 50,
      "aria-label": `Border between ${name(first) || "the left"} and ${name(second) || "the right picture"}` });
    const note = make("p", { class: "note", role: "status" });
    const buttons = Object.entries(modes).map(([mode, text]) => {
      const button = make("button", { type: "button" }, text);
      button.addEventListener("click", () => choose(mode));
      return [mode, button];
    });
    const zoom = make("button", { type: "button", "aria-pressed": "false" }, `zoom × ${magnification}`);
    const sides = make("p", { class: "sides" }, make("span", {}, "← " + name(first)),
      make("span", {}, name(second) + " →"));
    const label = `Compare ${name(first)} and ${name(second)}`;
    const comparison = make("div", { class: "comparison", role: "group", "aria-label": label }, stack, range,
      sides, make("div", { class: "modes" }, ...buttons.map(([, button]) => button), zoom), note, bar());

    const choose = (mode) => {
      comparison.dataset.mode = mode;
      row.classList.toggle("compared", mode !== "beside");
      for (const [key, button] of buttons) button.setAttribute("aria-pressed", key === mode);
      note.textContent = notes[mode] ?? "";
      zoom.disabled = mode === "beside";
    };
    const move = () => stack.style.setProperty("--border", range.value + "%");
    range.addEventListener("input", move);

    // Enlarged around a place given as parts of width and height.
    let at;
    const look = (x, y) => {
      at = [x, y].map((part) => Math.min(1, Math.max(0, part)));
      stack.style.setProperty("--place", at.map((part) => `${100 * part}%`).join(" "));
    };
    const enlarge = (on) => {
      zoom.setAttribute("aria-pressed", on);
      stack.classList.toggle("enlarged", on);
    };
    const place = (event) => {
      const box = stack.getBoundingClientRect();
      return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
    };
    const isOn = () => stack.classList.contains("enlarged");
    zoom.addEventListener("click", () => enlarge(!isOn()));
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    zoom.addEventListener("keydown", (event) => {
      const step = isOn() && steps[event.key];
      if (!step) return;
      event.preventDefault();
      look(at[0] + step[0] / 20, at[1] + step[1] / 20);
    });
    stack.addEventListener("click", (event) => {
      look(...place(event));
      enlarge(!isOn());
    });
    stack.addEventListener("pointermove", (event) => {
      if (isOn() && event.pointerType === "mouse") look(...place(event));
    });

    row.prepend(comparison);
    look(0.5, 0.5);
    move();
    choose("slider");
  };
  rows.forEach(start);
})();
