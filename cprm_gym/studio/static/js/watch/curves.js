// Expressions over the last cycles, drawn by uPlot; dashed, what would be true. A click goes to that cycle.

import uPlot from "../../vendor/uplot/uPlot.esm.js";
import { choose, el, memory } from "../dom.js";
import { expressionLine } from "../edit/fields.js";
import { short } from "./beliefs.js";

const MOST = 6;
const LENGTHS = [["100", "100 cycles"], ["200", "200 cycles"], ["1000", "1000 cycles"], ["6000", "the whole run"]];
const EVERY = 500; // ms between two readings of cycles that were not sent

/** Curves of one agent: `ask(agent, what, cycles)` gives their values, `look(cycle)` goes there, `typed(kind, text)` checks an expression. */
export class Curves {
  constructor({ ask, look, typed }) {
    this.act = { ask, look };
    this.what = [];
    this.values = new Map(); // cycle -> expression -> [value, true value]
    this.length = memory.get("curves.length", "200");
    this.text = expressionLine("expression of a curve", "P(ball.x < -45)", (text) => this.add(text), (text) => typed("when", text));
    this.wrong = this.text.error;
    this.chips = el("div", { class: "curve-chips", role: "list", "aria-label": "curves" });
    this.holder = el("div", { class: "plot", role: "img" });
    const bar = el("div", { class: "bar" }, this.text.element, el("button", { "data-do": "curve", onclick: () => this.text.enter() }, "draw"),
      choose(LENGTHS, this.length, (value) => this.#span(value), { "aria-label": "how many cycles" }), el("span", { class: "soft" }, "dashed: as it is"));
    this.element = el("div", { class: "curves" }, bar, this.wrong, this.chips, this.holder);
    new ResizeObserver(() => this.#size()).observe(this.holder);
    new MutationObserver(() => this.#rebuild()).observe(document.documentElement, { attributeFilter: ["data-theme"] });
  }

  /** Another agent, or the same in another run. */
  begin(agent, inside) {
    this.agent = agent;
    this.inside = inside;
    this.values.clear();
    this.fail("");
    const variables = Object.entries(inside?.variables ?? {}).filter(([, v]) => v.edges && !v.auxiliary).map(([name]) => name);
    this.text.anew(variables.length ? `P(${variables[0]} < 0)` : "place or percept");
    const first = [...new Set(Object.values(inside?.reads ?? {}))].filter((name) => variables.includes(name)).slice(0, 2);
    this.what = memory.get(`curves.${inside?.net}`, first.map((name) => `E(${name})`));
    this.#chips();
    this.#rebuild();
    this.late = true;
  }

  /** Draw another expression; promises whether it is drawn. */
  async add(text) {
    const given = text.trim();
    if (!given || this.what.includes(given)) return Boolean(given);
    if (this.what.length >= MOST) {
      this.fail(`${MOST} curves are drawn at once: remove one first`);
      return false;
    }
    this.what.push(given);
    return this.#fetch();
  }

  fail(text) {
    this.text.say(text);
  }

  #remove(text) {
    this.what = this.what.filter((one) => one !== text);
    this.#fetch();
  }

  #span(length) {
    this.length = length;
    memory.set("curves.length", length);
    this.#fetch();
  }

  /** Read all values anew; true when every expression has some. */
  async #fetch() {
    if (!this.inside?.net) return false;
    const { agent } = this;
    this.late = false;
    this.read = performance.now();
    let answer;
    try {
      answer = await this.act.ask(agent, this.what, Number(this.length));
    } catch (error) {
      this.fail(error.message);
      return false;
    }
    if (agent !== this.agent) return false;
    const wrong = Object.entries(answer.wrong);
    this.what = this.what.filter((text) => !(text in answer.wrong));
    if (wrong.length) this.fail(wrong.map(([, why]) => why).join(" "));
    if (!wrong.length) memory.set(`curves.${this.inside.net}`, this.what);
    this.values = new Map(answer.cycles.map((cycle, i) => [cycle, Object.fromEntries(this.what.map((text) => [text, answer.values[text]?.[i] ?? [null, null]]))]));
    this.#chips();
    this.#rebuild();
    return !wrong.length;
  }

  /** Show a frame; `range` is the first and the last cycle that there is. */
  draw(frame, range) {
    if (!this.inside?.net) {
      this.holder.replaceChildren(el("p", { class: "soft" }, "This player has no net of ours, and no curves."));
      return;
    }
    this.cycle = frame.cycle;
    const own = frame.curves?.[this.agent];
    if (own) this.values.set(frame.cycle, own);
    for (const cycle of this.values.keys()) if (cycle > range[1]) this.values.delete(cycle);
    const known = this.values.has(range[1]) && this.what.every((text) => text in this.values.get(range[1]));
    const skipped = known && !this.values.has(range[1] - 1) && range[1] > range[0];
    if ((this.late || !known || skipped) && performance.now() - (this.read ?? -EVERY) >= (this.late ? 0 : EVERY)) this.#fetch();
    this.#fill();
  }

  // ------------------------------------------------------------------ the plot

  #data() {
    const cycles = [...this.values.keys()].sort((a, b) => a - b).slice(-Number(this.length));
    const of = (text, k) => cycles.map((cycle) => this.values.get(cycle)[text]?.[k] ?? null);
    return [cycles, ...this.what.flatMap((text) => [of(text, 0), of(text, 1)])];
  }

