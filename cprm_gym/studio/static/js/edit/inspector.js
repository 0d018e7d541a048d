// What is selected in a net, with everything that can be said about it: a form beside the canvas.

import { el } from "../dom.js";
import { expressionField, field, numberOf } from "./fields.js";

const KINDS = [["place", "discrete"], ["continuous", "continuous"], ["input", "input"], ["belief", "belief"], ["math", "math"], ["object", "object"]];
const ROLES = ["", "begin", "ongoing", "done", "errors", "interrupts", "inputs", "outputs", "parameters"];
const ARCS = { inputs: ["input", "takes", "weight"], tests: ["test", "needs", "at least"], inhibitors: ["inhibitor", "prevented by", "from"], outputs: ["output", "puts", "weight"], sets: ["set", "sets", "to"] };
const VIEWS = ["expectation", "variance", "mode", "probability", "entropy"];
/** Fields that a place of a kind needs when a place is made one. */
export const NEEDED = { math: { expression: "0" }, belief: { variable: "object.attribute" }, object: { class_name: "Object" } };

export class Inspector {
  constructor(root, desk, { definition, open, select }) {
    Object.assign(this, { root, desk, definition, open, select });
  }

  /** Show what these keys of the canvas mean. */
  show(keys) {
    this.keys = keys;
    const focused = this.root.contains(document.activeElement) ? document.activeElement.closest(".entry")?.querySelector("label")?.textContent : null;
    const own = this.own;
    if (!own) this.root.replaceChildren();
    else if (keys.length === 0) this.root.replaceChildren(...this.net(own));
    else if (keys.length > 1) this.root.replaceChildren(...this.several(keys));
    else this.root.replaceChildren(...this.one(keys[0], own));
    if (focused) [...this.root.querySelectorAll(".entry")].find((row) => row.querySelector("label").textContent === focused)?.input.focus();
  }

  get own() {
    return this.desk.net?.definitions[this.definition()];
  }

  apply(op) {
    return this.desk.apply({ in: this.definition(), ...op });
  }

  change(name, fields) {
    return this.apply({ op: "change", name, fields });
  }

  async rename(name, to) {
    const wrong = await this.apply({ op: "rename", name, to });
    if (!wrong) this.select([to]);
    return wrong;
  }

  remove(keys) {
    return el("button", { class: "danger", onclick: () => this.root.dispatchEvent(new CustomEvent("remove", { detail: { keys }, bubbles: true })) }, "remove");
  }

  one(key, own) {
    const place = own.places.find((p) => p.name === key);
    if (place) return this.place(place, own);
    const transition = own.transitions.find((t) => t.name === key);
    if (transition) return this.transition(transition, own);
    if (own.modules?.[key]) return this.instance(key, own);
    if (key.includes("\t")) return this.arc(key, own);
    const [instance] = key.split(".");
    const module = own.modules?.[instance];
    if (!module) return [el("p", { class: "soft" }, key)];
    const port = key.slice(instance.length + 1);
    const inside = this.desk.net.definitions[module];
    const parts = [el("h3", {}, key), el("p", { class: "soft" }, `inside the module ${module}`), el("button", { onclick: () => this.open(module, port) }, `open ${module}`)];
    if (portsOf(inside).includes(port)) parts.splice(2, 0, this.fusion(key, own));
    return parts;
  }

  // -- a place ----------------------------------------------------------------------------------------------------------------------

