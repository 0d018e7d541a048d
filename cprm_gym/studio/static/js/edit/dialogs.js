// Dialogs of the editor: what to open, under which name to save, what to do about a file that changed.

import { el } from "../dom.js";

/** Show a dialog; `fill(close)` gives its content. Gives what `close` was given, or null. */
export function ask(title, fill) {
  return new Promise((resolve) => {
    const dialog = el("dialog", { class: "ask", "aria-label": title });
    const close = (answer) => {
      dialog.close();
      dialog.remove();
      resolve(answer);
    };
    dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      close(null);
    });
    dialog.append(el("h2", {}, title), ...[fill(close)].flat());
    document.body.append(dialog);
    dialog.showModal();
    dialog.querySelector("input, select, button.main, button")?.focus();
  });
}

/** One line of text. */
export function askText(title, { value = "", label = "name", hint = "", action = "OK" } = {}) {
  return ask(title, (close) => {
    const field = el("input", { type: "text", value, "aria-label": label, size: 36, spellcheck: "false" });
    return el("form", { class: "rows", onsubmit: (event) => {
      event.preventDefault();
      if (field.value.trim()) close(field.value.trim());
    } }, el("label", {}, label, field), hint && el("p", { class: "soft" }, hint),
    el("div", { class: "bar" }, el("span", { class: "room" }), el("button", { type: "button", onclick: () => close(null) }, "cancel"), el("button", { class: "main" }, action)));
  });
}

/** One of several, found by typing. */
export function pick(title, options, { empty = "there is none", hint = "" } = {}) {
  return ask(title, (close) => {
    const list = el("div", { class: "list", role: "listbox" });
    const show = (text) => {
      const shown = options.filter(([, name]) => name.toLowerCase().includes(text.toLowerCase())).slice(0, 300);
      list.replaceChildren(...shown.map(([value, name, more]) => el("button", { type: "button", role: "option", onclick: () => close(value) }, name, more && el("span", { class: "soft" }, ` ${more}`))));
      if (!shown.length) list.append(el("p", { class: "soft" }, empty));
    };
    const field = el("input", { type: "search", placeholder: "find", "aria-label": "find", oninput: () => show(field.value) });
    show("");
    return el("form", { class: "rows", onsubmit: (event) => {
      event.preventDefault();
      list.querySelector("button")?.click();
    } }, field, list, hint && el("p", { class: "soft" }, hint), el("div", { class: "bar" }, el("span", { class: "room" }), el("button", { type: "button", onclick: () => close(null) }, "cancel")));
  });
}

/** Take what stands in a field that is being typed in, as leaving it does; the focus stays. */
export function enter() {
  const field = document.activeElement;
  if (!field?.matches("input, textarea, [contenteditable=true]")) return;
  field.blur();
  field.focus();
}

/** Save the document in front; asks for a name, and about a file that changed. */
export async function save(desk, { under = false } = {}) {
  enter();
  const state = desk.current;
  if (!state) return;
  let path = state.path;
  if (under || !path) {
    const ending = state.kind === "net" ? ".json or .pnml (.py writes an export)" : ".json (.py writes an export)";
    path = await askText("Save as", { value: path || `${state.name.replace(/\.\w+$/, "")}.json`, label: "file", action: "save", hint: `In ${desk.root}; ${ending}` });
    if (!path) return;
  }
  const answer = await desk.ask("save", { path });
  if (answer?.conflict) {
    const choice = await ask("The file changed", (close) => [el("p", {}, `${answer.conflict}.`), el("div", { class: "bar" },
      el("button", { onclick: () => close(null) }, "cancel"), el("button", { onclick: () => close("other") }, "save under another name"),
      state.path === path ? el("button", { onclick: () => close("theirs") }, "take what the file holds") : null, el("button", { class: "main", onclick: () => close("ours") }, "write over it"))]);
    if (choice === "ours") {
      const done = await desk.ask("save", { path, force: true });
      if (done?.written) desk.studio.note(`written: ${done.written}`);
    } else if (choice === "theirs") await desk.ask("discard");
    else if (choice === "other") await save(desk, { under: true });
  } else if (answer?.written) desk.studio.note(`written: ${answer.written}`);
}

export async function openFile(desk) {
  const files = await desk.call("browse", {});
  const path = await pick("Open a file", files.map((file) => [file, file]), { empty: `no .json or .pnml files in ${desk.root}`, hint: `Files in ${desk.root}. Others are named on the command line.` });
  if (path) await desk.bring("open", { path });
}

export async function openShipped(desk) {
  const name = await pick("A copy of a net that comes with the package", (await desk.call("shipped", {})).map((one) => [one, one]));
  if (name) await desk.bring("ship", { name });
}

/** Give a text to the browser as a file. */
export async function download(desk, form) {
  try {
    const { name, text } = await desk.call("export", { id: desk.current.id, form });
    const link = el("a", { href: URL.createObjectURL(new Blob([text], { type: "text/plain" })), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  } catch (error) {
    desk.studio.note(error.message, "error");
  }
}
