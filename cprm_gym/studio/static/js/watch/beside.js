// Another run with the same seed beside the one that is watched: its field and its net, and what differs, marked in both.

import { el, refill } from "../dom.js";
import { short } from "./beliefs.js";
import { Field, nameOf } from "./field.js";
import { NetView } from "./netview.js";

const MOST = 60; // rows of one kind
const whole = (value) => (Number.isInteger(value) ? `${value}` : short(value));
const words = (status) => status.replaceAll("_", " ").toLowerCase();

/** What an agent does in a cycle, in a line. */
function says(frame, agent) {
  if (frame.over) return `${words(frame.status)} in cycle ${frame.cycle}`;
  const inner = frame.agents[agent];
  return `${frame.commands[agent] || "no command"}${inner?.fired?.length ? `; fired ${inner.fired.join(", ")}` : ""}`;
}

/**
 * The other run. `call` asks about it, `choose(key)` is told of a part of its net, `seek(key)` leads to a part in both, `look(cycle)` goes to a cycle.
 */
export class Beside {
  constructor({ call, note, choose, seek, moved, look, here }) {
    Object.assign(this, { call, note, seek, moved, look, here });
    this.on = false;
    this.field = new Field(() => {}, "field of the run beside");
    this.net = new NetView((name, given) => this.ask(name, given), choose, { follows: here.net });
    this.told = el("span", { class: "soft" });
    this.first = el("button", { class: "difference link", title: "show that cycle (d)", "data-show": "difference", onclick: () => this.toFirst() });
    this.saidHere = el("p", { class: "says", "data-show": "here" });
    this.said = el("p", { class: "says", "data-show": "there" });
    this.fieldPanel = el("div", { class: "panel field-there" }, el("div", { class: "bar" }, el("h2", {}, "There"), this.told, el("span", { class: "room" }), this.first), this.field.element, this.said);
    this.netPanel = el("div", { class: "panel net-there" }, this.net.element);
    this.element = el("div", { class: "differences", "data-show": "differences" });
  }

  /** Of the other run. */
  async ask(name, given = {}) {
    try {
      return await this.call(name, { ...given, beside: true });
    } catch (error) {
      this.note(error.message, "error");
      return null;
    }
  }

  /** Another run of the page. */
  begin(run) {
    this.run = run;
    this.field.begin(run);
    this.forget();
  }

  /** Nothing is asked of the other run any more, until there is one again. */
  forget() {
    this.made = this.inside = this.last = null;
    this.net.forget();
  }

  /** Ask what the agent is made of there, when it is another one or another run. */
  async learn(agent, other) {
    const wanted = `${agent} ${JSON.stringify(other.setup)}`;
    if (this.made === wanted) return;
    this.made = wanted;
    const inside = agent ? await this.ask("watch.inside", { agent }) : null;
    if (this.made !== wanted) return;
    this.inside = inside;
    await this.net.begin(agent, inside);
    if (this.last) this.draw(...this.last);
  }

  toFirst() {
    const first = this.frame?.other?.first;
    return first ? this.look(first.cycle) : null;
  }

  /** Names of the agent's net that differ in this cycle. */
  marked(frame, agent) {
    const of = frame.other?.differs?.agents?.[agent];
    return of ? [...new Set(["marking", "holds", "clocks", "fired", ...(this.here.net.quantities.checked ? ["quantities"] : [])].flatMap((kind) => of[kind] ?? []))] : [];
  }

  /** Show a cycle; `at` is what `NetView.draw` is given of a firing inside the cycle. */
  draw(frame, shown, at) {
    this.last = [frame, shown, at];
    this.frame = frame;
    const { other } = frame;
    if (!this.on || !other) return;
    const [agent] = shown;
    this.learn(agent, other);
    const differs = other.differs ?? {};
    this.field.show = this.here.field.show;
    this.field.draw({ ...other, changes: [], other: { world: frame.world } }, shown, { differs: differs.players, as: this.here.field });
    this.net.told.textContent = this.inside?.net ?? "";
    if (this.inside) this.net.draw(other.agents[agent], [], at, this.marked(frame, agent));
    const { controller, changed } = other.setup;
    const what = controller === this.run.controller ? (changed.length < this.run.changed.length ? "as it ships" : "nothing changed by hand") : `played by ${controller}`;
    this.told.textContent = other.cycle === frame.cycle ? what : `${what}; ended in cycle ${other.cycle}`;
    const unlike = differs.commands?.includes(agent) || differs.agents?.[agent]?.fired;
    for (const [line, of] of [[this.saidHere, frame], [this.said, other]]) {
      line.textContent = `${unlike ? "≠ " : ""}${says(of, agent)}`;
      line.title = line.textContent;
      line.classList.toggle("unlike", Boolean(unlike));
    }
    const { first } = other;
    this.first.disabled = !first;
    this.first.textContent = first ? `first difference in cycle ${first.cycle}` : "no difference so far";
    this.first.title = first ? `${first.what.join("; ")}: show that cycle (d)` : "";
  }

