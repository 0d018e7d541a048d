// The net of the agent that is watched, as it works: marking, what fired, what was enabled, clocks, modules at work.

import { choose, el, invalid } from "../dom.js";
import { NetCanvas } from "../netcanvas.js";

const LARGE = 2500;

/** `onchoose(key)` is told of the place, transition or module that was chosen. A view that `follows` another shows the same part of its net. */
export class NetView {
  constructor(call, onchoose, { follows = null } = {}) {
    this.call = call;
    this.onchoose = onchoose;
    this.followers = [];
    this.holder = el("div", { class: "net-holder" });
    this.find = el("input", { type: "search", placeholder: "find a part", list: "net-parts", "aria-label": "find a place or transition", onchange: () => this.seek(this.find.value) });
    this.names = el("datalist", { id: "net-parts" });
    this.depth = choose([["0", "folded"], ["1", "one level"], ["-1", "unfolded"]], "0", (value) => this.unfold(Number(value)), { "aria-label": "how far modules are unfolded" });
    this.quantities = el("input", { type: "checkbox", onchange: () => this.#again() });
    this.told = el("span", { class: "soft told", role: "status" });
    this.bar = follows ? el("div", { class: "bar" }, el("h2", {}, "Net there"), this.told) : el("div", { class: "bar" }, el("h2", {}, "Net"), this.depth, el("label", { title: "inputs, beliefs, math and continuous places, too" }, this.quantities, " quantities"), this.find, this.names, this.told, el("span", { class: "room" }),
      el("button", { title: "smaller (-)", onclick: () => this.canvas.zoom(0.8) }, "−"), el("button", { title: "larger (+)", onclick: () => this.canvas.zoom(1.25) }, "+"),
      el("button", { title: "all of it, or, when it is all seen, as large as can be read (0)", onclick: () => this.canvas.fitOrRead() }, "fit"));
    this.none = el("p", { class: "soft none" });
    this.element = el("div", { class: "net-panel" }, this.bar, this.holder, this.none);
    this.canvas = new NetCanvas(this.holder, { editable: false, label: follows ? "net of the agent in the run beside" : "net of the agent" });
    if (follows) this.#follow(follows);
    this.opened = [];
    this.canvas.element.addEventListener("select", ({ detail }) => detail.keys.length === 1 && this.onchoose(detail.keys[0]));
    this.canvas.element.addEventListener("toggle", ({ detail }) => this.toggle(detail.key));
    this.canvas.element.addEventListener("open", ({ detail }) => this.canvas.boxes.has(detail.key) && this.toggle(detail.key));
  }

  /** Move and zoom with another view, and unfold what it unfolds. */
  #follow(leader) {
    this.leader = leader;
    leader.followers.push(this);
    const alike = () => this.shown?.length === leader.shown?.length && this.canvas.plan?.width === leader.canvas.plan?.width;
    leader.canvas.onlook = (view) => alike() && this.canvas.lookAt(view);
    this.canvas.onlook = (view) => alike() && leader.canvas.lookAt(view);
    leader.canvas.element.addEventListener("select", ({ detail }) => this.canvas.select(detail.keys.filter((key) => this.canvas.nodes.has(key)), false));
  }

  async begin(agent, inside) {
    this.agent = agent;
    this.inside = inside;
    this.shown = null;
    this.opened = [];
    this.depth.value = "0";
    const without = !inside?.net;
    this.holder.hidden = this.bar.hidden = without;
    this.none.hidden = !without;
    this.none.textContent = inside ? `${agent} is played by ${inside.kind}, which has no net to be seen.` : "Nobody here plays with a net.";
    if (this.leader) this.quantities.checked = this.leader.quantities.checked;
    if (without) {
      this.last = this.shown = this.wanted = null;
      return;
    }
    this.names.replaceChildren(...[...inside.transitions, ...inside.places].slice(0, LARGE).map((value) => el("option", { value })));
    await this.load(this.leader?.unfolded ?? 0);
    if (this.wanted) {
      const { wanted } = this;
      this.wanted = null;
      await this.seek(wanted);
    }
    if (!this.leader || !this.canvas.plan) return;
    this.leader.canvas.onlook(this.leader.canvas.view);
    this.canvas.select([...this.leader.canvas.selection].filter((key) => this.canvas.nodes.has(key)), false);
  }

  /** Ask for nothing until it begins again. */
  forget() {
    this.inside = this.shown = this.wanted = this.last = null;
  }

  /** What there is to say about the search. */
  tell(text, wrong = false) {
    this.told.textContent = this.told.title = text;
    this.told.classList.toggle("bad", wrong);
    invalid(this.find, wrong);
  }

  async load(unfold, keep = false) {
    if (!this.inside?.net) return;
    const plan = await this.call("watch.plan", { agent: this.agent, unfold, quantities: this.quantities.checked });
    if (!plan) return;
    this.unfolded = unfold;
    this.canvas.show(plan, { keep });
    this.working = new Set();
    this.boxes = plan.boxes.map((box) => box.key);
    this.shown = plan.nodes.map((node) => node.key);
    if (this.last) this.draw(...this.last);
    for (const follower of this.followers) {
      follower.quantities.checked = this.quantities.checked;
      await follower.load(unfold, keep);
    }
  }

  async #again() {
    await this.load(this.unfolded);
  }

