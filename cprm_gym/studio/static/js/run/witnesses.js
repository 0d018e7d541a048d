// What the analysis says of a net, and the runs that show it, played step by step in a drawing.

import { choose, el } from "../dom.js";
import { NetCanvas } from "../netcanvas.js";

const SIGN = { true: "✓", false: "✗", null: "?" };

export class Witnesses {
  constructor(call) {
    this.call = call;
    this.holder = el("div", { class: "net-holder" });
    this.list = el("div", { class: "verdicts" }, el("p", { class: "soft" }, "Choose a net: what is reached, what is never reached, and for each answer a run that shows it."));
    this.steps = el("ol", { class: "steps", "aria-label": "steps of the run" });
    this.at = 0;
    this.head = el("div", { class: "bar" }, el("h2", {}, "Analysis"));
    this.element = el("div", { class: "panel witnesses" }, this.head, el("div", { class: "witness-body" }, this.list, el("div", { class: "witness-net" }, this.holder), this.steps));
  }

  begin(choices) {
    const names = [...new Set([...choices.nets, ...choices.shipped])];
    this.net = choose(names, choices.nets[0] ?? (names.includes("goalie") ? "goalie" : names[0]), () => {}, { "aria-label": "net", "data-field": "net" });
    this.head.append(this.net, el("button", { "data-do": "analyze", onclick: () => this.analyze() }, "analyze"), el("span", { class: "room" }),
      el("button", { title: "one step back", onclick: () => this.go(this.at - 1) }, "◀"), el("button", { "data-do": "witness-step", title: "one step on", onclick: () => this.go(this.at + 1) }, "▶"));
  }

  async analyze() {
    this.list.replaceChildren(el("p", { class: "soft" }, "analysing, at most 20 s …"));
    this.steps.replaceChildren();
    const found = await this.call("run.analyze", { net: this.net.value });
    if (!found) {
      this.list.replaceChildren(el("p", { class: "bad" }, "The analysis gave no answer."));
      return;
    }
    this.found = found;
    if (!this.canvas) this.canvas = new NetCanvas(this.holder, { editable: false, label: "net that is analysed" });
    const plan = await this.call("run.plan", { net: this.net.value });
    if (plan) this.canvas.show(plan);
    this.list.replaceChildren(el("table", { class: "rows" }, el("tbody", {}, ...found.verdicts.map((v, i) => el("tr", { class: v.holds === false ? "fails" : "" }, el("td", {}, SIGN[v.holds]), el("td", {}, v.name), el("td", { class: "soft" }, v.part),
      el("td", {}, v.run.length ? el("button", { class: "link", "data-verdict": i, onclick: () => this.play(v) }, `${v.run.length} ${v.run.length === 1 ? "step" : "steps"}`) : ""), el("td", { class: "soft" }, v.why))))),
      ...found.notes.map((note) => el("p", { class: "soft" }, note)));
    this.play({ run: [] });
  }

  play(verdict) {
    this.run = verdict.run;
    this.steps.replaceChildren(...this.run.map((step, i) => el("li", {}, el("button", { class: "link", onclick: () => this.go(i + 1) }, `${step.cycle ? `cycle ${step.cycle}: ` : ""}${step.what}`), step.kind === "fires" ? "" : ` (${step.kind})`)));
    this.go(0);
  }

  /** Show the marking after so many steps. */
  go(at) {
    if (!this.run) return;
    this.at = Math.max(0, Math.min(this.run.length, at));
    const step = this.run[this.at - 1];
    const marking = step ? step.marking : this.found.start;
    const all = Object.fromEntries([...this.canvas.nodes.keys()].map((key) => [key, marking[key] ?? 0]));
    this.canvas.update({ marking: all, fired: step?.kind === "fires" ? [step.what] : [] });
    [...this.steps.children].forEach((line, i) => line.classList.toggle("now", i === this.at - 1));
    this.steps.children[this.at - 1]?.scrollIntoView({ block: "nearest" });
    if (step && this.canvas.nodes.has(step.what)) this.canvas.centre(step.what);
  }
}
