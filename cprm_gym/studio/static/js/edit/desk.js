// What is being edited, on this page: the documents that are open, one of them in front, and how they are changed.
//
// Events: documents (the list), document (another one or another state of it), findings (checks of its nets), refused {message}.

import { memory } from "../dom.js";

const desks = new WeakMap();

/** The one desk of a page: the views of nets and of models share it. */
export function deskOf(studio) {
  if (!desks.has(studio)) desks.set(studio, new EditDesk(studio));
  return desks.get(studio);
}

/** How a document stands to its file, in words. */
export function told({ saved, path, history }) {
  if (saved) return "saved";
  if (path) return "changed; a draft is kept";
  return history.undo ? "changed, not saved yet; a draft is kept" : "a copy; not saved yet";
}

export class EditDesk extends EventTarget {
  constructor(studio) {
    super();
    this.studio = studio;
    this.documents = [];
    this.current = null;
    this.findings = new Map(); // document -> definition -> findings
    this.checking = new Set();
    this.waiting = Promise.resolve();
    studio.connection.on("edit.changed", ({ id, revision }) => {
      if (this.current?.id === id && revision !== this.current.revision && !this.busy) this.reread();
    });
    studio.connection.on("edit.checked", ({ id, definition, findings }) => {
      if (!this.findings.has(id)) this.findings.set(id, new Map());
      this.findings.get(id).set(definition, findings);
      this.checking.delete(`${id} ${definition}`);
      this.tell("findings", { id, definition });
    });
    studio.connection.on("connection", ({ state }) => state === "open" && this.started && this.begin());
  }

  tell(type, detail = {}) {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  call(name, given) {
    return this.studio.connection.call(name.includes(".") ? name : `edit.${name}`, given);
  }

  /** Ask what is open; take up what was in front before a reload. */
  async begin() {
    this.started = true;
    this.begun = false; // whether it is known what is open
    await this.refresh();
    const wanted = memory.get("edit.source", "");
    const chosen = this.documents.find((one) => one.source === wanted) ?? this.documents[0];
    if (chosen) await this.show(chosen.id);
    this.begun = true;
    if (!chosen) this.tell("document");
  }

  async refresh() {
    const { open, root } = await this.call("list", {});
    [this.documents, this.root] = [open, root];
    this.tell("documents");
  }

  async show(id) {
    this.take(await this.call("read", { id }));
    await this.call("check", { id, first: this.front ?? "" });
  }

  async reread() {
    this.take(await this.call("read", { id: this.current.id }));
  }

  /** A state of a document that the server gave. */
  take(state) {
    this.current = state;
    memory.set("edit.source", state.source);
    if (state.told) this.studio.note(`${state.name}: ${state.told}`);
    const short = this.documents.find((one) => one.id === state.id);
    if (short) Object.assign(short, { saved: state.saved, name: state.name, path: state.path, source: state.source, revision: state.revision });
    else this.documents.push({ ...state, data: undefined });
    for (const definition of Object.keys(this.net?.definitions ?? {})) this.checking.add(`${state.id} ${definition}`);
    this.tell("documents");
    this.tell("document");
  }

  get net() {
    const { data, kind } = this.current ?? {};
    return kind === "net" ? data : kind === "cprm" ? data.net : null;
  }

  get model() {
    const { data, kind } = this.current ?? {};
    return kind === "model" || kind === "world" ? data : kind === "cprm" ? data.model : null;
  }

  /** Do something when all that was asked for before is done. */
  inTurn(doing) {
    const done = this.waiting.then(doing);
    this.waiting = done.catch(() => {});
    return done;
  }

  /** Do an operation, or what a function gives when its turn has come; gives "" or, when it is refused, why. */
  apply(op, part = "net") {
    return this.inTurn(async () => {
      this.busy = true;
      try {
        const wanted = typeof op === "function" ? op() : op;
        this.take(await this.call("apply", { id: this.current.id, op: wanted, part, revision: this.current.revision, quantities: this.quantities ?? true }));
        return "";
      } catch (error) {
        if (error.kind === "ParameterError" && /another page/.test(error.message)) await this.reread();
        return error.message;
      } finally {
        this.busy = false;
      }
    });
  }

  /** The same, and what is wrong is said at the foot of the page. */
  async try(op, part = "net") {
    const wrong = await this.apply(op, part);
    if (wrong) this.studio.note(wrong, "error");
    return !wrong;
  }

  /** Ask the server for another state of the document: undo, redo, save, discard, take_file. */
  ask(name, given = {}) {
    return this.inTurn(async () => {
      try {
        const state = await this.call(name, { id: this.current.id, ...given });
        this.take(state);
        return state;
      } catch (error) {
        this.studio.note(error.message, "error");
        return null;
      }
    });
  }

  /** Open something: open {path}, new {kind, name}, ship {name}. */
  async bring(name, given) {
    try {
      this.take(await this.call(name, given));
      await this.refresh();
      return true;
    } catch (error) {
      this.studio.note(error.message, "error");
      return false;
    }
  }

  findingsOf(definition) {
    return this.findings.get(this.current?.id)?.get(definition) ?? [];
  }

  isChecking(definition) {
    return this.checking.has(`${this.current?.id} ${definition}`);
  }
}