  unfold(levels) {
    this.opened = levels === 0 ? [] : this.boxes.slice();
    return this.load(levels);
  }

  /** Show a module with its inside, or without. */
  async toggle(key) {
    if (this.leader?.canvas.boxes.has(key)) {
      await this.leader.toggle(key);
      return;
    }
    const inside = (path) => path === key || path.startsWith(`${key}.`);
    const folded = this.canvas.boxes.get(key)?.box.folded;
    const open = this.boxes.filter((path) => !this.canvas.boxes.get(path).box.folded);
    const wanted = folded ? [...open, key] : open.filter((path) => !inside(path));
    await this.load(wanted, true);
    this.canvas.reveal(key);
  }

  /** Bring a place or transition into view, unfolding what it is in; what is asked before the net is there is done when it comes. */
  async seek(key) {
    this.tell("");
    if (!key) return;
    if (!this.inside || !this.shown) {
      this.wanted = key;
      this.tell(`${key}: looked for as soon as the net is here`);
      return;
    }
    const names = [...this.inside.transitions, ...this.inside.places];
    const found = names.includes(key) ? key : names.find((part) => part.includes(key));
    if (!found) {
      this.tell(`no part of ${this.inside.net} is called ${key}`, true);
      return;
    }
    key = found;
    if (!this.canvas.nodes.has(key)) {
      if (this.inside.quantities.includes(key)) this.quantities.checked = true;
      const parts = key.split(".");
      const paths = parts.slice(0, -1).map((_, i) => parts.slice(0, i + 1).join("."));
      const open = this.boxes.filter((path) => !this.canvas.boxes.get(path).box.folded);
      await this.load([...new Set([...open, ...paths])], true);
    }
    this.canvas.select([key]);
    this.canvas.centre(key);
  }

  /** Colour a cycle; `broken` are the keys that have breakpoints, `at` a firing inside the cycle: {tokens, fired}, `differs` what is otherwise beside. */
  draw(inner, broken, at = null, differs = []) {
    this.last = [inner, broken, null, differs];
    if (!inner?.marking || !this.shown) return;
    const marking = {};
    for (const key of this.shown) if (!this.canvas.nodes.get(key)?.group.querySelector("rect.shape")) marking[key] = at?.tokens[key] ?? inner.marking[key] ?? (key in inner.holds ? 1 : 0);
    const clocks = Object.fromEntries(Object.entries(inner.clocks).map(([key, [counted, delay]]) => [key, counted / delay]));
    this.canvas.update({ marking, fired: at ? at.fired : inner.fired, enabled: at ? at.enabled : inner.enabled, clocks, broken, differs: this.#seen(differs) });
    for (const path of this.boxes) {
      const place = this.inside.modules[path];
      const works = Boolean(place && (inner.marking[place] ?? 0) > 0);
      if (works === this.working.has(path)) continue;
      this.canvas.boxes.get(path)?.group.classList.toggle("working", works);
      if (works) this.working.add(path);
      else this.working.delete(path);
    }
  }

  /** Of these parts, those that are drawn; instead of a part inside a folded module, the module. */
  #seen(keys) {
    const shown = keys.map((key) => {
      if (this.canvas.nodes.has(key)) return key;
      const around = this.boxes.filter((path) => key.startsWith(`${path}.`));
      return around.find((path) => this.canvas.boxes.get(path)?.box.folded);
    });
    return shown.filter(Boolean);
  }
}
