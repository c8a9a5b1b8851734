// In the site of a course: the units that a suite or a driver is linked with beside the one that is written. They are the
// student's own, or starters: the site holds no solution of them.

import {has_main} from "./checker.mjs";

const tight = (text) => text.replace(/\s+/g, "");

export class Others {
  #made = new Map(); // of each unit {text, object}

  // open: open.json (objects.mjs), starters: the objects of its units, by their stems.
  constructor(checker, open, starters) { Object.assign(this, {checker, open, starters}); }

  // Without checks, like the kit's units: they take time, and tell of the unit that is written. Null if the text does not
  // compile.
  #object(stem, text) {
    const made = this.#made.get(stem);
    if (made && made.text === text) return made.object;
    const {toolchain, kit} = this.checker, name = `${stem}.c`;
    const {object} = toolchain.compile({src: kit.headers, [name]: text}, name, {include: ["src"], checks: false});
    const linked = object && !has_main(object) ? object : null;
    this.#made.set(stem, {text, object: linked});
    return linked;
  }

  // Links by link(others, starters) with these units: those in texts, by their stems, or with starters alone if that
  // cannot be linked. Returns what link does, and starters: the stems of those that are not the student's.
  #linked(stems, texts, link) {
    const is_own = (stem) => texts[stem] !== undefined && tight(texts[stem]) !== tight(this.open.starters[stem]);
    const own = Object.fromEntries(stems.filter(is_own).map((stem) => [stem, this.#object(stem, texts[stem])]).filter(([, object]) => object));
    const linked_with = (own) => {
      const starters = stems.filter((stem) => !own[stem]);
      const others = Object.fromEntries(stems.map((stem) => [`other-${stem}.o`, own[stem] || this.starters[stem]]));
      return {...link(others, starters), starters};
    };
    const result = linked_with(own), is_alone = Object.keys(own).length === 0;
    const without = result.bytes || is_alone ? result : linked_with({});
    return without.bytes ? without : result;
  }

  // What the driver says of starters, as the build of a pack has it said.
  #note(starters) {
    if (starters.length === 0) return {};
    const {toolchain, kit} = this.checker, flags = [`-DRK_UNSOLVED_FEATURES=" ${starters.join(" ")} "`];
    const {object} = toolchain.compile({src: kit.headers, "note.c": this.open.note}, "note.c", {include: ["src"], flags, checks: false});
    return {note: {"note.o": object}};
  }

  // Links a unit with its suite. Of the starters there are those that the course asks for.
  suite(stem, object, texts) {
    const result = this.#linked(this.open.suites[stem] || [], texts, (others) => this.checker.link(stem, object, {others}));
    return {...result, starters: result.starters.filter((other) => other in this.open.starters)};
  }

  // Links a unit with its driver.
  driver(drawer, stem, object, texts) {
    const stems = this.open.stems.filter((other) => other !== stem);
    return this.#linked(stems, texts, (others, starters) => drawer.link(stem, object, {others, ...this.#note(starters)}));
  }
}
