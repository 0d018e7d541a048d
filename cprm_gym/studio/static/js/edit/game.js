// The token game: the net on the canvas is played by hand.

import { el } from "../dom.js";

export class Game {
  constructor(root, desk, canvas, ended) {
    Object.assign(this, { root, desk, canvas, ended });
    this.on = false;
  }

  async begin(definition) {
    this.definition = definition;
    if (!(await this.take("begin", { definition }))) return;
    this.on = true;
    this.canvas.editable = false;
  }

  async end() {
    this.on = false;
    this.canvas.editable = true;
    this.canvas.clear();
    await this.desk.call("game.end", { id: this.desk.current.id }).catch(() => {});
    this.ended();
  }

  async take(name, given = {}) {
    try {
      this.state = await this.desk.call(`game.${name}`, { id: this.desk.current.id, ...given });
      this.show();
      return true;
    } catch (error) {
      this.desk.studio.note(error.message, "error");
      return false;
    }
  }

  /** Fire a transition, or say why it cannot. */
  async fire(key) {
    if (this.state.enabled.includes(key)) return this.take("fire", { transition: key });
    try {
      const { why } = await this.desk.call("game.why", { id: this.desk.current.id, transition: key });
      this.desk.studio.note(`${key}: ${why.join("; ") || "may fire"}`);
    } catch {
      /* a place, or a module */
    }
    return false;
  }

  show() {
    const { state } = this;
    this.canvas.update({ marking: state.marking, enabled: state.enabled, fired: state.fired, clocks: state.clocks });
    const own = this.desk.net.definitions[this.definition].places.filter((place) => place.name in state.marking && place.kind !== "math");
    const number = ({ name }) => el("label", { class: "arcrow" }, el("span", {}, name), el("input", { type: "number", step: "any", value: state.marking[name] ?? 0, "aria-label": `marking of ${name}`,
      onchange: (event) => this.take("write", { place: name, value: Number(event.target.value) }) }));
    this.root.replaceChildren(el("h3", {}, "Token game"), el("p", { class: "soft" }, `cycle ${state.cycle}; ${state.moves} ${state.moves === 1 ? "move" : "moves"}`),
      el("div", { class: "bar" }, el("button", { class: "main", title: "run a cycle (c)", onclick: () => this.take("cycle") }, "cycle"), el("button", { title: "take back (b)", disabled: !state.moves, onclick: () => this.take("back") }, "back"),
        el("button", { onclick: () => this.take("reset") }, "begin again"), el("button", { title: "end (Escape)", onclick: () => this.end() }, "end")),
      el("h3", {}, `Enabled: ${state.enabled.length}`), ...(state.enabled.length ? state.enabled.map((name) => el("button", { class: "wide", onclick: () => this.fire(name) }, `fire ${name}`)) : [el("p", { class: "soft" }, "nothing; a cycle may set clocks on")]),
      ...(state.fired.length ? [el("h3", {}, "Fired"), el("p", {}, state.fired.join(", "))] : []), ...(state.commands ? [el("p", {}, `sent: ${state.commands}`)] : []),
      el("h3", {}, "Marking"), ...own.map(number));
  }
}
