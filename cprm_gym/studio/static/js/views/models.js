// The editor of models: classes, relations and objects at the left, tables or the ground net in the middle, forms at the right.

import { choose, el, memory } from "../dom.js";
import { CpdTable } from "../edit/cpdtable.js";
import { deskOf } from "../edit/desk.js";
import { ask, askText, openFile, pick } from "../edit/dialogs.js";
import { closeDocument, documentKeys, documentRow, DocumentTools } from "../edit/documents.js";
import { free, ModelForms } from "../edit/modelforms.js";
import { ModelGraph } from "../edit/modelgraph.js";

export default {
  name: "models",
  title: "Models",
  create: (root, studio) => new ModelsView(root, studio),
};

class ModelsView {
  constructor(root, studio) {
    this.studio = studio;
    this.desk = deskOf(studio);
    this.mode = memory.get("model.mode", "table");
    this.selection = memory.get("model.selection", null);
    this.build(root);
    this.desk.addEventListener("documents", () => this.list());
    this.desk.addEventListener("document", () => this.changed());
    document.addEventListener("theme", () => this.middle());
    this.keys = [...documentKeys(this.desk),
      ["g", "graph and query, or tables", () => this.setMode(this.mode === "graph" ? "table" : "graph")], ["e", "go to the form", () => this.form.querySelector("input")?.focus()],
      ["Tab", "in the graph: the next variable", () => {}], ["Enter", "in the graph: observe the variable", () => {}], ["Delete", "in the graph: no longer observed", () => {}]];
    this.centre.replaceChildren(el("div", { class: "empty" }, el("p", { role: "status" }, "opening…")));
    if (!this.desk.started) this.desk.begin().catch((error) => studio.note(error.message, "error"));
    else this.changed();
  }

  build(root) {
    const button = (text, title, onclick, name) => el("button", { title, onclick, "data-do": name }, text);
    this.side = el("nav", { class: "panel side", "aria-label": "parts of the model" });
    this.modes = { table: button("Table", "the CPD of what is selected", () => this.setMode("table"), "table"), graph: button("Graph and query", "the ground net; click variables to observe them (g)", () => this.setMode("graph"), "graph") };
    this.files = new DocumentTools(this.desk, [["json", "JSON"], ["python", "Python"]]);
    this.tools = el("div", { class: "bar tools", role: "toolbar", "aria-label": "model" }, this.modes.table, this.modes.graph, this.files.undo, this.files.redo, button("Learn…", "learn the CPDs from a log of readings", () => this.learn(), "learn"), el("span", { class: "room" }), this.files.state, this.files.save, this.files.file);
    this.problem = el("div", { class: "problem bad", role: "status" });
    this.centre = el("div", { class: "panel centre" });
    this.form = el("div", { class: "panel form", "aria-label": "what is selected" });
    root.replaceChildren(el("div", { class: "models" }, this.side, el("div", { class: "middle" }, this.tools, this.problem, this.centre), this.form));
    this.tablePane = el("div", { class: "pane" });
    this.graphPane = el("div", { class: "pane" });
    this.forms = new ModelForms(this.form, this.desk, { select: (selection) => this.select(selection) });
    this.table = new CpdTable(this.tablePane, this.desk);
    this.graph = new ModelGraph(this.graphPane, this.form, this.desk);
  }

  show() {
    if (this.desk.current) this.changed();
  }

  setMode(mode) {
    this.mode = mode;
    memory.set("model.mode", mode);
    this.changed();
  }

  select(selection) {
    this.selection = selection;
    memory.set("model.selection", selection);
    if (this.mode === "graph") this.mode = "table";
    this.changed();
  }

