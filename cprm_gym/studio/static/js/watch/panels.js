// What stands below the net: the answer to a question, breakpoints, the log of decisions, changes by hand, percepts.

import { choose, el, refill } from "../dom.js";
import { expressionLine } from "../edit/fields.js";
import { nameOf } from "./field.js";
import { observed, short } from "./beliefs.js";

const LOG = 300;

/** The answer to "why not?" and "what moved it?". */
export class Ask {
  constructor({ ask, seek, breakAt, moved, edit, curve }) {
    this.act = { ask, seek, breakAt, moved, edit, curve };
    this.body = el("div", {});
    this.when = el("p", { class: "soft", "data-show": "asked" });
    this.element = el("div", { class: "ask" }, this.body, this.when);
    this.clear();
  }

  clear() {
    this.of = null;
    this.stand(null);
    refill(this.body, el("p", { class: "soft" },
      "Choose a transition in the net to ask why it did not fire, a place to see what it holds, or a belief to see which reading moved it."));
  }

  /** What follows is of this cycle; `again()` asks the same of the one that is shown then. */
  asked(cycle, again) {
    this.of = { cycle, again };
    this.stand(cycle);
  }

  /** The cycle that is shown: an answer of another one says so. */
  stand(cycle) {
    if (this.of === null) return refill(this.when);
    const other = this.of.cycle === cycle ? null : el("button", { class: "link", "data-do": "again", onclick: () => this.of.again() }, `ask again in cycle ${cycle}`);
    return refill(this.when, `asked in cycle ${this.of.cycle}`, other && "; ", other);
  }

