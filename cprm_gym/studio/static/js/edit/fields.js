// Fields of forms: what is wrong with an entry stands below it, and the entry stays as it was typed.

import { el } from "../dom.js";

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

/** A field for an expression, checked by the server while it is typed; the caret shows the place of a mistake. */
export function expressionField(label, value, commit, check, options = {}) {
  const row = field(label, value, commit, { ...options, multiline: true });
  const names = el("div", { class: "names soft" });
  row.append(names);
  row.input.classList.add("mono");
  let number = 0;
  const look = async () => {
    const mine = (number += 1);
    const text = row.input.value;
    if (options.optional && !text.trim()) {
      row.error.textContent = "";
      return;
    }
    const answer = await check(text);
    if (mine !== number) return;
    row.input.toggleAttribute("aria-invalid", !answer.ok);
    row.error.textContent = answer.ok ? "" : answer.error;
    if (!answer.ok && answer.at <= text.length) row.error.append(el("pre", { class: "caret" }, `${text}\n${" ".repeat(answer.at)}^`));
    const word = /[A-Za-z][\w.]*$/.exec(text.slice(0, row.input.selectionStart))?.[0] ?? "";
    const near = word ? [...answer.known, ...answer.functions].filter((name) => name !== word && name.toLowerCase().includes(word.toLowerCase())).slice(0, 8) : [];
    names.replaceChildren(...near.map((name) => el("button", { type: "button", tabindex: -1, onmousedown: (event) => {
      event.preventDefault();
      const at = row.input.selectionStart;
      row.input.setRangeText(name, at - word.length, at, "end");
      look();
    } }, name)));
  };
  row.input.addEventListener("input", () => {
    clearTimeout(row.timer);
    row.timer = setTimeout(() => look().catch(() => {}), 120);
  });
  row.input.addEventListener("blur", () => names.replaceChildren());
  return row;
}

export const numberOf = (text) => (text === "" || text === null ? null : Number(text));
