// What the editors of nets and of models share: the list of documents, undo and redo, files, closing.

import { el, memory } from "../dom.js";
import { told } from "./desk.js";
import { ask, download, openFile, save } from "./dialogs.js";

/** Buttons of a tool bar and how the document stands to its file; `show()` brings them up to date. */
export class DocumentTools {
  constructor(desk, forms) {
    this.desk = desk;
    this.undo = el("button", { title: "undo", onclick: () => desk.ask("undo"), "data-do": "undo" }, "↶");
    this.redo = el("button", { title: "redo", onclick: () => desk.ask("redo"), "data-do": "redo" }, "↷");
    this.save = el("button", { title: "save (Ctrl+S)", onclick: () => save(desk), "data-do": "save" }, "Save");
    this.state = el("span", { class: "soft", role: "status" });
    this.file = el("select", { "aria-label": "file", onchange: () => {
      const form = this.file.value;
      this.file.value = "";
      if (form === "as") save(desk, { under: true });
      else if (form) download(desk, form);
    } }, el("option", { value: "" }, "File…"), el("option", { value: "as" }, "Save as…"), ...forms.map(([form, name]) => el("option", { value: form }, `Export ${name}`)));
  }

  show() {
    const { current } = this.desk;
    if (!current) return;
    [this.undo.disabled, this.redo.disabled] = [!current.history.undo, !current.history.redo];
    this.undo.title = `undo ${current.history.undo} (Ctrl+Z)`;
    this.redo.title = `redo ${current.history.redo} (Ctrl+Y)`;
    this.state.textContent = told(current);
  }
}

/** The keys of documents, as a view lists its keys. */
export const documentKeys = (desk) => [
  ["Ctrl+z", "undo", () => desk.ask("undo")], ["Ctrl+y", "redo", () => desk.ask("redo")], ["Ctrl+Shift+Z", "redo", () => desk.ask("redo")],
  ["Ctrl+s", "save", () => save(desk)], ["Ctrl+o", "open a file", () => openFile(desk)],
];

/** A document in the list of those that are open; ● is not saved. */
export function documentRow(desk, one) {
  return el("button", { class: "doc", "aria-current": one.id === desk.current?.id, title: one.source, onclick: () => desk.show(one.id) },
    one.saved ? "" : "● ", one.name, el("span", { class: "soft" }, ` ${one.kind}`));
}

/** Close the document in front, after asking when something is lost. */
export async function closeDocument(desk) {
  const { current } = desk;
  const sure = current.saved || (await ask("Close without saving?", (close) => [
    el("p", {}, `${current.name} has changes that were not saved. They are lost when it is closed.`),
    el("div", { class: "bar" }, el("button", { onclick: () => close(false) }, "keep it open"), el("button", { class: "danger", onclick: () => close(true) }, "close")),
  ]));
  if (!sure) return;
  await desk.call("close", { id: current.id });
  desk.current = null;
  memory.set("edit.source", "");
  await desk.begin();
}
