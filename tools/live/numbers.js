// The numbers that a plot draws, as a table that unfolds below it, to be copied or saved as CSV.
class Numbers {
  constructor(label) {
    this.label = label;
    this.heads = [];
    this.rows = [];
    this.table = make("table", {});
    this.scroller = make("div", {className: "rows", tabIndex: 0}, this.table);
    this.scroller.setAttribute("role", "region");
    this.scroller.setAttribute("aria-label", `the numbers of ${label}`);
    const copy = make("button", {type: "button", textContent: "Copy as CSV"});
    copy.onclick = () => navigator.clipboard.writeText(this.csv()).then(() => { copy.textContent = "Copied as CSV"; });
    const save = make("a", {className: "save", textContent: "Save as CSV", href: "#", download: `${label.replaceAll(/\W+/g, "_")}.csv`});
    save.onclick = () => {
      URL.revokeObjectURL(save.href);
      save.href = URL.createObjectURL(new Blob([this.csv()], {type: "text/csv"}));
    };
    this.copy = copy;
    this.element = make("details", {className: "data", hidden: true}, make("summary", {textContent: "Numbers"}), this.scroller, copy, " ", save);
    this.element.ontoggle = () => this.fill();
  }

  // heads: of the columns, with units. rows: arrays of the values that are drawn.
  show(heads, rows) {
    Object.assign(this, {heads, rows});
    this.element.hidden = rows.length === 0;
    this.copy.textContent = "Copy as CSV";
    this.fill();
  }
  fill() {
    if (!this.element.open) return;
    const line = (tag, cells) => make("tr", {}, ...cells.map((textContent) => make(tag, tag === "th" ? {textContent, scope: "col"} : {textContent})));
    this.table.replaceChildren(make("caption", {textContent: this.label}), make("thead", {}, line("th", this.heads)), make("tbody", {}, ...this.rows.map((row) => line("td", row))));
  }
  csv() {
    const cell = (value) => /[",\n]/.test(value) ? `"${String(value).replaceAll('"', '""')}"` : value;
    return [this.heads, ...this.rows].map((row) => row.map(cell).join(",")).join("\n") + "\n";
  }
}