  list() {
    const { current, model } = this.desk;
    const documents = this.desk.documents.filter((one) => one.model);
    const parts = [el("h3", {}, "Open"), ...documents.map((one) => documentRow(this.desk, one)), el("div", { class: "bar" }, el("button", { onclick: () => openFile(this.desk) }, "Open…"), el("button", { onclick: () => this.newModel() }, "New…"), current && model ? el("button", { onclick: () => closeDocument(this.desk) }, "Close") : null)];
    if (model) {
      const row = (kind, path, name, depth, more = "") => el("button", { class: `doc depth${depth}`, "aria-current": this.selection?.path?.join() === path.join(), onclick: () => this.select({ kind, path }) }, name, more && el("span", { class: "soft" }, ` ${more}`));
      const { classes = [], relations = [] } = model.model;
      const insert = (list, value) => this.desk.try({ op: "insert", path: ["model", list, (model.model[list] ?? []).length], value }, "model");
      parts.push(el("h3", {}, "Classes"));
      classes.forEach((c, i) => {
        const at = ["model", "classes", i];
        parts.push(row("class", at, c.name, 0, c.extends ? `: ${c.extends}` : ""), ...(c.attributes ?? []).map((a, k) => row("attribute", [...at, "attributes", k], a.name, 1, kindOf(a.domain))), ...(c.references ?? []).map((r, k) => row("reference", [...at, "references", k], r.name, 1, `→ ${r.target}${r.many ? "*" : ""}`)), ...(c.given ?? []).map((g, k) => row("given", [...at, "given", k], g.name, 1, "given")));
      });
      parts.push(el("div", { class: "bar" }, el("button", { onclick: () => insert("classes", { is: "PRMClass", name: free("Class", classes.map((c) => c.name)) }) }, "+ class")), el("h3", {}, "Relations"));
      relations.forEach((r, i) => {
        const at = ["model", "relations", i];
        parts.push(row("relation", at, r.name, 0), ...(r.changes ?? []).map((c, k) => row("change", [...at, "changes", k], c.target, 1, c.is === "Add" ? "+ parents" : "replaced")), ...(r.attributes ?? []).map((a, k) => row("attribute", [...at, "attributes", k], a.name, 1, "own")));
      });
      const concrete = classes.filter((c) => !c.abstract);
      parts.push(el("div", { class: "bar" }, concrete.length ? el("button", { onclick: () => insert("relations", { is: "Relation", name: free("relation", relations.map((r) => r.name)), roles: [["a", concrete[0].name]] }) }, "+ relation") : null));
      const objects = current.data.objects;
      if (objects) {
        const name = () => free(concrete[0].name.toLowerCase(), Object.keys(objects));
        parts.push(el("h3", {}, "Objects"), ...Object.entries(objects).map(([o, c]) => row("object", ["objects", o], o, 0, c)), el("div", { class: "bar" }, concrete.length ? el("button", { onclick: () => this.desk.try({ op: "set", path: ["objects", name()], value: concrete[0].name }, "model") }, "+ object") : null));
      }
    }
    this.side.replaceChildren(...parts);
    this.files.show();
  }

  async changed() {
    const { model } = this.desk;
    for (const part of this.tools.querySelectorAll("button, select")) part.disabled = !model;
    this.form.hidden = !model;
    for (const [mode, made] of Object.entries(this.modes)) made.setAttribute("aria-pressed", mode === this.mode);
    this.list();
    if (!model) {
      this.problem.textContent = "";
      const others = this.desk.documents.filter((one) => one.model);
      this.centre.replaceChildren(el("div", { class: "empty" }, el("h1", {}, this.desk.current ? "This file holds a net, no model." : "No model is open."), el("p", {}, "Open a file of a relational model or a CPRM, or begin a new model."), el("div", { class: "bar" }, ...others.slice(0, 4).map((one) => el("button", { onclick: () => this.desk.show(one.id) }, one.name)), el("button", { onclick: () => openFile(this.desk) }, "Open…"), el("button", { class: "main", onclick: () => this.newModel() }, "New…"))));
      return;
    }
    if (!this.learning) this.problem.textContent = this.desk.current.problem ? `not finished: ${this.desk.current.problem}` : "";
    if (this.selection && this.forms.part(this.selection) === null) this.selection = null;
    this.middle();
  }

