// Forms for the parts of a model: classes, attributes, domains, CPDs, relations, objects.

import { el } from "../dom.js";
import { expressionField, field, numberOf } from "./fields.js";

const CPDS = ["Uniform", "Prior", "Table", "Noise", "Chance", "Switch", "Mixture", "NoisyOr", "Dense"];
const AGGREGATES = { exists: ["Exists", "state"], all: ["All", "state"], count: ["Count", "state", "at_most"], min: ["Min"], max: ["Max"], mean: ["Mean", "empty"], any_cause: ["AnyCause", "state", "strength", "leak"] };
const CONFLICTS = ["exclusive", "priority", "mean", "noisy-or", "mixture"];
const numbers = (text) => text.split(/[\s,;]+/).filter(Boolean).map(Number);
const words = (text) => text.split(/[\s,;]+/).filter(Boolean);
const listed = (values) => (values ?? []).join(", ");

/** A parent as it is written in a form: `prev.dist`, or `exists(others.near, yes)`. */
export function parentText(parent) {
  if (typeof parent === "string") return parent;
  const [verb, [, ...fields]] = Object.entries(AGGREGATES).find(([, [name]]) => name === parent.is) ?? [parent.is, [parent.is]];
  const last = fields.reduce((n, name, i) => (name in parent ? i + 1 : n), 0);
  const usual = { state: "yes", at_most: 1, empty: "", strength: 1, leak: 0 };
  return `${verb}(${[parent.path, ...fields.slice(0, last).map((name) => parent[name] ?? usual[name])].join(", ")})`;
}

/** How a parent is called in expressions. */
function nameOf(parent) {
  if (typeof parent === "string") return parent;
  const verb = Object.entries(AGGREGATES).find(([, [name]]) => name === parent.is)?.[0] ?? parent.is;
  return `${verb}(${parent.path}${parent.is === "Min" || parent.is === "Max" || parent.is === "Mean" ? "" : `=${parent.state ?? "yes"}`})`;
}

export function parentOf(text) {
  const call = /^(\w+)\((.*)\)$/.exec(text.trim());
  if (!call || !AGGREGATES[call[1]]) return text.trim();
  const [is, ...fields] = AGGREGATES[call[1]];
  const [path, ...given] = call[2].split(",").map((part) => part.trim());
  const made = { is, path };
  given.forEach((value, i) => {
    if (fields[i]) made[fields[i]] = ["at_most", "strength", "leak"].includes(fields[i]) ? Number(value) : value;
  });
  return made;
}

export class ModelForms {
  constructor(root, desk, { select }) {
    Object.assign(this, { root, desk, select });
  }

  get model() {
    return this.desk.model.model;
  }

  apply(op) {
    return this.desk.apply(op, "model");
  }

  set(path, value) {
    return this.apply({ op: "set", path, value: value === "" || value === undefined ? null : value });
  }

  /** What a selection {kind, path} means, or null when it is no longer there. */
  part(selection) {
    let at = { ...this.desk.model, objects: this.desk.current.data.objects ?? {} };
    for (const step of selection.path) at = at?.[step];
    return at ?? null;
  }

  show(selection) {
    this.selection = selection;
    const part = selection && this.part(selection);
    const focused = this.root.contains(document.activeElement) ? document.activeElement.closest(".entry")?.querySelector("label")?.textContent : null;
    const makers = { class: this.class, attribute: this.attribute, given: this.given, reference: this.reference, relation: this.relation, change: this.change, object: this.object };
    const rows = part !== null && part !== undefined && selection ? makers[selection.kind].call(this, part, selection.path) : this.whole();
    this.root.replaceChildren(...rows.flat(3).filter(Boolean));
    if (focused) [...this.root.querySelectorAll(".entry")].find((row) => row.querySelector("label").textContent === focused)?.input.focus();
  }

  owner(path) {
    return this.model[path[1]][path[2]];
  }

  rename(what, name, owner) {
    return (to) => this.apply({ op: "rename", what, name, to, ...(owner ? { owner } : {}) });
  }

  remove(path) {
    return el("button", { class: "danger", onclick: async () => {
      if (await this.desk.try(typeof path.at(-1) === "number" ? { op: "remove", path } : { op: "set", path, value: null }, "model")) this.select(null);
    } }, "remove");
  }

