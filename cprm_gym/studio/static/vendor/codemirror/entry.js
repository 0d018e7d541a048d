export { EditorState, StateEffect, StateField } from "@codemirror/state";
export { Decoration, EditorView, keymap } from "@codemirror/view";
export { history, historyKeymap, insertNewline, standardKeymap } from "@codemirror/commands";
export { bracketMatching } from "@codemirror/language";
export { autocompletion } from "@codemirror/autocomplete";
