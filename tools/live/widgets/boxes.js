// The boxes that a pixel's ray tests, drawn one after the other: the steps of bvh_median --debug traversal, each
// beside its line of C.
() => class {
  constructor(figure) {
    this.figure = figure;
    figure.stays = (index) => { // told which step the reader goes to
      if (index !== this.now()) figure.change("steps", index + 1, true);
    };
  }
  now() { return Number(this.figure.args.get("steps")) - 1; }

  follow(args, {printed}, preview) {
    const lines = printed.trimEnd().split("\n").filter((line) => !/^\S+\.png: /.test(line));
    if (preview || lines.join("\n") === this.printed) return;
    this.figure.element.dataset.ready = "yes";
    this.printed = lines.join("\n");
    this.figure.tell(lines, this.now());
  }
}