  add(label, path, value) {
    return el("button", { onclick: () => this.desk.try({ op: "insert", path, value }, "model") }, label);
  }

  whole() {
    const { model } = this;
    return [el("h3", {}, "Model"), field("name", model.name, (to) => this.set(["model", "name"], to)), el("p", { class: "soft" }, `${(model.classes ?? []).length} classes, ${(model.relations ?? []).length} relations, ${Object.keys(this.desk.current.data.objects ?? {}).length} objects`)];
  }

  class(c, path) {
    const others = this.model.classes.map((one) => one.name).filter((name) => name !== c.name);
    const at = (list) => [...path, list, (c[list] ?? []).length];
    const name = (wanted) => free(wanted, ["attributes", "references", "given"].flatMap((list) => (c[list] ?? []).map((one) => one.name)));
    return [el("h3", {}, "Class"), field("name", c.name, this.rename("class", c.name)), field("extends", c.extends ?? "", (to) => this.set([...path, "extends"], to), { options: [["", "nothing"], ...others] }),
      field("abstract", c.abstract ?? false, (on) => this.set([...path, "abstract"], on || null), { type: "checkbox", hint: "has no objects of its own" }),
      el("div", { class: "bar" }, this.add("+ attribute", at("attributes"), { is: "Attribute", name: name("attribute"), domain: { is: "Labels", names: ["no", "yes"] } }),
        this.add("+ reference", at("references"), { is: "Reference", name: name("reference"), target: others[0] ?? c.name }), this.add("+ given", at("given"), { is: "Given", name: name("given"), domain: { is: "Labels", names: ["no", "yes"] } })), this.remove(path)];
  }

  attribute(a, path) {
    const owner = this.owner(path);
    const inClass = path[1] === "classes";
    return [el("h3", {}, `${owner.name}.${a.name}`), field("name", a.name, this.rename("attribute", a.name, owner.name)), this.domain(a.domain, [...path, "domain"], inClass ? { owner: owner.name, attribute: a.name } : null),
      field("static", a.static ?? false, (on) => this.set([...path, "static"], on || null), { type: "checkbox", hint: "drawn once, when the object begins to exist" }), this.parents(a, path), el("h3", {}, "CPD"), this.cpd(a.cpd ?? { is: "Uniform" }, [...path, "cpd"], a.parents ?? []), this.initial(a, path), this.remove(path)];
  }

  given(g, path) {
    const owner = this.owner(path);
    return [el("h3", {}, `${owner.name}.${g.name}`), field("name", g.name, this.rename("given", g.name, owner.name)), this.domain(g.domain, [...path, "domain"], { owner: owner.name, attribute: g.name }),
      field("default", g.default ?? "", (v) => this.set([...path, "default"], v === "" ? null : Number.isFinite(Number(v)) ? Number(v) : v)), this.remove(path)];
  }

  reference(r, path) {
    const owner = this.owner(path);
    return [el("h3", {}, `${owner.name}.${r.name}`), field("name", r.name, this.rename("reference", r.name, owner.name)), field("to", r.target, (v) => this.set([...path, "target"], v), { options: this.model.classes.map((c) => c.name) }), field("many", r.many ?? false, (on) => this.set([...path, "many"], on || null), { type: "checkbox" }), this.remove(path)];
  }

  parents(a, path) {
    const commit = (key) => (text) => this.set([...path, key], text.trim() ? text.split("\n").filter((l) => l.trim()).map(parentOf) : null);
    return [field("parents", (a.parents ?? []).map(parentText).join("\n"), commit("parents"), { multiline: true, hint: "one a line: zone, ball.zone, prev.dist, exists(others.near, yes)" })];
  }

  initial(a, path) {
    const on = a.initial !== undefined;
    const toggle = field("own first slice", on, (yes) => (yes ? this.set([...path, "initial"], { is: "Uniform" }) : this.apply({ op: "all", what: "initial", ops: [{ op: "set", path: [...path, "initial"], value: null }, { op: "set", path: [...path, "initial_parents"], value: null }] })), { type: "checkbox", hint: "where something has no previous value" });
    if (!on) return [toggle];
    const commit = (text) => this.set([...path, "initial_parents"], text.trim() ? text.split("\n").filter((l) => l.trim()).map(parentOf) : null);
    return [toggle, field("its parents", (a.initial_parents ?? []).map(parentText).join("\n"), commit, { multiline: true }), this.cpd(a.initial, [...path, "initial"], a.initial_parents ?? [])];
  }