  /** Whether all values of a curve lie in 0 to 1: a probability, a truth value, a token. */
  #small(data, k) {
    return [...data[1 + 2 * k], ...data[2 + 2 * k]].every((v) => v === null || (v >= 0 && v <= 1));
  }

  #rebuild() {
    this.plot?.destroy();
    this.plot = null;
    this.#fill();
  }

  #fill() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (!width || height < 40 || !this.inside?.net) return;
    const data = this.#data();
    const scales = this.what.map((_, k) => (this.#small(data, k) ? "share" : "value"));
    if (!this.plot || this.kinds !== `${this.what} ${scales}`) {
      this.plot?.destroy();
      this.holder.replaceChildren();
      this.plot = this.what.length ? new uPlot(this.#options(scales, width, height), data, this.holder) : null;
      this.kinds = `${this.what} ${scales}`;
      if (!this.plot) this.holder.replaceChildren(el("p", { class: "soft" }, "Type an expression: a place, a percept, E(variable), P(variable < number), clock(transition), or what is made of them."));
    } else this.plot.setData(data);
    this.#tell();
  }

  #options(scales, width, height) {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--soft"), font: "11px system-ui, sans-serif", ticks: { stroke: colour("--line"), size: 4 }, grid: { stroke: colour("--line"), width: 1 } };
    const used = (name) => scales.includes(name);
    return {
      width, height,
      padding: [8, used("share") ? null : 12, 0, null],
      legend: { show: false },
      cursor: { drag: { x: false, y: false }, points: { size: 6 } },
      scales: { x: { time: false }, value: {}, share: { range: [-0.04, 1.04] } },
      axes: [{ ...axis, size: 26, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000] },
        { ...axis, scale: "value", size: 46, show: used("value") },
        { ...axis, scale: "share", side: used("value") ? 1 : 3, size: 38, show: used("share"), grid: { ...axis.grid, show: !used("value") }, splits: () => [0, 0.25, 0.5, 0.75, 1] }],
      series: [{}, ...this.what.flatMap((text, k) => {
        const line = { scale: scales[k], stroke: colour(`--curve-${k + 1}`), width: 2, points: { show: false } };
        return [{ ...line, label: text }, { ...line, label: `${text}, true`, dash: [6, 4], width: 1.5 }];
      })],
      hooks: {
        draw: [(plot) => { this.#number(plot, colour); this.#mark(plot, colour("--ink")); }],
        setCursor: [() => this.#tell()],
        ready: [(plot) => plot.over.addEventListener("click", () => plot.cursor.idx !== null && this.act.look(plot.data[0][plot.cursor.idx]))],
      },
    };
  }

  /** The number of each curve at its end, as beside its name: colours alone tell no curves apart. */
  #number(plot, colour) {
    const { ctx, bbox } = plot;
    ctx.save();
    Object.assign(ctx, { font: `bold ${11 * devicePixelRatio}px system-ui, sans-serif`, textAlign: "right", textBaseline: "middle", lineWidth: 4 * devicePixelRatio, strokeStyle: colour("--panel"), lineJoin: "round" });
    const taken = [];
    this.what.forEach((_, k) => {
      const values = plot.data[1 + 2 * k];
      const last = values?.findLastIndex((v) => v !== null) ?? -1;
      if (last < 0) return;
      const x = Math.min(bbox.left + bbox.width - 2, plot.valToPos(plot.data[0][last], "x", true));
      const y = Math.max(bbox.top + 8, Math.min(bbox.top + bbox.height - 8, plot.valToPos(values[last], plot.series[1 + 2 * k].scale, true)));
      const beside = taken.filter((other) => Math.abs(other - y) < 10 * devicePixelRatio).length; // where several end, side by side
      taken.push(y);
      ctx.fillStyle = colour(`--curve-${k + 1}`);
      ctx.strokeText(`${k + 1}`, x - 11 * devicePixelRatio * beside, y);
      ctx.fillText(`${k + 1}`, x - 11 * devicePixelRatio * beside, y);
    });
    ctx.restore();
  }

  /** A line at the cycle that is shown. */
  #mark(plot, ink) {
    if (this.cycle === undefined) return;
    const x = Math.round(plot.valToPos(this.cycle, "x", true));
    const { ctx, bbox } = plot;
    if (x < bbox.left || x > bbox.left + bbox.width) return;
    ctx.save();
    ctx.strokeStyle = ink;
    ctx.lineWidth = devicePixelRatio;
    ctx.setLineDash([]);
    ctx.beginPath();
    ctx.moveTo(x, bbox.top);
    ctx.lineTo(x, bbox.top + bbox.height);
    ctx.stroke();
    ctx.restore();
  }

  #size() {
    const { clientWidth: width, clientHeight: height } = this.holder;
    if (this.plot && width && height >= 40) this.plot.setSize({ width, height });
    else this.#fill();
  }

  // ------------------------------------------------------------------ values as text

  #chips() {
    this.shown = this.what.map(() => el("output", { class: "mono" }));
    this.chips.replaceChildren(...this.what.map((text, k) => el("span", { class: "curve-chip", role: "listitem", "data-curve": text },
      el("span", { class: "sample", style: `background: var(--curve-${k + 1})` }), el("strong", {}, `${k + 1}`), el("span", { class: "mono" }, text), this.shown[k],
      el("button", { "aria-label": `remove the curve ${text}`, title: "remove", onclick: () => this.#remove(text) }, "×"))));
  }

  /** Beside each name its value: where the mouse is, else in the cycle that is shown. */
  #tell() {
    const idx = this.plot?.cursor.idx;
    const cycle = idx !== null && idx !== undefined ? this.plot.data[0][idx] : this.cycle;
    const now = this.values.get(cycle) ?? {};
    const told = this.what.map((text) => now[text] ?? [null, null]);
    told.forEach(([value, truth], k) => {
      if (this.shown[k]) this.shown[k].textContent = value === null ? "–" : `${short(value)}${truth === null ? "" : ` (true ${short(truth)})`}`;
    });
    this.holder.setAttribute("aria-label", `cycle ${cycle}: ${this.what.map((text, k) => `${text} ${told[k][0] ?? "unknown"}`).join(", ")}`);
  }
}