  place(place, own) {
    const kind = place.kind ?? "place";
    const set = (name) => (value) => this.change(place.name, { [name]: value === "" ? null : value });
    const number = (name) => (value) => this.change(place.name, { [name]: numberOf(value) });
    const check = (text, candidate) => this.desk.call("expression", { id: this.desk.current.id, definition: this.definition(), text, candidate });
    const rows = [el("h3", {}, "Place"), field("name", place.name, (to) => this.rename(place.name, to)),
      field("kind", kind, (to) => this.change(place.name, { kind: to, ...(NEEDED[to] ?? {}) }), { options: KINDS })];
    if (kind === "place") {
      rows.push(field("tokens", place.tokens ?? 0, number("tokens"), { type: "number" }), field("capacity", place.capacity ?? "", number("capacity"), { type: "number", hint: "empty: unbounded" }));
    } else if (kind === "continuous") rows.push(field("value", place.value ?? 0, number("value"), { type: "number", step: "any" }));
    else if (kind === "input") {
      rows.push(field("observes", place.observes ?? place.name, set("observes"), { hint: "the percept that sets it in every cycle" }), field("value", place.value ?? 0, number("value"), { type: "number", step: "any", hint: "until the first observation" }));
    } else if (kind === "belief") {
      const view = place.view ?? "expectation";
      rows.push(field("variable", place.variable, set("variable"), { hint: "of the model, such as ball.distance" }),
        field("view", view, (to) => this.change(place.name, to === "probability" ? { view: to, state: place.state || "yes" } : { view: to, state: null }), { options: [...new Set([...VIEWS, view])] }));
      if (view === "probability") rows.push(field("state", place.state ?? "", set("state")));
      rows.push(field("value", place.value ?? 0, number("value"), { type: "number", step: "any", hint: "before the first inference" }));
    } else if (kind === "math") {
      rows.push(expressionField("expression", place.expression, set("expression"), check), field("default", place.default ?? 0, number("default"), { type: "number", step: "any", hint: "while an object that it reads is absent" }));
    } else if (kind === "object") {
      rows.push(field("class", place.class_name, (to) => this.change(place.name, { class_name: to, ...(place.select ? { select: { ...place.select, class_name: to } } : {}) })));
      const select = place.select;
      const candidate = place.class_name.toLowerCase();
      const put = (name, value) => this.change(place.name, { select: Object.fromEntries(Object.entries({ ...select, [name]: value }).filter(([, v]) => v !== "" && v !== null && v !== false)) });
      rows.push(field("selects", Boolean(select), (on) => this.change(place.name, { select: on ? { class_name: place.class_name, best: `${candidate}.distance` } : null }), { type: "checkbox", hint: "receives the best object of the class in every cycle" }));
      if (select) {
        rows.push(expressionField("best", select.best, (v) => put("best", v), (t) => check(t, candidate), { hint: "ranks the candidates" }),
          expressionField("where", select.where ?? "", (v) => put("where", v), (t) => check(t, candidate), { optional: true, hint: "what a candidate must meet" }),
          field("rank", select.k ?? 1, (v) => put("k", Number(v)), { type: "number" }), field("smallest first", Boolean(select.minimize), (v) => put("minimize", v), { type: "checkbox" }));
      }
    }
    rows.push(field("port", roleOf(own, place.name), (role) => this.apply({ op: "port", place: place.name, role }), { options: ROLES.map((role) => [role, role || "no port"]) }));
    rows.push(...this.arcsOfPlace(place.name, own), this.remove([place.name]));
    return rows;
  }

  arcsOfPlace(name, own) {
    const rows = [];
    for (const transition of own.transitions) {
      for (const [key, [arc, word, what]] of Object.entries(ARCS)) {
        if (transition[key]?.[name] !== undefined) rows.push(this.arcRow(arc, word, what, transition.name, name, transition, transition[key][name]));
      }
    }
    return rows.length ? [el("h3", {}, "Arcs"), ...rows] : [];
  }

  // -- a transition -----------------------------------------------------------------------------------------------------------------