  domain(d, path, rename) {
    const put = (key) => (value) => this.set([...path, key], value);
    const make = { Labels: { is: "Labels", names: ["no", "yes"] }, Bins: { is: "Bins", edges: [0, 1, 2, 4] }, Real: { is: "Real", unit: "m" }, Angle: { is: "Angle" } };
    const rows = [field("states", d.is, (kind) => this.set(path, make[kind]), { options: [["Labels", "names"], ["Bins", "bins of a number"], ["Real", "a real number"], ["Angle", "an angle"]] })];
    if (d.is === "Labels") {
      rows.push(field("names", listed(d.names), (text) => put("names")(words(text)), { hint: "parted by commas" }));
      if (rename) {
        const which = el("select", { "aria-label": "state" }, ...d.names.map((name) => el("option", {}, name)));
        const to = el("input", { "aria-label": "new name of the state", size: 8 });
        const error = el("div", { class: "wrong" });
        const go = async () => { error.textContent = to.value.trim() ? await this.apply({ op: "rename_state", ...rename, name: which.value, to: to.value.trim() }) : "a name is needed"; };
        rows.push(el("div", { class: "arcrow" }, el("span", { class: "soft" }, "rename state"), which, to, el("button", { onclick: go }, "rename"), error));
      }
    } else if (d.is === "Bins") {
      rows.push(field("edges", listed(d.edges), (text) => put("edges")(numbers(text)), { multiline: true }), field("unit", d.unit ?? "", put("unit")), field("circular", d.circular ?? false, (on) => put("circular")(on || null), { type: "checkbox" }), field("clip", d.clip ?? false, (on) => put("clip")(on || null), { type: "checkbox", hint: "values outside count as in the end bin" }));
    } else {
      if (d.is === "Real") rows.push(field("from", d.low ?? "", (v) => put("low")(numberOf(v)), { type: "number", step: "any" }), field("to", d.high ?? "", (v) => put("high")(numberOf(v)), { type: "number", step: "any" }));
      rows.push(field("unit", d.unit ?? "", put("unit")), field("bins", listed(d.bins?.edges), (text) => put("bins")(text.trim() ? { ...(d.bins ?? { is: "Bins", ...(d.is === "Angle" ? { circular: true } : {}) }), edges: numbers(text) } : null), { multiline: true, hint: "edges, for engines that know states only" }));
    }
    return rows;
  }

