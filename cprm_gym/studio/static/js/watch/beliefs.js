// What an agent believes: a distribution for each variable, with what was observed of it, and the relations in force.

import { el, invalid, svg } from "../dom.js";

const WIDTH = 190;
const HEIGHT = 38;
const SHOWN_STATES = 6;
const MOST = 24;

/** Bars for the beliefs of one agent; `onask(variable)` is asked what moved it, `onshow(names)` shows others, null those by default. */
export class Beliefs {
  constructor(onask, onshow) {
    this.onask = onask;
    this.onshow = onshow;
    this.list = el("div", { class: "beliefs" });
    this.facts = el("span", {});
    this.names = el("datalist", { id: "belief-names" });
    this.more = el("input", { class: "more", list: "belief-names", placeholder: "show another variable", "aria-label": "show another variable", onchange: () => this.#add() });
    this.back = el("button", { class: "link", hidden: true, onclick: () => this.onshow(null) }, "those that the net reads");
    this.head = el("div", { class: "facts" }, this.facts, el("span", { class: "room" }), this.back, this.more, this.names);
    this.element = el("div", { class: "beliefs-panel" }, this.head, this.list);
    this.rows = new Map();
    this.inside = null;
  }

  #add() {
    const name = this.more.value.trim();
    const known = Object.keys(this.inside?.variables ?? {});
    const chosen = known.filter((one) => one === name || (name && !known.includes(name) && one.startsWith(name)));
    this.more.setCustomValidity(name && !chosen.length ? `no variable is called ${name}` : "");
    invalid(this.more, Boolean(name) && !chosen.length);
    if (name) this.more.reportValidity();
    if (!chosen.length) return;
    this.more.value = "";
    this.onshow([...new Set([...chosen, ...this.rows.keys()])].slice(0, MOST));
  }

  begin(inside) {
    this.inside = inside;
    this.names.replaceChildren(...Object.keys(inside?.variables ?? {}).map((value) => el("option", { value })));
    this.rows.clear();
    this.list.replaceChildren();
  }

  /** Show an agent's beliefs; `other` are those of the run beside, `differs` the names of what differs. */
  draw(inner, other = null, differs = []) {
    if (!inner?.beliefs) {
      this.facts.replaceChildren(el("p", { class: "soft" }, !inner ? "Nobody is shown in full." : inner.marking ? "This player has a net and no model: his net reads percepts alone." : "This player has no model."));
      this.list.replaceChildren();
      this.rows.clear();
      this.more.hidden = true;
      return;
    }
    this.more.hidden = false;
    this.facts.replaceChildren(
      el("span", { class: "soft" }, "relations: "),
      ...(inner.relations.length ? inner.relations.map((r) => el("span", { class: "chip" }, r)) : [el("span", {}, "none")]),
    );
    const names = Object.keys(inner.beliefs);
    for (const [name, row] of this.rows) if (!names.includes(name)) { row.element.remove(); this.rows.delete(name); }
    names.forEach((name, i) => {
      if (!this.rows.has(name)) this.rows.set(name, this.#row(name));
      const row = this.rows.get(name);
      if (this.list.children[i] !== row.element) this.list.insertBefore(row.element, this.list.children[i] ?? null);
      this.#fill(row, name, inner.beliefs[name], inner.evidence);
      this.#beside(row, inner.beliefs[name], other?.beliefs?.[name], differs.includes(name));
    });
  }

  #row(name) {
    const bars = svg("svg", { class: "bars", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, preserveAspectRatio: "none", height: HEIGHT, "aria-hidden": true });
    const value = el("div", { class: "mono value" });
    const there = el("div", { class: "mono there-value", hidden: true });
    const element = el("button", { class: "belief", title: `what moved ${name}?`, "data-variable": name, onclick: () => this.onask(name) },
      el("div", { class: "name" }, name), bars, value, there);
    return { element, bars, value, there, rects: [], key: "" };
  }

  /** The same belief in the run beside: its outline over the bars, and its value below. */
  #beside(row, belief, other, differs) {
    row.element.classList.toggle("differs", differs);
    row.there.hidden = !differs;
    row.outline?.remove();
    row.outline = null;
    if (!differs || !other) return;
    row.there.textContent = other.mean !== undefined && other.mean !== null ? `there ${short(other.mean)} ± ${short(other.spread)}` : `there ${best(other, this.inside?.variables?.[row.element.dataset.variable])}`;
    if (!row.places || other.p?.length !== belief.p?.length) return;
    const points = other.p.flatMap((p, i) => {
      const [x, width, scale] = row.places[i];
      const y = Math.max(0, HEIGHT - p * scale).toFixed(1);
      return [`${x.toFixed(1)},${y}`, `${(x + width).toFixed(1)},${y}`];
    });
    row.outline = svg("polyline", { class: "outline", points: points.join(" ") });
    row.bars.append(row.outline);
  }

