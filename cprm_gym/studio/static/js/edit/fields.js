// Fields of forms: what is wrong with an entry stands below it, and the entry stays as it was typed.

import { el, invalid } from "../dom.js";
import { expressionEditor } from "./expressioneditor.js";

let count = 0;

/** A labelled field; `commit(value)` gives "" or what is wrong. */
export function field(label, value, commit, { type = "text", options = null, hint = "", multiline = false, step = null, list = null } = {}) {
  const id = `f${(count += 1)}`;
  const error = el("div", { class: "wrong", id: `${id}e`, role: "status" });
  let input;
  const done = async () => {
    const given = type === "checkbox" ? input.checked : input.value;
    if (String(given) === input.dataset.now) return;
    input.dataset.now = String(given); // Enter and leaving the field are one entry
    const wrong = await commit(given);
    error.textContent = wrong ?? "";
    invalid(input, Boolean(wrong));
    if (!wrong) input.dataset.was = String(given);
  };
  if (options) {
    input = el("select", { id, onchange: done }, ...options.map((option) => {
      const [of, text] = Array.isArray(option) ? option : [option, option];
      return el("option", { value: of, selected: String(of) === String(value) }, text);
    }));
  } else if (multiline) input = el("textarea", { id, rows: 3, spellcheck: "false", onchange: done }, String(value ?? ""));
  else input = el("input", { id, type, ...(type === "checkbox" ? { checked: Boolean(value) } : { value: value ?? "" }), spellcheck: "false", autocomplete: "off", step, list, onchange: done });
  input.dataset.was = type === "checkbox" ? String(Boolean(value)) : String(value ?? "");
  input.dataset.now = input.dataset.was;
  input.setAttribute("aria-describedby", `${id}e`);
  input.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      if (type === "checkbox") input.checked = input.dataset.was === "true";
      else input.value = input.dataset.was;
      input.dataset.now = input.dataset.was;
      error.textContent = "";
      invalid(input, false);
      input.blur();
    }
    if (event.key === "Enter" && multiline && !event.shiftKey) {
      event.preventDefault();
      done();
    }
  });
  const row = el("div", { class: `entry${type === "checkbox" ? " check" : ""}` }, el("label", { for: id }, label), input, error, hint ? el("div", { class: "soft hint" }, hint) : null);
  row.input = input;
  row.error = error;
  return row;
}

/** What is typed into an editor is checked by the server a moment later; a mistake is underlined and said in `error`. */
class Checked {
  constructor(editor, error, check, optional) {
    Object.assign(this, { editor, error, check, optional, number: 0, listed: null });
  }

  say(text, at = 0) {
    this.error.textContent = text;
    this.editor.mark(text ? at : null);
  }

  later() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.look().catch(() => {}), 120);
  }

  async look() {
    const mine = (this.number += 1);
    const text = this.editor.value;
    if (this.optional && !text.trim()) {
      this.say("");
      return;
    }
    const answer = await this.check(text);
    this.listed = answer;
    if (mine === this.number) this.say(answer.ok ? "" : answer.error, answer.at);
  }

  /** What was asked does not matter any more. */
  stop() {
    clearTimeout(this.timer);
    this.number += 1;
  }

  /** Names and functions that might stand there. */
  async names() {
    this.listed ??= await this.check(this.editor.value || "0");
    return this.listed;
  }
}

/** A line for an expression that Enter gives to `enter(text)`, which promises whether it was taken; `hint` stands in it while it is empty. */
export function expressionLine(label, hint, enter, check) {
  const id = `f${(count += 1)}`;
  const error = el("p", { class: "bad mono lines", id: `${id}e`, role: "status" });
  const holder = el("div", { class: "line-editor blank", "data-hint": hint });
  const typed = () => holder.classList.toggle("blank", !editor.value);
  const editor = expressionEditor({
    label, describedby: `${id}e`, value: "", line: true,
    typed: () => { typed(); checked.later(); },
    commit: () => line.enter(),
    cancel: () => line.clear(),
    names: () => checked.names(),
  });
  const checked = new Checked(editor, error, check, true);
  holder.append(editor.element);
  const line = {
    element: holder,
    error,
    get value() { return editor.value.trim(); },
    async enter() {
      checked.stop();
      try {
        if (await enter(line.value)) line.clear();
      } catch (wrong) {
        checked.say(wrong.message);
      }
    },
    clear() {
      checked.stop();
      editor.value = "";
      checked.stop();
      checked.say("");
      typed();
    },
    say: (text) => checked.say(text),
    /** Other names might stand there. */
    anew(text = hint) {
      checked.listed = null;
      holder.dataset.hint = text;
      if (editor.value) checked.later();
    },
    set disabled(off) { holder.inert = off; },
  };
  return line;
}

/** A field for an expression, checked by the server while it is typed; a mistake is underlined where it stands. */
export function expressionField(label, value, commit, check, { optional = false, hint = "" } = {}) {
  const id = `f${(count += 1)}`;
  const error = el("div", { class: "wrong", id: `${id}e`, role: "status" });
  let was = String(value ?? "");
  let now = was;
  const done = async () => {
    const given = editor.value;
    if (given === now) return;
    now = given; // Enter and leaving the field are one entry
    const wrong = await commit(given);
    if (!wrong) was = given;
    if (editor.value !== given) return;
    checked.stop();
    if (!wrong) checked.say("");
    else if (!error.textContent) checked.say(wrong);
  };
  const editor = expressionEditor({
    label, describedby: `${id}e`, value: was, commit: done,
    typed: () => checked.later(),
    cancel: () => {
      now = was;
      if (editor.value !== was) editor.value = was;
      checked.stop();
      checked.say("");
      editor.blur();
    },
    names: () => checked.names(),
  });
  const checked = new Checked(editor, error, check, optional);
  const row = el("div", { class: "entry" }, el("label", { onclick: () => editor.focus() }, label), editor.element, error, hint ? el("div", { class: "soft hint" }, hint) : null);
  row.input = editor;
  row.error = error;
  return row;
}

export const numberOf = (text) => (text === "" || text === null ? null : Number(text));