  /** The form of a CPD; a table's numbers are edited in the table itself. */
  cpd(c, path, parents) {
    const put = (key) => (value) => this.set([...path, key], value);
    const first = parentText(parents.find((p) => typeof p === "string") ?? "parent");
    const make = { Uniform: {}, Prior: { p: [0.5, 0.5] }, Table: { rows: [[parents.map(() => "*"), [0.5, 0.5]]] }, Noise: { mean: first, sd: 1 }, Chance: { p: "0.5" }, Switch: { parent: first, cases: [["*", { is: "Uniform" }]] }, Mixture: { parts: [[0.5, { is: "Uniform" }], [0.5, { is: "Uniform" }]] }, NoisyOr: { strengths: parents.map(() => 0.9) }, Dense: { values: [0.5, 0.5] } };
    const number = (key) => (value) => put(key)(Number.isFinite(Number(value)) && value !== "" ? Number(value) : value);
    const check = (text) => this.desk.call("model.expression", { id: this.desk.current.id, text, names: parents.map(nameOf) });
    const rows = [field("kind", c.is, (kind) => this.fitting(kind, make[kind], path), { options: CPDS })];
    if (c.is === "Prior") rows.push(field("chances", listed(c.p), (text) => put("p")(numbers(text))));
    if (c.is === "Noise") rows.push(expressionField("mean", c.mean, put("mean"), check, { hint: "an expression in the parents" }), expressionField("deviation", c.sd ?? 0, number("sd"), check, { hint: "a number, or an expression: 0.05 * prev.dist" }), field("shape", c.shape ?? "normal", (v) => put("shape")(v === "normal" ? null : v), { options: ["normal", "uniform"] }), field("floor", c.floor ?? 1e-6, number("floor"), { hint: "share that is uniform" }));
    if (c.is === "Chance") rows.push(expressionField("chance", c.p, put("p"), check, { hint: "of the second state: 0.95 if abs(dir) < 1 else 0.03" }), field("floor", c.floor ?? 0, number("floor")));
    if (c.is === "NoisyOr") rows.push(field("strengths", listed(c.strengths), (text) => put("strengths")(numbers(text)), { hint: "one for each parent" }), field("leak", c.leak ?? 0, number("leak")));
    if (c.is === "Dense") rows.push(el("p", { class: "soft" }, "A whole table of numbers; edit it in the table."));
    if (c.is === "Table") rows.push(el("p", { class: "soft" }, `${c.rows.length} written rows; * is any state, the first that fits counts. Edit cells in the table.`), ...c.rows.map(([key, row], i) => el("div", { class: "arcrow mono" }, el("input", { class: "long", "aria-label": `states of row ${i + 1}`, value: [key].flat().join(" "), onchange: (event) => this.desk.try({ op: "set", path: [...path, "rows", i, 0], value: words(event.target.value) }, "model") }),
      el("input", { class: "long", "aria-label": `chances of row ${i + 1}`, value: row.join(" "), onchange: (event) => this.desk.try({ op: "set", path: [...path, "rows", i, 1], value: numbers(event.target.value) }, "model") }), el("button", { "aria-label": `remove row ${i + 1}`, onclick: () => this.desk.try({ op: "remove", path: [...path, "rows", i] }, "model") }, "×"))), this.add("+ row", [...path, "rows", 0], [parents.map(() => "*"), c.rows[0]?.[1] ?? [0.5, 0.5]]));
    if (c.is === "Switch") rows.push(field("on", c.parent, put("parent"), { options: [...new Set([c.parent, ...parents.map(parentText)])] }), ...c.cases.map(([state, inner], i) => el("fieldset", {}, el("legend", {}, el("input", { value: state, size: 8, "aria-label": "case", onchange: (event) => this.desk.try({ op: "set", path: [...path, "cases", i, 0], value: event.target.value }, "model") }), el("button", { "aria-label": `remove case ${state}`, onclick: () => this.desk.try({ op: "remove", path: [...path, "cases", i] }, "model") }, "×")), ...this.cpd(inner, [...path, "cases", i, 1], parents.filter((p) => parentText(p) !== c.parent)).flat(2))), this.add("+ case", [...path, "cases", 0], ["state", { is: "Uniform" }]));
    if (c.is === "Mixture") rows.push(...c.parts.map(([weight, inner], i) => el("fieldset", {}, el("legend", {}, el("input", { type: "number", step: "any", value: weight, "aria-label": "weight", onchange: (event) => this.weights(c, path, i, Number(event.target.value)) })), ...this.cpd(inner, [...path, "parts", i, 1], parents).flat(2))));
    return rows;
  }

  /** Another kind of CPD; tables and priors are made with as many chances as the attribute has states. */
  fitting(kind, fields, path) {
    const at = this.part({ path: path.slice(0, path.findIndex((step) => step === "cpd" || step === "initial")) });
    const target = at.domain ?? this.domainOf(at.target, path);
    const n = target?.names?.length ?? (target?.edges ? target.edges.length - 1 : target?.bins?.edges ? target.bins.edges.length - 1 : 2);
    const even = Array.from({ length: n }, () => 1 / n);
    if (kind === "Prior") fields.p = even;
    if (kind === "Table") fields.rows[0][1] = even;
    return this.set(path, { is: kind, ...fields });
  }

  domainOf(target, path) {
    const [role, name] = (target ?? "").split(".");
    const relation = this.model.relations?.[path[2]];
    let of = this.model.classes.find((c) => c.name === (relation?.roles ?? []).find(([r]) => r === role)?.[1]);
    while (of) {
      const found = (of.attributes ?? []).find((a) => a.name === name);
      if (found) return found.domain;
      of = this.model.classes.find((c) => c.name === of.extends);
    }
    return null;
  }