  #edit(part) {
    return el("button", { "data-do": "edit", title: "to this part in the view Nets (E)", onclick: () => this.act.edit(part) }, "edit (E)");
  }

  #curve(text) {
    return el("button", { title: "draw it over the last cycles, in Curves", onclick: () => this.act.curve(text) }, "curve");
  }

  wait(what) {
    refill(this.body, el("p", { class: "soft" }, `asking about ${what} …`));
  }

  fail(text) {
    refill(this.body, el("p", { class: "bad" }, text));
  }

  transition(answer, there = false) {
    const rows = answer.conditions.map((c) => {
      const need = [c.low === null ? "" : `≥ ${c.low}`, c.high === null ? "" : `< ${c.high}`].filter(Boolean).join(" and ");
      const since = c.holds ? "" : c.held !== undefined ? `since cycle ${c.held + 1}` : answer.first !== null ? `in all cycles shown, from ${answer.first}` : "";
      return el("tr", { class: c.holds ? "" : "fails" }, el("td", {}, c.holds ? "✓" : "✗"),
        el("td", {}, el("button", { class: "link", onclick: () => this.act.seek(c.place) }, c.place)), el("td", {}, need), el("td", {}, `has ${c.has}`),
        el("td", {}, c.holds ? "" : `by ${c.by}`), el("td", {}, since));
    });
    refill(this.body,
      el("div", { class: "bar" }, el("h3", {}, answer.transition, there ? el("span", { class: "soft" }, " there") : ""), el("span", { class: "room" }),
        el("button", { "data-do": "break", onclick: () => this.act.breakAt("fires", answer.transition) }, "stop when it fires (B)"), this.#edit(answer.transition)),
      el("p", { class: "answer", "data-show": "answer" }, answer.answer),
      answer.clock ? el("p", {}, answer.clock[0] < 0 ? `its clock of ${answer.clock[1]} cycles does not run` : `clock ${answer.clock[0]} of ${answer.clock[1]}`) : null,
      el("table", { class: "conditions" }, el("thead", {}, el("tr", {}, ...["", "place", "needs", "", "fails", ""].map((h) => el("th", {}, h)))), el("tbody", {}, ...rows)),
    );
  }

  place(name, inner, inside, there = null) {
    const variable = inside.reads[name];
    const held = (one) => (name in (one.holds ?? {}) ? one.holds[name] : one.marking?.[name] ?? 0);
    refill(this.body,
      el("div", { class: "bar" }, el("h3", {}, name), el("span", { class: "room" }),
        el("button", { "data-do": "break", onclick: () => this.act.breakAt("marked", name) }, "stop when it is marked (B)"), this.#curve(name), this.#edit(name)),
      el("p", {}, `holds ${held(inner)}${there ? `; there ${held(there)}` : ""}`),
      variable ? el("p", {}, "reads the belief about ", el("button", { class: "link", onclick: () => this.act.moved(variable) }, variable)) : null,
    );
  }

  belief(answer, unit) {
    const mean = (m) => (m?.mean === undefined || m.mean === null ? "" : `${short(m.mean)} ± ${short(m.spread)}${unit}`);
    const most = Math.max(0.001, ...answer.evidence.map((e) => e.moved));
    refill(this.body,
      el("div", { class: "bar" }, el("h3", {}, `What moved ${answer.variable}`), el("span", { class: "room" }), typeof answer.after?.mean === "number" ? this.#curve(`E(${answer.variable})`) : null),
      el("p", { "data-show": "answer" }, answer.evidence.length
        ? `Without the readings of cycle ${answer.cycle}: ${mean(answer.before)}; with them: ${mean(answer.after)} (moved by ${short(answer.moved)} of 1).`
        : `No reading came in cycle ${answer.cycle}: the belief went on by itself.`),
      el("table", {}, el("tbody", {}, ...answer.evidence.map((e) => el("tr", {}, el("td", {}, e.name), el("td", { class: "mono" }, short(e.value)),
        el("td", {}, el("meter", { min: 0, max: most, value: e.moved }, `${e.moved}`)), el("td", { class: "mono" }, short(e.moved)),
        el("td", { class: "soft" }, e.mean === undefined || e.mean === null ? "" : `without it ${short(e.mean)}${unit}`))))),
      answer.evidence.length ? el("p", { class: "soft" }, "How far the belief would lie from where it is, had the model not been told one reading: 0 not at all, 1 entirely elsewhere.") : null,
    );
  }
}

const HINTS = { when: "P(ball.x < -45) > 0.8", fires: "transition", marked: "place", ends: "" };

/** Breakpoints of the agent's net; `typed(kind, text)` says whether a text can stand in one. */
export class Breaks {
  constructor({ set, remove, typed }) {
    this.act = { set, remove };
    this.list = el("div", { class: "breaks" });
    this.text = expressionLine("expression", HINTS.when, () => this.#add(), (text) => typed(this.kind.value, text));
    this.kind = choose([["when", "when"], ["fires", "transition fires"], ["marked", "place is marked"], ["ends", "the episode ends"]], "when", () => this.#kind(), { "aria-label": "kind of breakpoint" });
    this.where = el("p", { class: "soft" });
    this.element = el("div", { class: "breaks-panel" },
      el("div", { class: "bar" }, this.kind, this.text.element, el("button", { "data-do": "add-break", onclick: () => this.text.enter() }, "stop there")), this.text.error, this.list, this.where);
  }

  #kind() {
    this.text.disabled = this.kind.value === "ends";
    this.text.anew(HINTS[this.kind.value]);
  }

  async #add() {
    const ends = this.kind.value === "ends";
    if (!ends && !this.text.value) return false;
    await this.act.set(this.kind.value, ends ? "" : this.text.value);
    return true;
  }

  draw(breakpoints, file, hit) {
    this.where.textContent = `Kept in ${file}: they hold from the first cycle of every run of this net.`;
    this.list.replaceChildren(...(breakpoints.length ? breakpoints.map((b) => {
      const struck = hit.some((h) => h.kind === b.kind && h.what === b.what);
      const text = { fires: "fires", marked: "is marked", when: "", ends: "the episode ends" }[b.kind];
      return el("div", { class: `break${struck ? " struck" : ""}${b.on ? "" : " off"}` },
        el("label", {}, el("input", { type: "checkbox", checked: b.on, onchange: (e) => this.act.set(b.kind, b.what, e.target.checked) }),
          el("span", { class: b.kind === "when" ? "mono" : "" }, b.what), ` ${text}`, struck ? el("strong", {}, " ◀ stopped here") : null),
        el("button", { "aria-label": `remove ${b.what}`, onclick: () => this.act.remove(b.kind, b.what) }, "×"));
    }) : [el("p", { class: "soft" }, "No breakpoints yet.")]));
  }
}

/** What was decided, cycle by cycle. */
export class Log {
  constructor(onchoose) {
    this.onchoose = onchoose;
    this.lines = new Map();
    this.holds = {}; // object place -> what it can hold
    this.element = el("ol", { class: "log", reversed: true, "aria-label": "decisions" });
  }

  clear() {
    this.lines.clear();
    this.element.replaceChildren();
  }

  add(frame) {
    for (const [cycle, line] of this.lines) if (cycle >= frame.cycle) { line.remove(); this.lines.delete(cycle); }
    const commands = Object.entries(frame.commands).map(([name, values]) => `${name}(${Object.values(values).map((v) => short(v)).join(", ")})`).join(" ");
    const { fired } = frame;
    const changed = frame.changes.map((c) => describe(c, this.holds)).join("; ");
    if (!commands && !frame.command && !fired.length && !changed && !frame.stopped && !frame.over) return;
    const line = el("li", { "data-cycle": frame.cycle },
      el("button", { class: "link mono", onclick: () => this.onchoose(frame.cycle) }, `${frame.cycle}`), el("span", { class: "mono" }, commands || frame.command || "–"),
      el("span", { class: "soft" }, fired.join(", ")), changed ? el("em", {}, `by hand: ${changed}`) : null,
      frame.stopped ? el("strong", {}, `stopped: ${frame.stopped.join("; ")}`) : null, frame.over ? el("strong", {}, frame.status.replaceAll("_", " ").toLowerCase()) : null);
    this.element.prepend(line);
    this.lines.set(frame.cycle, line);
    if (this.lines.size > LOG) {
      const [first] = this.lines.keys();
      this.lines.get(first).remove();
      this.lines.delete(first);
    }
  }
}

const KINDS = { ball: "ball moved", player: "player moved", blind: "blind", force: "forced", lose: "not told", mark: "marked", fail: "failed" };

/** A change in words; `holds`: object place -> the objects that it can hold. */
export function describe(change, holds = {}) {
  const who = change.whom ? `${change.whom} ` : "";
  if (change.kind === "hold") {
    const [at] = change.values;
    return `${who}${change.name} holds ${at < 0 ? "nobody" : holds[change.name]?.[at] ?? `object ${at}`}`;
  }
  const values = change.values.length ? ` ${change.values.map((v) => short(v)).join(", ")}` : "";
  return `${who}${KINDS[change.kind]} ${change.name}${values}${change.cycles > 1 ? ` for ${change.cycles} cycles` : ""}`.trim();
}

/** Changes by hand: faults, readings, relations, things moved. */
export class Hands {
  constructor({ change, undo }) {
    this.act = { change, undo };
    this.fields = el("div", { class: "bar" });
    this.kind = choose([
      ["blind", "blind him"], ["fail", "let a skill fail"], ["lose", "keep a reading from his model"], ["force", "make a percept read"],
      ["hold", "switch whom a place holds"], ["mark", "put tokens into a place"], ["ball", "put the ball at"], ["player", "put a player at"],
    ], "blind", () => this.#form(), { "aria-label": "what to change", "data-show": "change-kind" });
    this.list = el("ul", {});
    this.wrong = el("p", { class: "bad", hidden: true });
    this.element = el("div", { class: "hands" }, el("p", { class: "soft" }, "Changes take effect when the commands of this cycle are carried out. Ball and players can be dragged on the field while the run is paused."),
      el("div", { class: "bar" }, this.kind, this.fields, el("button", { class: "main", "data-do": "change", onclick: () => this.#do() }, "change"),
        el("button", { "data-do": "undo", onclick: () => this.act.undo() }, "take back")), this.wrong, this.list);
  }

  begin(agent, inside, run) {
    this.agent = agent;
    this.inside = inside;
    this.run = run;
    this.#form();
  }

  #form() {
    const i = this.inside ?? {};
    const pick = (names, label) => choose(names.length ? names : ["–"], names[0], () => {}, { "aria-label": label, "data-field": "name" });
    const cell = (name, value, attributes = {}) => el("input", { type: "number", step: "any", value, "aria-label": name, title: name, "data-field": name, style: "width: 6em", ...attributes });
    const cycles = () => [el("span", {}, "for"), cell("cycles", 20, { min: 1, step: 1 }), el("span", {}, "cycles")];
    const holds = () => {
      const places = Object.keys(i.holds ?? {});
      const place = pick(places, "object place");
      const object = el("select", { "aria-label": "object", "data-field": "value" });
      const fill = () => object.replaceChildren(el("option", { value: -1 }, "nobody"), ...(i.holds?.[place.value] ?? []).map((o, k) => el("option", { value: k }, o)));
      place.addEventListener("change", fill);
      fill();
      return [place, el("span", {}, "holds"), object];
    };
    const made = {
      blind: () => cycles(),
      fail: () => [pick(i.failing ?? [], "module")],
      lose: () => [pick(i.readings ?? [], "reading"), ...cycles()],
      force: () => [pick(i.percepts ?? [], "percept"), el("span", {}, "="), cell("value", 0), ...cycles()],
      hold: holds,
      mark: () => [el("input", { list: "net-parts", "data-field": "name", placeholder: "place", "aria-label": "place" }), cell("value", 1)],
      ball: () => [cell("x", 0), cell("y", 0), cell("vx", 0), cell("vy", 0)],
      player: () => [choose(this.#players(), "left_1", () => {}, { "aria-label": "player", "data-field": "whom" }), cell("x", 0), cell("y", 0)],
    }[this.kind.value]();
    this.fields.replaceChildren(...made);
  }

  #players() {
    const [left, right] = this.run?.counts ?? [0, 0];
    return [...Array(left).keys()].map((k) => nameOf(k + 1)).concat([...Array(right).keys()].map((k) => nameOf(k + 12)));
  }

  async #do() {
    const read = (name) => this.fields.querySelector(`[data-field=${name}]`)?.value;
    const empty = [...this.fields.querySelectorAll("input[type=number]")].find((field) => field.value === "");
    if (empty) return this.#refuse(`${empty.dataset.field}: a number is needed`);
    const kind = this.kind.value;
    const numbers = { ball: ["x", "y", "vx", "vy"], player: ["x", "y"], force: ["value"], mark: ["value"], hold: ["value"] }[kind] ?? [];
    const given = { kind, whom: kind === "ball" ? "" : kind === "player" ? read("whom") : this.agent, name: read("name") ?? "", values: numbers.map((n) => Number(read(n))), cycles: Number(read("cycles") ?? 1) };
    this.wrong.hidden = true;
    try {
      await this.act.change(given);
    } catch (error) {
      this.#refuse(error.message);
    }
    return undefined;
  }

  #refuse(text) {
    this.wrong.textContent = text;
    this.wrong.hidden = false;
  }

  draw(frame) {
    this.list.replaceChildren(...(frame.changes ?? []).map((c) => el("li", {}, describe(c, this.inside?.holds))));
    this.element.querySelector("[data-do=undo]").disabled = !frame.undo;
  }
}

/** Percepts and readings as numbers; `write()` keeps the readings of the run as a log. */
export class Numbers {
  constructor(write) {
    this.body = el("div", { class: "numbers" });
    this.log = el("button", { "data-do": "readings", title: "what the model was told in the cycles so far, as a log from which Models learns", onclick: write }, "write the readings as a log…");
    this.element = el("div", {}, el("div", { class: "bar" }, this.log), this.body);
  }

  draw(inner) {
    this.log.hidden = !inner?.beliefs;
    if (!inner?.percepts) return refill(this.body, el("p", { class: "soft" }, "Nothing is known of what this player perceives."));
    const evidence = Object.entries(inner.evidence);
    const table = (title, rows) => el("div", {}, el("h3", {}, title), el("table", {}, el("tbody", {}, ...rows.map(([name, value]) => el("tr", { class: value === null ? "soft" : "" }, el("td", {}, name), el("td", { class: "mono" }, value === null ? "not observed" : short(value)))))));
    return refill(this.body, table("percepts", Object.entries(inner.percepts)), evidence.length ? table("told to the model", evidence) : null, table("places of beliefs", Object.entries(inner.places)));
  }
}

export { observed };