  transition(t, own) {
    const number = (name) => (value) => this.change(t.name, { [name]: numberOf(value) });
    const rows = [el("h3", {}, "Transition"), field("name", t.name, (to) => this.rename(t.name, to)),
      field("delay", t.delay ?? 0, number("delay"), { type: "number", hint: "cycles; 0 fires at once" }), field("priority", t.priority ?? 0, number("priority"), { type: "number" }), ...this.command(t)];
    const more = el("details", { open: ["weight", "memory", "servers", "set_wins"].some((k) => k in t) || this.more }, el("summary", {}, "more"),
      field("weight", t.weight ?? 1, number("weight"), { type: "number", step: "any", hint: "share in a random choice" }),
      field("memory", t.memory ?? "enabling", (v) => this.change(t.name, { memory: v }), { options: ["enabling", "age", "resampling"] }),
      field("servers", t.servers ?? 1, number("servers"), { type: "number", hint: "-1: as many as it is enabled" }),
      field("set arcs win", Boolean(t.set_wins), (v) => this.change(t.name, { set_wins: v || null }), { type: "checkbox" }));
    more.addEventListener("toggle", () => { this.more = more.open; });
    rows.push(more, el("h3", {}, "Arcs"));
    for (const [key, [arc, word, what]] of Object.entries(ARCS)) {
      for (const [place, weight] of Object.entries(t[key] ?? {})) rows.push(this.arcRow(arc, word, what, place, place, t, weight));
    }
    rows.push(this.newArc(t, own), this.remove([t.name]));
    return rows;
  }

  command(t) {
    const emits = t.emits;
    const put = (value) => this.change(t.name, { emits: value });
    const rows = [field("command", emits?.command ?? "", (name) => put(name ? { command: name, params: emits?.params ?? {} } : null), { hint: "what it sends to the body; empty for none" })];
    if (emits) {
      const text = Object.entries(emits.params ?? {}).map(([k, v]) => `${k} = ${v}`).join("\n");
      rows.push(field("parameters", text, (value) => {
        const params = {};
        for (const line of value.split("\n").filter((l) => l.trim())) {
          const [key, of] = line.split("=").map((part) => part.trim());
          if (!key || !of) return "a line is: parameter = place, or parameter = number";
          params[key] = Number.isFinite(Number(of)) ? Number(of) : of;
        }
        return put({ command: emits.command, params });
      }, { multiline: true, hint: "one a line: power = 60, or direction = aim (a place)" }));
    }
    return rows;
  }

  arcRow(arc, word, what, shown, place, transition, weight) {
    const error = el("div", { class: "wrong" });
    const input = el("input", { type: "number", step: "any", value: weight, "aria-label": `${what} of the ${arc} arc with ${shown}`, onchange: async () => {
      error.textContent = await this.apply({ op: "connect", place, transition: transition.name, arc, weight: Number(input.value) });
    } });
    const drop = async () => { error.textContent = await this.apply({ op: "disconnect", place, transition: transition.name, arc }); };
    return el("div", { class: "arcrow" }, el("span", { class: "soft" }, word), el("button", { class: "plain", onclick: () => this.select([shown]) }, shown), el("span", { class: "soft" }, what), input,
      el("button", { "aria-label": `remove the ${arc} arc with ${shown}`, title: "remove this arc", onclick: drop }, "×"), error);
  }

  newArc(t, own) {
    const places = [...own.places.map((p) => p.name), ...Object.entries(own.modules ?? {}).flatMap(([i, target]) => portsOf(this.desk.net.definitions[target]).map((port) => `${i}.${port}`))];
    const kind = el("select", { "aria-label": "kind of arc" }, ...Object.values(ARCS).map(([arc, word]) => el("option", { value: arc }, word)));
    const place = el("select", { "aria-label": "place" }, ...places.map((name) => el("option", { value: name }, name)));
    const error = el("div", { class: "wrong" });
    const add = async () => { error.textContent = await this.apply({ op: "connect", place: place.value, transition: t.name, arc: kind.value }); };
    return el("div", { class: "arcrow" }, kind, place, el("button", { onclick: add }, "add arc"), error);
  }