  /** All that differs in a cycle, in a table. */
  list(frame, agent) {
    const { other } = frame;
    if (!other) return;
    const { first } = other;
    const differs = other.differs ?? {};
    const rows = [...this.#commands(frame, differs), ...this.#objects(frame, differs), ...Object.keys(differs.agents ?? {}).flatMap((name) => this.#inside(frame, name, differs.agents[name], name === agent))];
    const now = first?.cycle === frame.cycle;
    refill(this.element,
      el("p", {}, first ? el("strong", {}, now ? "Here they differ first: " : `First difference in cycle ${first.cycle}: `) : "No difference so far. ", first ? first.what.slice(0, 2).join("; ") + (first.what.length > 2 ? " …" : "") : null,
        first && !now ? el("button", { class: "link", onclick: () => this.toFirst() }, " show it (d)") : null),
      rows.length ? el("table", {}, el("thead", {}, el("tr", {}, ...[`≠ in cycle ${frame.cycle}`, "", "here", "there"].map((h) => el("th", {}, h)))), el("tbody", {}, ...rows)) : el("p", { class: "soft" }, `In cycle ${frame.cycle} both are the same.`));
  }

  #row(kind, name, here, there, go = null) {
    return el("tr", { "data-differs": `${kind} ${name}` }, el("td", { class: "soft" }, kind), el("td", {}, go ? el("button", { class: "link", onclick: go }, name) : name), el("td", { class: "mono" }, here), el("td", { class: "mono" }, there));
  }

  #commands(frame, differs) {
    return (differs.commands ?? []).map((name) => this.#row("command", name, frame.commands[name] || "nothing", frame.other.commands[name] || "nothing"));
  }

  #objects(frame, differs) {
    const where = (world, number) => {
      const row = number === 0 ? [0, ...world.ball] : world.players.find((one) => one[0] === number);
      if (!row) return "–";
      return number === 0 ? `${short(row[1])}, ${short(row[2])}; moves ${short(row[3])}, ${short(row[4])}` : `${short(row[1])}, ${short(row[2])}; body ${row[3]}°, face ${row[4]}°`;
    };
    const rows = (differs.players ?? []).map((number) => this.#row("place", nameOf(number), where(frame.world, number), where(frame.other.world, number)));
    return differs.status ? [...rows, this.#row("outcome", "", ...differs.status.map(words))] : rows;
  }

  #inside(frame, agent, of, leads) {
    const [here, there] = [frame.agents[agent], frame.other.agents[agent]];
    const value = (inner, kind, name) => {
      const found = inner[kind]?.[name];
      if (kind === "marking" || kind === "quantities") return whole(inner.marking[name] ?? 0);
      if (found === undefined || found === null) return "–";
      if (kind === "clocks") return `${found[0]} of ${found[1]}`;
      if (kind === "beliefs") return found.mean !== undefined && found.mean !== null ? `${short(found.mean)} ± ${short(found.spread)}` : found.p.map((p) => p.toFixed(2)).join(" ");
      return typeof found === "number" ? short(found) : typeof found === "object" ? Object.values(found).map(short).join(", ") : `${found}`;
    };
    const row = (kind, word, go) => (of[kind] ?? []).slice(0, MOST).map((name) => this.#row(word, name, value(here, kind, name), value(there, kind, name), leads && go ? () => go(name) : null));
    const times = (inner, name) => { const n = inner.fired.filter((one) => one === name).length; return n ? (n === 1 ? "fired" : `fired ${n} times`) : "–"; };
    const fired = (of.fired ?? []).slice(0, MOST).map((name) => this.#row("fired", name, times(here, name), times(there, name), leads ? () => this.seek(name) : null));
    return [...fired, ...row("commands", "sent"), ...row("marking", "marking", this.seek), ...row("holds", "holds", this.seek), ...row("clocks", "clock", this.seek), ...row("beliefs", "belief", this.moved), ...row("evidence", "reading"), ...row("quantities", "quantity", this.seek),
      ...(of.relations ?? []).map((name) => this.#row("relation", name, here.relations.includes(name) ? "in force" : "–", there.relations.includes(name) ? "in force" : "–"))];
  }
}