  middle() {
    if (!this.desk.model) return;
    if (this.mode === "graph") {
      this.centre.replaceChildren(this.graphPane);
      this.graph.show();
      return;
    }
    this.centre.replaceChildren(this.tablePane);
    this.forms.show(this.selection);
    const what = this.chosenCpd();
    if (what) this.table.show(what);
    else {
      this.table.show(null);
      this.tablePane.replaceChildren(el("div", { class: "empty" }, el("p", {}, "Select an attribute, or what a relation changes, to see its table.")));
    }
  }

  /** Which CPD the selection has. */
  chosenCpd() {
    const part = this.selection && this.forms.part(this.selection);
    if (!part || !["attribute", "change"].includes(this.selection.kind)) return null;
    const { path } = this.selection;
    const owner = this.desk.model.model[path[1]][path[2]].name;
    const kind = this.selection.kind === "change" ? "change" : path[1] === "classes" ? "class" : "relation";
    return { kind, owner, label: part.name ?? part.target, part: "cpd", cpd: part.cpd ?? { is: "Uniform" }, path: [...path, "cpd"] };
  }

  async newModel() {
    const name = await askText("A new model", { value: "model", action: "make" });
    if (name) await this.desk.bring("new", { kind: "model", name });
  }

  async learn() {
    const files = await this.desk.call("logs", {});
    const path = await pick("Learn the CPDs from a log", files.map((file) => [file, file]), { empty: `no .csv or .json logs in ${this.desk.root}`, hint: "CSV: a column for each variable, a row for each slice, an empty row between episodes; empty cells were not observed. Watch writes the readings of a run as a log (tab Percepts)." });
    if (!path) return;
    const how = await askHow();
    if (!how) return;
    this.learning = true;
    this.problem.classList.remove("bad");
    this.problem.textContent = `learning from ${path}, which takes a while where something is hidden …`;
    try {
      const state = await this.desk.call("model.learn", { id: this.desk.current.id, path, ...how });
      this.desk.take(state);
      const { learned } = state;
      const values = learned.log_likelihoods;
      this.studio.note(`learned ${learned.learned.length} CPDs from ${learned.slices} slices; ln P of the log ${(values.length > 1 ? [values[0], values.at(-1)] : values).map((v) => v.toFixed(2)).join(" → ")}`);
    } catch (error) {
      this.studio.note(error.message, "error");
    }
    this.learning = false;
    this.problem.classList.add("bad");
    this.changed();
  }
}

/** How a model is learned; null when it is not. */
function askHow() {
  return ask("How", (close) => {
    const method = choose([["em", "something is hidden or missing: EM"], ["count", "everything is in the log: count"]], "em", (value) => {
      iterations.disabled = value === "count";
      prior.value = value === "count" ? 1 : 0;
    }, { "aria-label": "method" });
    const prior = el("input", { type: "number", min: 0, step: "any", value: 0, required: true, "aria-label": "counts added to each state" });
    const iterations = el("input", { type: "number", min: 1, max: 1000, step: 1, value: 10, required: true, "aria-label": "iterations" });
    return el("form", { class: "rows", onsubmit: (event) => {
      event.preventDefault();
      close({ method: method.value, prior: Number(prior.value), iterations: Number(iterations.value) });
    } }, el("label", {}, "method", method), el("label", {}, "counts added to each state", prior), el("label", {}, "iterations of EM, at most", iterations),
    el("p", { class: "soft" }, "With 0 counts, EM leaves rows that the log does not speak of as they are; many counts draw large tables to what is uniform."),
    el("div", { class: "bar" }, el("span", { class: "room" }), el("button", { type: "button", onclick: () => close(null) }, "cancel"), el("button", { class: "main" }, "learn")));
  });
}

function kindOf(domain) {
  return { Labels: `${domain.names?.length} states`, Bins: `${(domain.edges?.length ?? 1) - 1} bins`, Real: "real", Angle: "angle" }[domain.is] ?? "";
}
