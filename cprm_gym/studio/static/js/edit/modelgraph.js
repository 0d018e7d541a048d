// The ground net of a model as a graph; a click on a variable says what is observed, and every belief follows.

import { el, svg } from "../dom.js";

const HIGH = 46;

export class ModelGraph {
  constructor(root, side, desk) {
    Object.assign(this, { root, side, desk });
    this.slices = [{ evidence: {}, relations: [] }];
    this.at = 0;
    this.engine = "exact";
    this.view = { x: 10, y: 10, k: 1 };
    this.number = 0;
    this.box = svg("svg", { class: "modelgraph", tabindex: 0, role: "application", "aria-label": "variables; Tab goes from one to the next, Enter observes" });
    this.group = svg("g");
    this.box.append(svg("defs", {}, svg("marker", { id: "model-tip", viewBox: "0 0 8 8", refX: 8, refY: 4, markerWidth: 8, markerHeight: 8, markerUnits: "userSpaceOnUse", orient: "auto" }, svg("path", { d: "M0 0 L8 4 L0 8 z" }))), this.group);
    this.#listen();
  }

  get slice() {
    return this.slices[this.at];
  }

  async show() {
    const mine = (this.number += 1);
    const id = this.desk.current.id;
    if (this.id !== id) {
      this.id = id;
      this.slices = [{ evidence: {}, relations: [] }];
      this.at = 0;
      this.fitted = false;
      this.beliefs = null;
    }
    try {
      this.possible = await this.desk.call("model.tuples", { id });
      this.slices.forEach((slice) => { slice.relations = slice.relations.filter((one) => this.possible.tuples.includes(one)); });
      const graph = await this.desk.call("model.graph", { id, relations: this.slice.relations, first: this.at === 0 });
      if (mine !== this.number) return;
      this.fitted &&= this.graph?.width === graph.width && this.graph?.height === graph.height;
      this.graph = graph;
      const known = new Set(graph.nodes.map((node) => node.key));
      for (const name of Object.keys(this.slice.evidence)) if (!known.has(name)) delete this.slice.evidence[name];
      this.draw();
      this.aside();
      await this.ask();
    } catch (error) {
      if (mine !== this.number) return;
      this.root.replaceChildren(el("div", { class: "empty" }, el("p", { class: "bad" }, error.message), el("p", {}, "The graph is shown when the model is well defined.")));
      this.aside();
    }
  }

  async ask() {
    const mine = this.number;
    this.wrong = "";
    try {
      this.answer = await this.desk.call("model.query", { id: this.id, slices: this.slices.slice(0, this.at + 1), engine: this.engine });
    } catch (error) {
      this.answer = null;
      this.wrong = error.message;
    }
    if (mine !== this.number) return;
    this.fill();
    this.aside();
  }

  draw() {
    const { nodes, edges } = this.graph;
    const at = new Map(nodes.map((node) => [node.key, node]));
    const lines = edges.map((edge) => {
      const [a, b] = [at.get(edge.source), at.get(edge.target)];
      const kind = `edge lag${edge.lag}${edge.changed ? " changed" : ""}`;
      if (a === b) return svg("path", { class: kind, d: `M${a.x + a.width / 2} ${a.y - 6} c26 -14 26 26 0 12`, "marker-end": "url(#model-tip)" });
      const down = b.y > a.y + 1;
      const level = Math.abs(b.y - a.y) <= 1;
      const start = level ? [a.x + (Math.sign(b.x - a.x) * a.width) / 2, a.y] : [a.x, a.y + (down ? HIGH / 2 : -HIGH / 2)];
      const end = level ? [b.x - (Math.sign(b.x - a.x) * b.width) / 2, b.y] : [b.x, b.y + (down ? -HIGH / 2 : HIGH / 2)];
      const middle = (start[1] + end[1]) / 2;
      return svg("path", { class: kind, d: level ? `M${start.join(" ")} L${end.join(" ")}` : `M${start.join(" ")} C${start[0]} ${middle} ${end[0]} ${middle} ${end.join(" ")}`, "marker-end": "url(#model-tip)" });
    });
    this.parts = new Map(nodes.map((node) => {
      const part = svg("g", { class: `variable${node.given ? " given" : ""}`, transform: `translate(${node.x - node.width / 2} ${node.y - HIGH / 2})`, tabindex: 0, role: "button", "aria-label": node.key, "data-key": node.key }, svg("rect", { class: "body", width: node.width, height: HIGH, rx: node.given ? 3 : 10 }), svg("text", { x: node.width / 2, y: 14, "text-anchor": "middle" }, node.label), svg("g", { class: "bars" }), svg("title", {}, node.key));
      return [node.key, part];
    }));
    this.group.replaceChildren(...lines, ...this.parts.values());
    if (this.box.parentElement !== this.root) this.root.replaceChildren(this.box);
    if (!this.fitted) this.fit();
    this.fill();
  }