  weights(c, path, i, value) {
    const rest = c.parts.reduce((sum, [w], k) => sum + (k === i ? 0 : w), 0) || 1;
    const ops = c.parts.map(([w], k) => ({ op: "set", path: [...path, "parts", k, 0], value: k === i ? value : (w / rest) * (1 - value) }));
    return this.desk.try({ op: "all", ops, what: "weight" }, "model");
  }

  relation(r, path) {
    const roles = r.roles.map(([role, c]) => `${role}: ${c}`).join("\n");
    const targets = r.roles.flatMap(([role, name]) => (this.model.classes.find((c) => c.name === name)?.attributes ?? []).map((a) => `${role}.${a.name}`)).filter((t) => !(r.changes ?? []).some((c) => c.target === t));
    const target = el("select", { "aria-label": "what is changed" }, ...targets.map((t) => el("option", {}, t)));
    const add = (is) => this.desk.try({ op: "insert", path: [...path, "changes", (r.changes ?? []).length], value: { is, target: target.value } }, "model");
    return [el("h3", {}, "Relation"), field("name", r.name, this.rename("relation", r.name)),
      field("roles", roles, (text) => this.set([...path, "roles"], text.split("\n").filter((l) => l.trim()).map((l) => l.split(":").map((p) => p.trim()))), { multiline: true, hint: "one a line: holder: Player" }),
      field("conflict", r.conflict ?? "exclusive", (v) => this.set([...path, "conflict"], v === "exclusive" ? null : v), { options: CONFLICTS, hint: "when several change one variable" }), field("priority", r.priority ?? 0, (v) => this.set([...path, "priority"], Number(v) || null), { type: "number" }),
      el("h3", {}, "While it is in force"), el("p", { class: "soft" }, (r.changes ?? []).map((c) => `${c.is === "Add" ? "adds to" : "replaces"} ${c.target}`).join("; ") || "it changes nothing yet"),
      targets.length ? el("div", { class: "arcrow" }, target, el("button", { onclick: () => add("Replace") }, "replace"), el("button", { onclick: () => add("Add") }, "add parents")) : null,
      el("div", { class: "bar" }, this.add("+ own variable", [...path, "attributes", (r.attributes ?? []).length], { is: "Attribute", name: free("variable", [...r.roles.map(([n]) => n), ...(r.attributes ?? []).map((a) => a.name)]), domain: { is: "Labels", names: ["no", "yes"] } })), this.remove(path)];
  }

  change(c, path) {
    return [el("h3", {}, `${this.owner(path).name}: ${c.is === "Add" ? "adds to" : "replaces"} ${c.target}`), field("what", c.is, (is) => this.set([...path, "is"], is), { options: [["Replace", "replaces parents and CPD"], ["Add", "adds parents"]] }), this.parents(c, path), el("h3", {}, "CPD"), this.cpd(c.cpd ?? { is: "Uniform" }, [...path, "cpd"], c.parents ?? []), this.initial(c, path), this.remove(path)];
  }

  object(of, path) {
    const name = path[1];
    const references = this.desk.current.data.references?.[name] ?? {};
    const slots = this.slots(of);
    return [el("h3", {}, "Object"), field("name", name, async (to) => {
      const wrong = await this.apply({ op: "rename", what: "object", name, to });
      if (!wrong) this.select({ kind: "object", path: ["objects", to] });
      return wrong;
    }), field("class", of, (v) => this.set(path, v), { options: this.model.classes.filter((c) => !c.abstract).map((c) => c.name) }),
    ...slots.map((slot) => field(slot.name, listed(references[slot.name]), (text) => this.set(["references", name, slot.name], words(text).length ? words(text) : null), { hint: `${slot.many ? "objects" : "an object"} of ${slot.target}; empty: those that are obvious` })), this.remove(path)];
  }

  slots(name) {
    const c = this.model.classes.find((one) => one.name === name);
    return c ? [...(c.extends ? this.slots(c.extends) : []), ...(c.references ?? [])] : [];
  }
}

export function free(wanted, taken) {
  let [name, number] = [wanted, 1];
  while (taken.includes(name)) name = `${wanted}${(number += 1)}`;
  return name;
}
