// Fields of forms: what is wrong with an entry stands below it, and the entry stays as it was typed.

import { el } from "../dom.js";
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
    input.toggleAttribute("aria-invalid", Boolean(wrong));
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
      input.toggleAttribute("aria-invalid", false);
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

/** A field for an expression, checked by the server while it is typed; a mistake is underlined where it stands. */
export function expressionField(label, value, commit, check, { optional = false, hint = "" } = {}) {
  const id = `f${(count += 1)}`;
  const error = el("div", { class: "wrong", id: `${id}e`, role: "status" });
  let was = String(value ?? "");
  let now = was;
  let number = 0;
  let timer;
  let listed = null;
  const say = (text, at) => {
    error.textContent = text;
    editor.mark(text ? at : null);
  };
  const look = async () => {
    const mine = (number += 1);
    const text = editor.value;
    if (optional && !text.trim()) {
      say("", 0);
      return;
    }
    const answer = await check(text);
    listed = answer;
    if (mine === number) say(answer.ok ? "" : answer.error, answer.at);
  };
  const done = async () => {
    const given = editor.value;
    if (given === now) return;
    now = given; // Enter and leaving the field are one entry
    const wrong = await commit(given);
    if (!wrong) was = given;
    if (editor.value !== given) return;
    clearTimeout(timer);
    if (!wrong) say("", 0);
    else if (!error.textContent) say(wrong, 0);
  };
  const editor = expressionEditor({
    label, describedby: `${id}e`, value: was, commit: done,
    typed: () => {
      clearTimeout(timer);
      timer = setTimeout(() => look().catch(() => {}), 120);
    },
    cancel: () => {
      number += 1;
      now = was;
      if (editor.value !== was) editor.value = was;
      clearTimeout(timer);
      say("", 0);
      editor.blur();
    },
    names: async () => listed ?? (listed = await check(editor.value || "0")),
  });
  const row = el("div", { class: "entry" }, el("label", { onclick: () => editor.focus() }, label), editor.element, error, hint ? el("div", { class: "soft hint" }, hint) : null);
  row.input = editor;
  row.error = error;
  return row;
}

export const numberOf = (text) => (text === "" || text === null ? null : Number(text));
