// The editor of a unit's text: CodeMirror 6, with what a unit in C needs. By keys alone: Tab indents, and after Escape
// leaves the editor.
import {history, historyField, historyKeymap, defaultKeymap, indentWithTab, isolateHistory, redoDepth, undoDepth} from "@codemirror/commands";
import {cpp} from "@codemirror/lang-cpp";
import {bracketMatching, codeFolding, foldEffect, foldGutter, foldKeymap, HighlightStyle, indentOnInput, indentUnit, syntaxHighlighting, syntaxTree, ensureSyntaxTree} from "@codemirror/language";
import {closeBrackets, closeBracketsKeymap} from "@codemirror/autocomplete";
import {lintGutter, lintKeymap, setDiagnostics} from "@codemirror/lint";
import {highlightSelectionMatches, searchKeymap} from "@codemirror/search";
import {EditorState, Prec} from "@codemirror/state";
import {drawSelection, EditorView, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers} from "@codemirror/view";
import {tags} from "@lezer/highlight";

const STEP = /\/\/ \w+ step\b/; // what starters say in a function that is the student's to write
const FOLDED_FROM = 3; // lines

// A closing brace goes on a line of its own, where it would be typed beside the one that the editor has put there.
const CLOSED = Prec.high(EditorState.languageData.of(() => [{closeBrackets: {brackets: ["(", "[", "'", "\""]}}]));

// Colours are the page's, light or dark.
const COLOURS = HighlightStyle.define([
  {tag: [tags.comment], color: "var(--comment)"},
  {tag: [tags.keyword, tags.modifier, tags.controlKeyword, tags.definitionKeyword], color: "var(--keyword)"},
  {tag: [tags.typeName, tags.standard(tags.typeName)], color: "var(--type)"},
  {tag: [tags.string, tags.character, tags.number], color: "var(--number)"},
  {tag: [tags.processingInstruction], color: "var(--directive)"},
]);
const LOOK = EditorView.theme({
  "&": {height: "100%", border: "1px solid color-mix(in srgb, currentcolor 40%, transparent)"},
  "&.cm-focused": {outline: "2px solid Highlight"},
  ".cm-scroller": {font: "var(--size)/1.45 'DejaVu Sans Mono', monospace"},
  ".cm-content": {caretColor: "CanvasText"},
  ".cm-cursor": {borderLeftColor: "CanvasText"},
  ".cm-gutters": {color: "inherit", backgroundColor: "Canvas", borderRight: "none", opacity: ".75"},
  ".cm-activeLine, .cm-activeLineGutter": {backgroundColor: "#8882"},
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {backgroundColor: "#48f5"},
  ".cm-foldPlaceholder": {color: "inherit", backgroundColor: "#8882", border: "none", padding: "0 .4em"},
  ".cm-tooltip": {color: "CanvasText", backgroundColor: "Canvas"},
});

const HISTORY = {history: historyField};
// As one step of the history.
const replaced = (state, text) => state.update({changes: {from: 0, to: state.doc.length, insert: text}, annotations: isolateHistory.of("full")});

// Returns what Editor.keep() returns when `text` has replaced that of `kept`, or of the starter if this is null.
export function with_text(kept, starter, text) {
  const extensions = [history()];
  const state = kept ? EditorState.fromJSON(kept, {extensions}, HISTORY) : EditorState.create({doc: starter, extensions});
  return replaced(state, text).state.toJSON(HISTORY);
}

export class Editor {
  #view;
  #changed;

  // The editor fills its parent; changed(text) is called when the text has changed, by whomever.
  constructor(parent, label, changed) {
    this.#changed = changed;
    this.#view = new EditorView({parent});
    this.label = label;
    this.open("");
  }

  #extensions() {
    return [lineNumbers(), highlightActiveLineGutter(), history(), foldGutter(), codeFolding({placeholderText: "given"}),
      drawSelection(), indentOnInput(), indentUnit.of("    "), EditorState.tabSize.of(4), bracketMatching(), CLOSED, closeBrackets(), EditorView.lineWrapping,
      highlightActiveLine(), highlightSelectionMatches(), cpp(), syntaxHighlighting(COLOURS), lintGutter(), LOOK,
      EditorView.contentAttributes.of({"aria-label": this.label, spellcheck: "false", autocapitalize: "off", tabindex: "0"}),
      EditorView.updateListener.of((update) => { if (update.docChanged) this.#changed(this.text()); }),
      keymap.of([...closeBracketsKeymap, ...defaultKeymap, ...searchKeymap, ...historyKeymap, ...foldKeymap, ...lintKeymap, indentWithTab])];
  }

  text() { return this.#view.state.doc.toString(); }

  // A new text; `kept` is what keep() has returned for it, with its history.
  open(text, kept = null) {
    const extensions = this.#extensions();
    let state = EditorState.create({doc: text, extensions});
    if (kept) state = EditorState.fromJSON(kept, {extensions}, HISTORY);
    this.#view.setState(state);
  }

  // Returns text, selection and history, as JSON can hold them.
  keep() { return this.#view.state.toJSON(HISTORY); }

  // Replaces the text, so that this can be undone.
  replace(text) { this.#view.dispatch(replaced(this.#view.state, text)); }

  focus() { this.#view.focus(); } // so that undo brings back what a button has replaced

  // Has undo bring back this text before the others.
  remember(text) {
    const now = this.text(), {selection} = this.#view.state;
    this.replace(text);
    this.replace(now);
    this.#view.dispatch({selection});
  }

  is_untouched() { return undoDepth(this.#view.state) + redoDepth(this.#view.state) === 0; }

  // Folds the functions of a starter in which nothing is left to write.
  foldGiven() {
    const {state} = this.#view, effects = [];
    ensureSyntaxTree(state, state.doc.length, 1000);
    syntaxTree(state).iterate({enter(node) {
      if (node.name !== "FunctionDefinition") return true;
      const body = node.node.getChild("CompoundStatement");
      const text = body ? state.sliceDoc(body.from, body.to) : "";
      if (body && !STEP.test(text) && text.split("\n").length > FOLDED_FROM) effects.push(foldEffect.of({from: body.from + 1, to: body.to - 1}));
      return false;
    }});
    this.#view.dispatch({effects});
  }

  // Scrolls to the first function in which a step is left to write.
  showFirstStep() {
    const at = this.text().search(STEP);
    if (at >= 0) this.#view.dispatch({selection: {anchor: at}, effects: EditorView.scrollIntoView(at, {y: "center"})});
  }

  // Marks lines: findings are {line, message, severity}, severity "error", "warning" or "info"; others are no more marked.
  mark(findings) {
    const {state} = this.#view;
    const diagnostics = findings.filter(({line}) => line >= 1 && line <= state.doc.lines).map(({line, message, severity}) => {
      const {from, to, text} = state.doc.line(line);
      return {from: Math.min(from + text.search(/\S|$/), to), to, severity, message};
    });
    this.#view.dispatch(setDiagnostics(state, diagnostics));
  }

  // Puts the cursor there.
  show(line) {
    const {from} = this.#view.state.doc.line(Math.max(1, Math.min(line, this.#view.state.doc.lines)));
    this.#view.dispatch({selection: {anchor: from}, effects: EditorView.scrollIntoView(from, {y: "center"})});
    this.#view.focus();
  }
}