  /** Show what is believed in each variable, and what is observed. */
  fill() {
    if (!this.parts) return;
    for (const node of this.graph.nodes) {
      const part = this.parts.get(node.key);
      const evidence = this.slice.evidence[node.key];
      part.classList.toggle("observed", evidence !== undefined);
      const bars = part.querySelector(".bars");
      bars.replaceChildren();
      const belief = this.answer?.beliefs[node.key];
      const width = node.width - 16;
      if (Array.isArray(belief)) {
        const step = width / belief.length;
        const scale = 22 / (belief.length > 3 ? Math.max(...belief) : 1);
        belief.forEach((p, i) => bars.append(svg("rect", { class: "bar", x: 8 + i * step, y: HIGH - 4 - scale * p, width: Math.max(1, step - 1), height: Math.max(0.5, scale * p) })));
        const best = belief.indexOf(Math.max(...belief));
        part.querySelector("title").textContent = `${node.key}\n${node.states.map((s, i) => `${s}: ${belief[i].toFixed(4)}`).join("\n")}`;
        part.setAttribute("aria-label", `${node.key}: ${node.states[best]} ${(100 * belief[best]).toFixed(0)} %${evidence !== undefined ? ", observed" : ""}`);
        if (belief.length <= 3) bars.append(svg("text", { class: "most", x: node.width / 2, y: HIGH - 8, "text-anchor": "middle" }, `${node.states[best]} ${belief[best].toFixed(2)}`));
      } else if (belief) bars.append(svg("text", { class: "most", x: node.width / 2, y: HIGH - 10, "text-anchor": "middle" }, `${belief.mean.toFixed(2)} ± ${belief.deviation.toFixed(2)}`));
      else if (evidence !== undefined) bars.append(svg("text", { class: "most", x: node.width / 2, y: HIGH - 10, "text-anchor": "middle" }, String(evidence)));
    }
  }

  fit() {
    const { width, height } = this.root.getBoundingClientRect();
    if (!width) return;
    const k = Math.min(1.2, Math.max(0.15, Math.min((width - 60) / this.graph.width, (height - 50) / (this.graph.height + 20))));
    this.look({ k, x: Math.max(10, (width - this.graph.width * k) / 2), y: 24 });
    this.fitted = true;
  }

  look(view) {
    this.view = view;
    this.group.setAttribute("transform", `translate(${view.x} ${view.y}) scale(${view.k})`);
  }

