// The field in which an expression is written: CodeMirror, with names completed and the place of a mistake underlined.

import { autocompletion, bracketMatching, Decoration, EditorState, EditorView, history, historyKeymap, insertNewline, keymap, standardKeymap, StateEffect, StateField } from "../../vendor/codemirror/codemirror.js";

const place = StateEffect.define(); // {at} of a mistake, or null
const underline = Decoration.mark({ class: "mistake" });

/** The name or sign at a place of a text; at its end, what stands last. */
function part(text, at) {
  if (!text.length) return null;
  const from = Math.min(at, text.length - 1);
  return [from, from + (/^[\w.]+/.exec(text.slice(from))?.[0].length ?? 1)];
}

const mistake = StateField.define({
  create: () => ({ wrong: false, marks: Decoration.none }),
  update(before, transaction) {
    for (const effect of transaction.effects) {
      if (!effect.is(place)) continue;
      const span = effect.value && part(transaction.newDoc.toString(), effect.value.at);
      return { wrong: effect.value !== null, marks: span ? Decoration.set(underline.range(...span)) : Decoration.none };
    }
    return transaction.docChanged ? { ...before, marks: before.marks.map(transaction.changes) } : before;
  },
  provide: (field) => [
    EditorView.decorations.from(field, ({ marks }) => marks),
    EditorView.contentAttributes.from(field, ({ wrong }) => (wrong ? { "aria-invalid": "true" } : {})),
  ],
});

const alive = new Set();

/** Editors that have left the page are ended: they listen to the window. */
function tidy() {
  for (const one of alive) {
    if (!one.seen || one.view.dom.isConnected) continue;
    one.view.destroy();
    alive.delete(one);
  }
}

/**
 * An editor of one expression. Enter and leaving commit, Shift+Enter begins a line, Escape takes back, Tab leaves; Ctrl+Space lists names.
 * `names()` promises `{known, functions}`. With `line`, leaving does nothing and there is one line.
 */
export function expressionEditor({ label, describedby, value, typed, commit, cancel, names, line = false }) {
  tidy();
  const complete = async (context) => {
    const word = context.matchBefore(/[A-Za-z_][\w.]*/);
    if (!word && !context.explicit) return null;
    const { known, functions } = await names();
    const options = [...known.map((name) => ({ label: name, type: "variable", boost: 1 })), ...functions.map((name) => ({ label: name, type: "function" }))];
    return { from: word ? word.from : context.pos, options, validFor: /^[\w.]*$/ };
  };
  const keys = [
    { key: "Enter", run: () => (commit(), true) },
    { key: "Shift-Enter", run: line ? () => true : insertNewline },
    { key: "Escape", run: () => (cancel(), true) },
  ];
  const view = new EditorView({
    state: EditorState.create({
      doc: value,
      extensions: [
        mistake, history(), bracketMatching(), ...(line ? [] : [EditorView.lineWrapping]),
        autocompletion({ override: [complete], selectOnOpen: false, icons: false, activateOnTypingDelay: 60, interactionDelay: 0 }),
        keymap.of([...keys, ...historyKeymap, ...standardKeymap]),
        EditorView.contentAttributes.of({ "aria-label": label, "aria-describedby": describedby, spellcheck: "false", autocapitalize: "off" }),
        EditorView.updateListener.of((update) => update.docChanged && typed()),
        EditorView.domEventHandlers({ blur: () => { if (!line) commit(); } }),
      ],
    }),
  });
  // a key that the editor has used is not the view's, too
  view.dom.addEventListener("keydown", (event) => event.defaultPrevented && event.stopPropagation());
  const one = { view, seen: false };
  alive.add(one);
  requestAnimationFrame(() => { one.seen = true; });
  return {
    element: view.dom,
    focus: () => view.focus(),
    blur: () => view.contentDOM.blur(),
    get value() { return view.state.doc.toString(); },
    set value(text) { view.dispatch({ changes: { from: 0, to: view.state.doc.length, insert: text } }); },
    /** Underline what stands at a place; null: nothing is wrong. */
    mark(at) { view.dispatch({ effects: place.of(at === null ? null : { at }) }); },
  };
}