  #fill(row, name, belief, evidence) {
    const known = this.inside?.variables?.[name];
    const unit = known?.unit ? ` ${known.unit}` : "";
    const text = belief.mean !== undefined && belief.mean !== null ? `${short(belief.mean)} ± ${short(belief.spread)}${unit}` : best(belief, known);
    if (row.value.textContent !== text) row.value.textContent = text;
    if (!belief.p) return;
    const edges = known?.edges?.length === belief.p.length + 1 ? known.edges : null;
    if (row.rects.length !== belief.p.length) {
      row.rects = belief.p.map(() => svg("rect", { class: "bar-p" }));
      row.seen = svg("line", { class: "seen", y1: 0, y2: HEIGHT });
      row.bars.replaceChildren(...row.rects, row.seen);
    }
    const low = edges ? edges[0] : 0;
    const span = edges ? edges.at(-1) - low : belief.p.length;
    const density = belief.p.map((p, i) => (edges ? p / (edges[i + 1] - edges[i]) : p));
    const top = edges ? Math.max(...density) || 1 : 1;
    row.places = belief.p.map((_, i) => (edges ? [((edges[i] - low) / span) * WIDTH, ((edges[i + 1] - edges[i]) / span) * WIDTH, (HEIGHT - 2) / top / (edges[i + 1] - edges[i])] : [(i / span) * WIDTH, WIDTH / span, HEIGHT - 2]));
    belief.p.forEach((p, i) => {
      const rect = row.rects[i];
      const height = (density[i] / top) * (HEIGHT - 2);
      if (rect.shown === height) return;
      rect.shown = height;
      const x = edges ? ((edges[i] - low) / span) * WIDTH : (i / span) * WIDTH;
      const width = edges ? ((edges[i + 1] - edges[i]) / span) * WIDTH : WIDTH / span;
      rect.setAttribute("x", x.toFixed(1));
      rect.setAttribute("width", Math.max(width - (edges ? 0 : 2), 0.6).toFixed(1));
      rect.setAttribute("y", (HEIGHT - height).toFixed(1));
      rect.setAttribute("height", height.toFixed(1));
    });
    const seen = observed(name, evidence);
    const at = typeof seen !== "number" || !edges ? null : ((Math.min(Math.max(seen, low), edges.at(-1)) - low) / span) * WIDTH;
    row.seen.style.display = at === null ? "none" : "";
    if (at !== null) {
      row.seen.setAttribute("x1", at);
      row.seen.setAttribute("x2", at);
    }
  }
}

/** The reading of a variable in this cycle: of itself, or of what is called seen_ or obs_ of it. */
export function observed(name, evidence) {
  const dot = name.lastIndexOf(".");
  const [owner, attribute] = [name.slice(0, dot), name.slice(dot + 1)];
  for (const candidate of [name, `${owner}.seen_${attribute}`, `${owner}.obs_${attribute}`]) {
    const found = evidence?.[candidate];
    if (found !== null && found !== undefined) return found;
  }
  return null;
}

export const short = (value) => (typeof value === "string" ? value : value === null || value === undefined ? "–" : Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 10 ? value.toFixed(1) : value.toFixed(2));

function best(belief, known) {
  if (!belief.p) return "";
  const order = belief.p.map((p, i) => [p, i]).sort((a, b) => b[0] - a[0]).slice(0, 2).filter(([p]) => p > 0.005);
  return order.slice(0, SHOWN_STATES).map(([p, i]) => `${known?.states?.[i] ?? i} ${p.toFixed(2)}`).join(", ");
}
