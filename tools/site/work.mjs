// A student's work on one unit, in the editor and kept in the browser. It is the same in all tabs that show it: what one
// keeps the others take over. Where two have changed it at once, the later one stands, and the other is in its history.
import {forget, keep, kept, when_kept} from "./kept.mjs";

export class Work {
  #common = null; // the text that the editor and the browser had last in common

  // told({is_later, text}) is called when another tab has changed the text: it is in the editor now, or is_later, and the
  // editor's stands.
  constructor(stem, editor, told) {
    Object.assign(this, {stem, editor, told, held: {}});
  }

  // Opens what was kept, or else the starter; returns whether it was kept.
  open(starter) {
    this.starter = starter;
    const before = kept(this.stem);
    try {
      this.editor.open(starter, before);
    } catch { // kept by an older page
      forget(this.stem);
      this.editor.open(starter);
    }
    this.#note(before);
    when_kept(this.stem, () => this.#take_over());
    for (const event of ["blur", "pagehide"]) addEventListener(event, () => this.save());
    for (const event of ["focus", "pageshow"]) addEventListener(event, () => this.#take_over()); // while a page is frozen it is told nothing
    return Boolean(before);
  }

  // Keeps the text with {passed, claims}, its last verdict. Returns whether it is kept.
  save(held = this.held) {
    const now = this.editor.text(), there = kept(this.stem), is_other = there && there.doc !== this.#common && there.doc !== now;
    if (is_other && now === this.#common) {
      this.#take_over();
      return true;
    }
    this.held = held;
    if (!there && this.editor.is_untouched()) return true;
    if (is_other) this.editor.remember(there.doc);
    this.#common = now;
    const is_kept = keep(this.stem, {...this.editor.keep(), ...held});
    if (is_other) this.told({is_later: true, text: there.doc});
    return is_kept;
  }

  #note(before) {
    this.#common = this.editor.text();
    this.held = before?.claims ? {passed: before.passed, claims: before.claims} : {};
  }

  // Unless this tab has keys that are not kept yet: then save() finds the other text.
  #take_over() {
    const there = kept(this.stem);
    if (!there || there.doc === this.#common || this.editor.text() !== this.#common) return;
    this.editor.open(this.starter, there);
    this.#note(there);
    this.told({is_later: false, text: there.doc});
  }
}