  arc(key, own) {
    const [style, source, target] = key.split("\t");
    const transition = own.transitions.find((t) => t.name === source || t.name === target);
    const place = transition?.name === source ? target : source;
    const kind = style === "arc" ? (transition?.name === target ? "inputs" : "outputs") : { test: "tests", inhibitor: "inhibitors", set: "sets" }[style];
    if (!transition || !kind || transition[kind]?.[place] === undefined) {
      const words = { operand: "The value of the one goes into the expression of the other.", parameter: "The value is a parameter of the command.", fuse: "The port and the place are one place." };
      return [el("h3", {}, `${source} → ${target}`), el("p", { class: "soft" }, words[style] ?? "")];
    }
    const [arc, word, what] = ARCS[kind];
    return [el("h3", {}, `${arc} arc`), el("p", {}, `${transition.name} ${word} ${place}`), this.arcRow(arc, word, what, place, place, transition, transition[kind][place])];
  }

  // -- modules ----------------------------------------------------------------------------------------------------------------------

  instance(name, own) {
    const module = own.modules[name];
    const inside = this.desk.net.definitions[module];
    return [el("h3", {}, "Module"), field("name", name, (to) => this.rename(name, to)), el("p", {}, "an instance of ", el("button", { class: "plain", onclick: () => this.open(module) }, module)),
      el("h3", {}, "Ports"), ...portsOf(inside).map((port) => this.fusion(`${name}.${port}`, own)), this.remove([name])];
  }

  fusion(port, own) {
    const places = own.places.map((p) => p.name);
    const now = own.fuse?.[port] ?? "";
    const options = [["", "a place of its own"], ...[...new Set([...places, ...(now ? [now] : [])])].map((name) => [name, `= ${name}`])];
    return field(port.slice(port.indexOf(".") + 1), now, (place) => this.apply({ op: "fuse", port, place }), { options });
  }

  several(keys) {
    return [el("h3", {}, `${keys.length} parts`), el("p", { class: "soft" }, "Drag or Alt+arrows move them together."), this.remove(keys)];
  }

  // -- the net itself ---------------------------------------------------------------------------------------------------------------

  net(own) {
    const key = this.definition();
    const ports = own.ports ?? {};
    const semantics = own.semantics ?? {};
    const options = (name, values) => field(name, semantics[name] ?? values[0], (v) => this.apply({ op: "semantics", fields: { [name]: v === values[0] ? null : v } }), { options: values });
    const rows = [el("h3", {}, "Net"), field("name", key, async (to) => {
      const wrong = await this.desk.apply({ op: "rename_net", name: key, to });
      if (!wrong) this.open(to);
      return wrong;
    }), el("p", { class: "soft" }, `${own.places.length} places, ${own.transitions.length} transitions, ${Object.keys(own.modules ?? {}).length} modules`)];
    if (this.desk.net.net !== key) rows.push(el("button", { onclick: () => this.desk.try({ op: "main", name: key }) }, "make it the net of the file"));
    const listed = ROLES.slice(1).flatMap((role) => [ports[role] ?? []].flat().map((name) => el("tr", {}, el("td", { class: "soft" }, role), el("td", {}, el("button", { class: "plain", onclick: () => this.select([name]) }, name)))));
    if (listed.length) {
      rows.push(el("h3", {}, "Ports"), el("table", {}, ...listed), field("answered within", ports.within ?? 1, (v) => this.apply({ op: "ports", fields: { within: Number(v) === 1 ? null : Number(v) } }), { type: "number", hint: "cycles, for interrupts" }),
        field("interrupts while idle", ports.idle_interrupts ?? "consumed", (v) => this.apply({ op: "ports", fields: { idle_interrupts: v === "consumed" ? null : v } }), { options: ["consumed", "kept"] }));
    }
    rows.push(el("details", {}, el("summary", {}, "semantics"), options("capacity", ["strong", "weak"]), options("persistence", ["intermediate", "atomic"]), options("choice", ["declared", "random"])));
    return rows;
  }
}

export function portsOf(definition) {
  const ports = definition?.ports ?? {};
  return ROLES.slice(1).flatMap((role) => [ports[role] ?? []].flat());
}

function roleOf(definition, place) {
  const ports = definition.ports ?? {};
  return ROLES.slice(1).find((role) => [ports[role] ?? []].flat().includes(place)) ?? "";
}
