// Figures that go step by step: what a unit's variables held after each line that it ran, noted by gdb
// (steps/trace.py), drawn one after the other beside the code. A prediction is asked before what it is about.
//
// views, by figure, draw the states of one algorithm each, and run none (steps/FIGURE.js). Of what is noted once and the
// states each makes: style, its rules; height, of the picture; draw(k), the nodes after k steps; names, the values that are
// listed; strides, by name whether a step of that size ends at k; and questions, by k: text, choices, the right one, and
// the k at which that is seen.
({make, Plot}, views) => {
  const STYLE = `
    .replay { --one: #1f69bd; --two: #c2352d; --three: #c98a00; font: .78rem/1.4 "Helvetica Neue", "Arial", sans-serif; }
    .replay .stage { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(20rem, 100%), 1fr)); gap: 1.2rem; align-items: start; }
    .replay svg { display: block; width: 100%; height: auto; }
    .replay text { font-size: 11px; fill: var(--ink); }
    .replay text.soft { fill: var(--soft); }
    .replay .line { stroke: var(--soft); }
    .replay .guide { stroke: var(--soft); stroke-dasharray: 4 4; }
    .replay text.strong { font-weight: 700; }
    .replay .box { fill: none; stroke: var(--line); }
    .replay .box.now { stroke: var(--one); stroke-width: 2; fill: var(--one); fill-opacity: .12; }
    .replay .box.waits { stroke: var(--two); stroke-width: 1.5; }
    .replay .choice { cursor: pointer; }
    .replay .controls { display: flex; flex-wrap: wrap; gap: .4rem; align-items: center; margin: .5rem 0; color-scheme: light dark; }
    .replay .controls input { flex: 1 1 9rem; min-width: 6rem; margin: 0; }
    .replay button, .replay select { font: inherit; color: var(--ink); background: var(--panel); border: 1px solid var(--soft); border-radius: 3px; padding: .15rem .55rem; cursor: pointer; }
    .replay button:disabled { opacity: .5; cursor: default; }
    .replay fieldset { border: 1px solid var(--link); border-radius: 4px; margin: .5rem 0; padding: .4rem .7rem .6rem; }
    .replay fieldset p { margin: 0 0 .4rem; }
    .replay fieldset legend { font-weight: 600; }
    .replay fieldset button { margin: 0 .4rem .3rem 0; }
    .replay .values { display: flex; flex-wrap: wrap; gap: .1rem 1rem; margin: .4rem 0; min-height: 2.8em; font-variant-numeric: tabular-nums; }
    .replay .values div { display: flex; gap: .35rem; }
    .replay .values dt { color: var(--soft); font-family: monospace; }
    .replay .values dd { margin: 0; }
    .replay .values .changed dd { font-weight: 700; text-decoration: underline; }
    .replay pre { white-space: pre-wrap; overflow-wrap: anywhere; margin: 0; max-height: 27rem; overflow: auto; font-size: .68rem; line-height: 1.5; padding: .5rem 0; }
    .replay pre span { display: block; padding: 0 .7rem 0 3.6rem; text-indent: -2.9rem; }
    .replay pre .place { color: var(--soft); }
    .replay pre .now { background: var(--line); box-shadow: inset 3px 0 var(--link); }
    .replay details { margin-top: .6rem; }
    @media (max-width: 36rem) { .replay pre { max-height: 16rem; } }
    @media (pointer: coarse) { .replay button, .replay select, .replay .controls input { min-height: 2.5rem; min-width: 2.5rem; } }
    @media print { .replay .controls, .replay fieldset { display: none; } }`;

  const short = (value) => typeof value === "number" && !Number.isInteger(value) ? String(Number(value.toPrecision(4))) : value === "inf" ? "∞" : String(value);
  const nth = (n) => `${n}${[, "st", "nd", "rd"][n % 100 > 10 && n % 100 < 14 ? 0 : n % 10] || "th"}`;
  const after = (state, changed) => { // NAME@K is entry K of an array
    const next = {...state};
    for (const [name, value] of Object.entries(changed)) {
      const [whole, k] = name.split("@");
      next[whole] = k === undefined ? value : Object.assign([...next[whole]], {[k]: value});
    }
    return next;
  };
  const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

  class Steps {
    constructor(element) {
      const data = JSON.parse(element.querySelector("script").textContent);
      Object.assign(this, {element, code: data.code, now: 0, timer: null, answers: new Map()});
      const figure = data.trace;
      this.lines = [null];
      this.states = [figure.begin];
      for (const [name, line, changed] of figure.steps) {
        if (!data.code.length && Object.keys(changed).length === 0) continue; // the code is the reader's to write
        this.lines.push({name, line});
        this.states.push(after(this.states[this.states.length - 1], changed));
      }
      this.plot = new Plot("", {low: 0, high: 1, hidden: true}, {low: 0, high: 1, hidden: true});
      this.view = views[element.dataset.figure](figure, this.states, this.plot, {short, nth, lines: this.lines});
      this.build();
      this.go([...this.view.questions.keys()][0] || 0);
      element.dataset.ready = "yes";
    }

    build() {
      const {plot, view} = this, last = this.states.length - 1;
      plot.element.setAttribute("viewBox", `0 0 440 ${view.height}`);
      plot.element.setAttribute("role", "img");
      const button = (textContent, title, onclick) => make("button", {type: "button", textContent, title, ariaLabel: title, onclick});
      this.back = button("◀", "the step before", () => this.step(-1));
      this.next = button("▶", "the next step", () => this.step(1));
      this.player = button("Play", "play", () => this.timer ? this.pause() : this.play());
      this.stride = make("select", {ariaLabel: "what a step is"}, ...Object.keys(view.strides).map((name) => make("option", {value: name, textContent: `by ${name}`})));
      this.time = make("input", {type: "range", min: 0, max: last, step: 1, ariaLabel: "the line that has run"});
      this.time.oninput = () => { this.pause(); this.go(Number(this.time.value)); };
      this.question = make("fieldset", {hidden: true});
      this.values = make("dl", {className: "values"});
      this.says = make("p", {className: "says"});
      this.says.setAttribute("role", "status");
      const left = make("div", {}, plot.element, this.values, make("div", {className: "controls"}, this.back, this.next, this.player, this.stride, this.time), this.says, this.question);
      const still = make("details", {}, make("summary", {textContent: "as a table"}), ...this.element.querySelectorAll("table"));
      this.element.replaceChildren(make("div", {className: "stage"}, left, ...(this.code.length ? [this.listing()] : [])), still);
    }

    listing() {
      this.rows = new Map();
      this.pre = make("pre", {tabIndex: 0}, ...this.code.flatMap(({name, numbers, text}, j) => [
        make("span", {className: "place", textContent: j ? " " : this.element.dataset.file}),
        ...text.split("\n").map((line, i) => {
          const row = make("span", {textContent: `${String(numbers[i]).padStart(4)}  ${line.replace(/^ {17,}/, "        ")}`});
          this.rows.set(numbers[i], row);
          return row;
        })]));
      this.pre.setAttribute("aria-label", "the code");
      return this.pre;
    }

    // --- time ---
    step(way) {
      const {states, view} = this, ends = view.strides[this.stride.value], last = states.length - 1;
      this.pause();
      let k = Math.max(0, Math.min(last, this.now + way));
      while (k > 0 && k < last && !ends(k) && !(way > 0 && this.open(k))) k += way;
      this.go(k);
    }
    open(k) { return this.view.questions.has(k) && !this.answers.has(k); } // a question without an answer
    play(until = this.states.length - 1) {
      const next = () => {
        const {states, view} = this, ends = view.strides[this.stride.value];
        let k = this.now + 1;
        while (k < until && !ends(k) && !this.open(k)) k++;
        this.go(Math.min(k, until));
        if (this.now >= until || this.open(this.now) || this.now === states.length - 1) this.pause();
      };
      if (this.now === this.states.length - 1) this.go(0);
      this.pause();
      this.timer = setInterval(next, 350);
      this.player.textContent = "Pause";
      this.player.ariaLabel = this.player.title = "pause";
    }
    pause() {
      clearInterval(this.timer);
      this.timer = null;
      this.player.textContent = "Play";
      this.player.ariaLabel = this.player.title = "play";
    }

    // --- what is shown ---
    go(k) {
      this.now = k;
      this.back.disabled = k === 0;
      this.next.disabled = k === this.states.length - 1;
      this.time.value = k;
      this.draw();
      this.ask();
      const {line} = this.lines[k] || {}, row = this.rows && this.rows.get(line);
      if (this.rows) for (const other of this.rows.values()) other.className = other === row ? "now" : "";
      if (row) this.pre.scrollTop = Math.min(Math.max(this.pre.scrollTop, row.offsetTop - this.pre.offsetTop - this.pre.clientHeight + 40), row.offsetTop - this.pre.offsetTop - 40);
      const ran = row ? `line ${line} has run: ${row.textContent.trim().replace(/^\d+ +/, "")}` : "";
      this.says.textContent = k === 0 ? "Nothing has run yet." : `Step ${k} of ${this.states.length - 1}${ran && ", " + ran}`;
      this.time.ariaValueText = `${this.says.textContent} ${this.values.textContent}`;
      this.element.dataset.now = k;
    }

    draw() {
      const k = this.now, question = this.view.questions.get(k), options = question && this.open(k) ? question.options || [] : [];
      const choose = (n) => options.includes(n) ? () => this.answer(options.indexOf(n)) : null;
      this.plot.content.replaceChildren(...this.view.draw(k, choose));
      const shown = (value) => value && typeof value === "object" ? short(value.t) : short(value);
      const rows = this.view.names.filter((name) => this.states[k][name] != null).map((name) => make("div", {
        className: k && !same(this.states[k][name], this.states[k - 1][name]) ? "changed" : ""},
      make("dt", {textContent: this.states[k][name].t === undefined ? name : `${name}.t`}), make("dd", {textContent: shown(this.states[k][name])})));
      this.values.replaceChildren(...rows);
      this.plot.element.setAttribute("aria-label", `${this.view.label}; ${rows.map((row) => [...row.children].map((part) => part.textContent).join(" ")).join(", ")}`);
    }

    ask() {
      const question = this.view.questions.get(this.now);
      this.question.hidden = !question;
      if (!question) return;
      const given = this.answers.get(this.now);
      const buttons = question.choices.map((textContent, i) => make("button", {type: "button", textContent, disabled: given !== undefined, onclick: () => this.answer(i)}));
      this.question.replaceChildren(make("legend", {textContent: "Before you go on"}), make("p", {textContent: question.text}), ...buttons);
      if (given === undefined) return;
      const verdict = make("p", {textContent: given === question.right ? "Right. " : `Not so: ${question.choices[question.right]}. `});
      const show = make("button", {type: "button", textContent: "See it happen", onclick: () => this.play(question.until)});
      this.question.append(verdict, show);
    }
    answer(i) {
      this.answers.set(this.now, i);
      this.element.dataset.answered = `${this.now} ${i === this.view.questions.get(this.now).right ? "right" : "wrong"}`;
      this.draw();
      this.ask();
      this.question.querySelector("button:not(:disabled)").focus();
    }
  }

  const add_style = (textContent) => document.head.append(make("style", {textContent}));
  add_style(STYLE);
  new Set([...document.querySelectorAll(".replay")].map((element) => new Steps(element).view.style)).forEach(add_style);
}