  #listen() {
    this.box.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { left, top } = this.box.getBoundingClientRect();
      const [px, py] = [event.clientX - left, event.clientY - top];
      const k = Math.max(0.1, Math.min(3, this.view.k * Math.exp(-event.deltaY * 0.0015)));
      const real = k / this.view.k;
      this.look({ k, x: px - (px - this.view.x) * real, y: py - (py - this.view.y) * real });
    }, { passive: false });
    this.box.addEventListener("pointerdown", (event) => {
      const part = event.target.closest(".variable");
      if (part) {
        this.observe(part.dataset.key);
        return;
      }
      let [x, y] = [event.clientX, event.clientY];
      const move = (next) => {
        this.look({ ...this.view, x: this.view.x + next.clientX - x, y: this.view.y + next.clientY - y });
        [x, y] = [next.clientX, next.clientY];
      };
      const end = () => {
        window.removeEventListener("pointermove", move);
        window.removeEventListener("pointerup", end);
      };
      window.addEventListener("pointermove", move);
      window.addEventListener("pointerup", end);
    });
    this.box.addEventListener("keydown", (event) => {
      const key = event.target.closest?.(".variable")?.dataset.key;
      const arrows = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] }[event.key];
      if (key && (event.key === "Enter" || event.key === " ")) this.observe(key);
      else if (key && event.key === "Delete") this.put(key, undefined);
      else if (event.key === "0") this.fit();
      else if (arrows) this.look({ ...this.view, x: this.view.x + arrows[0], y: this.view.y + arrows[1] });
      else if (event.key === "+" || event.key === "-") this.look({ ...this.view, k: this.view.k * (event.key === "+" ? 1.2 : 0.83) });
      else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  /** Ask which state a variable was observed in. */
  observe(key) {
    const node = this.graph.nodes.find((one) => one.key === key);
    const dialog = el("dialog", { class: "ask", "aria-label": `observe ${key}` });
    const close = (value) => {
      dialog.close();
      dialog.remove();
      if (value !== null) this.put(key, value);
      this.parts.get(key)?.focus();
    };
    dialog.addEventListener("cancel", (event) => {
      event.preventDefault();
      close(null);
    });
    const belief = this.answer?.beliefs[key];
    const states = node.states.map((state, i) => el("button", { onclick: () => close(state), "aria-pressed": this.slice.evidence[key] === state }, state, Array.isArray(belief) ? el("span", { class: "soft" }, ` ${belief[i].toFixed(3)}`) : null));
    const number = el("input", { type: "number", step: "any", "aria-label": "value" });
    dialog.append(el("h2", {}, key), el("div", { class: "list" }, ...states), node.states.length && !/\d/.test(node.states[0]) ? "" : el("form", { class: "bar", onsubmit: (event) => {
      event.preventDefault();
      if (number.value !== "") close(Number(number.value));
    } }, number, el("button", {}, "this value")), el("div", { class: "bar" }, el("button", { onclick: () => close(undefined) }, "not observed"), el("span", { class: "room" }), el("button", { onclick: () => close(null) }, "cancel")));
    document.body.append(dialog);
    dialog.showModal();
    (dialog.querySelector("[aria-pressed=true]") ?? dialog.querySelector("button, input")).focus();
  }

  put(key, value) {
    if (value === undefined) delete this.slice.evidence[key];
    else this.slice.evidence[key] = value;
    this.ask();
  }

  aside() {
    const { slice } = this;
    const go = (at) => {
      this.at = at;
      this.show();
    };
    const toggle = (one) => {
      slice.relations = slice.relations.includes(one) ? slice.relations.filter((r) => r !== one) : [...slice.relations, one];
      this.show();
    };
    const evidence = Object.entries(slice.evidence).map(([name, value]) => el("div", { class: "arcrow" }, el("span", {}, `${name} = ${value}`), el("button", { "aria-label": `forget ${name}`, onclick: () => this.put(name, undefined) }, "×")));
    const find = el("input", { type: "search", placeholder: "find a relation", "aria-label": "find a relation", value: this.wanted ?? "", oninput: () => {
      this.wanted = find.value;
      list();
    } });
    const relations = el("div", {});
    const list = () => {
      const all = (this.possible?.tuples ?? []).filter((one) => slice.relations.includes(one) || one.includes(this.wanted ?? ""));
      all.sort((a, b) => slice.relations.includes(b) - slice.relations.includes(a));
      relations.replaceChildren(...all.slice(0, 40).map((one) => el("label", { class: "tick" }, el("input", { type: "checkbox", checked: slice.relations.includes(one), onchange: () => toggle(one) }), one)), ...(all.length > 40 ? [el("p", { class: "soft" }, `and ${all.length - 40} more`)] : []));
    };
    list();
    this.side.replaceChildren(...[el("h3", {}, "Query"), el("div", { class: "bar" }, ...this.slices.map((_, i) => el("button", { "aria-pressed": i === this.at, onclick: () => go(i) }, `slice ${i + 1}`)), el("button", { title: "go on by one slice", onclick: () => {
      this.slices.push({ evidence: {}, relations: [...this.slices.at(-1).relations] });
      go(this.slices.length - 1);
    } }, "+"), this.slices.length > 1 ? el("button", { title: "take the last slice away", onclick: () => {
      this.slices.pop();
      go(Math.min(this.at, this.slices.length - 1));
    } }, "−") : null),
    this.wrong ? el("p", { class: "bad" }, this.wrong) : this.answer ? el("p", { class: "soft" }, `ln P(observed) = ${(Math.round(this.answer.log_likelihood * 1e4) / 1e4 || 0).toFixed(4)}${this.answer.exact ? "" : "; approximate"}`) : el("p", { class: "soft" }, "asking…"),
    el("h3", {}, "Observed"), ...(evidence.length ? evidence : [el("p", { class: "soft" }, "nothing; click a variable")]),
    el("h3", {}, "Relations in force"), (this.possible?.tuples ?? []).length > 12 ? find : null, relations, el("h3", {}, "Engine"), engineChoice(this)].filter(Boolean));
  }
}

function engineChoice(graph) {
  return el("select", { "aria-label": "engine", onchange: (event) => {
    graph.engine = event.target.value;
    graph.ask();
  } }, ...["exact", "projection", "particles"].map((name) => el("option", { value: name, selected: name === graph.engine }, name)));
}
