// The canvas of a net: draws a plan, colours its state, pans and zooms, selects, and in an editor moves and connects.
//
// const canvas = new NetCanvas(container, { editable: false });
// canvas.show(plan);                                          a plan of `cprm_gym.architecture.petri.drawing.plan.drawing_plan`
// canvas.update({ marking, enabled, fired, clocks, problems, broken, differs });   all optional; only what differs is touched
//
// Events on `canvas.element`, all with `detail`: select {keys}, open {key}, toggle {key} (a module is to be folded or unfolded),
// move {at}, connect {source, target}, place {x, y} (double click on nothing), remove {keys}. Keys of arcs are "style source target"
// joined by tabs.

import { Viewport } from "./viewport.js";
import { boxShape, curve, definitions, element, labelPoint, nodeShape, setClock, setTokens, straight } from "./netshapes.js";

let count = 0;
const STEP = 10;
const around = (points) => {
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  return [Math.min(...xs) - 30, Math.min(...ys) - 30, Math.max(...xs) + 30, Math.max(...ys) + 30];
};
export const arcKey = (link) => `${link.style}\t${link.source}\t${link.target}`;

export class NetCanvas extends Viewport {
  constructor(container, { editable = false, label = "net" } = {}) {
    super();
    this.id = `n${(count += 1)}`;
    this.editable = editable;
    this.connecting = null; // key of the node from which an arc is being drawn
    this.arcMode = false; // dragging draws an arc instead of moving
    this.selection = new Set();
    this.nodes = new Map(); // key -> {node, group}
    this.boxes = new Map();
    this.links = new Map(); // key -> {link, path, hit, text, bend}
    this.state = { marking: {}, enabled: new Set(), fired: new Set(), clocks: {}, problems: {}, broken: new Set(), differs: new Set() };
    this.layer = { boxes: element("g"), links: element("g", { class: "links" }), nodes: element("g"), band: element("g") };
    // two pictures, one above the other: what changes in every cycle does not make the browser draw the arcs again
    this.scaled = [element("g", {}, this.layer.boxes, this.layer.links), element("g", {}, this.layer.nodes, this.layer.band)];
    this.world = document.createElement("div");
    this.world.className = "world";
    this.world.append(element("svg", { class: "under" }, definitions(this.id), this.scaled[0]), element("svg", { class: "over" }, this.scaled[1]));
    this.element = document.createElement("div");
    this.element.className = `netcanvas${editable ? " editable" : ""}`;
    for (const [key, value] of Object.entries({ tabindex: 0, role: "application", "aria-label": label })) this.element.setAttribute(key, value);
    this.element.append(this.world, ...this.bars);
    container.replaceChildren(this.element);
    this.#listen();
    this.watch(container);
  }

  /** Draw a plan; the view and the selection are kept when `keep` is set. */
  show(plan, { keep = false } = {}) {
    this.plan = plan;
    this.nodes.clear();
    this.boxes.clear();
    this.links.clear();
    const pairs = new Map();
    for (const link of plan.links) {
      const pair = [link.source, link.target].sort().join("\t");
      pairs.set(pair, [...(pairs.get(pair) ?? []), arcKey(link)]);
    }
    this.layer.boxes.replaceChildren(...plan.boxes.map((box) => {
      const group = boxShape(box);
      this.boxes.set(box.key, { box: { ...box }, group });
      return group;
    }));
    this.layer.nodes.replaceChildren(...plan.nodes.map((node) => {
      const group = nodeShape(node, this.id);
      this.nodes.set(node.key, { node: { ...node }, group });
      return group;
    }));
    const drawn = [];
    for (const link of plan.links) {
      if (!this.nodes.has(link.source) || !this.nodes.has(link.target)) continue;
      const key = arcKey(link);
      const others = pairs.get([link.source, link.target].sort().join("\t"));
      const order = others.indexOf(key);
      const bend = others.length > 1 ? (order - (others.length - 1) / 2) * 26 * (link.source < link.target ? 1 : -1) : 0;
      const marker = link.style === "parameter" || link.style === "fuse" ? "" : `url(#${link.style}-${this.id})`;
      const path = element("path", { class: "line", ...(marker ? { "marker-end": marker } : {}) });
      const hit = this.editable ? element("path", { class: "hit" }) : null;
      const text = link.label ? element("text", { class: "weight" }, link.label) : null;
      const group = element("g", { class: `link ${link.style}` }, ...[path, hit, text].filter(Boolean));
      group.dataset.key = key;
      const kept = { link, group, path, hit, text, bend };
      this.links.set(key, kept);
      if (link.path.length) {
        kept.extent = around(link.path);
        this.#trace(kept, curve(link.path), labelPoint(link.path));
      } else this.#straighten(kept);
      drawn.push(group);
    }
    this.layer.links.replaceChildren(...drawn);
    const before = this.state;
    this.state = { marking: {}, enabled: new Set(), fired: new Set(), clocks: {}, problems: {}, broken: new Set(), differs: new Set() };
    if (keep) this.update(before);
    this.select([...this.selection].filter((key) => keep && this.#group(key)), false);
    this.shown(keep);
  }

  /** Forget the state, so that the next plan is shown with its initial marking. */
  clear() {
    this.state = { marking: {}, enabled: new Set(), fired: new Set(), clocks: {}, problems: {}, broken: new Set(), differs: new Set() };
  }

  /** Colour the state: numbers by place, sets of transitions, shares of clocks, problems by key. */
  update({ marking, enabled, fired, clocks, problems, broken, differs }) {
    if (marking) {
      for (const [key, value] of Object.entries(marking)) {
        const known = this.nodes.get(key);
        if (known && this.state.marking[key] !== value) setTokens(known.group, known.node, value);
      }
      this.state.marking = { ...this.state.marking, ...marking };
    }
    if (enabled) this.#mark("enabled", new Set(enabled));
    if (fired) this.#mark("fired", new Set(fired));
    if (broken) this.#mark("broken", new Set(broken));
    if (differs) this.#mark("differs", new Set(differs));
    if (clocks) {
      for (const [key, { group }] of this.nodes) {
        const share = clocks[key] ?? 0;
        if ((this.state.clocks[key] ?? 0) !== share) setClock(group, share);
      }
      this.state.clocks = clocks;
    }
    if (problems) {
      this.#mark("problems", new Set(Object.keys(problems)), "problem");
      for (const [key, text] of Object.entries(problems)) {
        const title = this.#group(key)?.querySelector("title");
        if (title) title.textContent = text;
      }
    }
  }

  #mark(name, now, shown = name) {
    const before = this.state[name] instanceof Set ? this.state[name] : new Set();
    for (const key of before) if (!now.has(key)) this.#group(key)?.classList.remove(shown);
    for (const key of now) if (!before.has(key)) this.#group(key)?.classList.add(shown);
    if (name === "differs") this.#sign(before, now);
    this.state[name] = now;
  }

  /** The sign beside what is otherwise in another run. */
  #sign(before, now) {
    for (const key of before) if (!now.has(key)) this.#group(key)?.querySelector(":scope > .unequal")?.remove();
    for (const key of now) {
      const group = this.#group(key);
      if (group && !group.querySelector(":scope > .unequal")) group.append(element("text", { class: "unequal", x: this.boxes.has(key) ? -6 : -20, y: this.boxes.has(key) ? 2 : -9 }, "≠"));
    }
  }

  #group(key) {
    return (this.nodes.get(key) ?? this.boxes.get(key) ?? this.links.get(key))?.group;
  }

  // -- selection ------------------------------------------------------------------------------------------------------------------

  select(keys, tell = true) {
    for (const key of this.selection) this.#group(key)?.classList.remove("selected");
    this.selection = new Set(keys);
    for (const key of this.selection) this.#group(key)?.classList.add("selected");
    if (tell) this.#tell("select", { keys: [...this.selection] });
  }

  /** Start an arc from the selected node; the next node chosen is its other end. */
  connect() {
    const [first] = this.selection;
    if (!this.editable || !this.nodes.has(first)) return;
    this.connecting = first;
    this.element.classList.add("connecting");
    this.#group(first).classList.add("from");
  }

  #finish(target) {
    const source = this.connecting;
    this.#group(source)?.classList.remove("from");
    this.element.classList.remove("connecting");
    this.connecting = null;
    this.layer.band.replaceChildren();
    if (target && target !== source && this.nodes.has(target)) this.#tell("connect", { source, target });
  }

  #tell(type, detail) {
    this.element.dispatchEvent(new CustomEvent(type, { detail, bubbles: true }));
  }

  // -- arcs -----------------------------------------------------------------------------------------------------------------------

  #trace(kept, d, at) {
    kept.path.setAttribute("d", d);
    kept.hit?.setAttribute("d", d);
    if (kept.text) {
      kept.text.setAttribute("x", at[0] + 4);
      kept.text.setAttribute("y", at[1] - 3);
    }
  }

  #straighten(kept) {
    const [a, b] = [this.nodes.get(kept.link.source).node, this.nodes.get(kept.link.target).node];
    const { d, middle } = straight(a, b, kept.bend);
    kept.extent = around([[a.x, a.y], [b.x, b.y]]);
    this.#trace(kept, d, middle);
  }

  /** Move nodes and modules by a distance, with the arcs that touch them. */
  #shift(keys, dx, dy) {
    const moved = new Set();
    for (const key of keys) {
      const box = this.boxes.get(key);
      if (box) {
        box.box.x += dx;
        box.box.y += dy;
        box.group.setAttribute("transform", `translate(${box.box.x} ${box.box.y})`);
        for (const inner of [...this.nodes.keys()]) if (inner.startsWith(`${key}.`)) moved.add(inner);
        for (const [inner, held] of this.boxes) {
          if (!inner.startsWith(`${key}.`)) continue;
          held.box.x += dx;
          held.box.y += dy;
          held.group.setAttribute("transform", `translate(${held.box.x} ${held.box.y})`);
        }
      } else if (this.nodes.has(key)) moved.add(key);
    }
    for (const key of moved) {
      const { node, group } = this.nodes.get(key);
      node.x += dx;
      node.y += dy;
      group.setAttribute("transform", `translate(${node.x} ${node.y})`);
    }
    this.reach = null;
    for (const kept of this.links.values()) if (moved.has(kept.link.source) || moved.has(kept.link.target)) this.#straighten(kept);
  }

  #moved(keys) {
    const at = {};
    for (const key of keys) {
      const box = this.boxes.get(key)?.box;
      const node = box ?? this.nodes.get(key)?.node;
      if (node) at[key] = [Math.round(node.x), Math.round(node.y)];
    }
    if (Object.keys(at).length) this.#tell("move", { at });
  }

  /** Own parts of the outermost net: what can be moved here. */
  #movable(keys) {
    const boxes = [...this.boxes.keys()];
    return keys.filter((key) => (this.boxes.has(key) || this.nodes.has(key)) && !boxes.some((box) => key.startsWith(`${box}.`)));
  }

  // -- pointer and keys -----------------------------------------------------------------------------------------------------------

  #listen() {
    const svg = this.element;
    svg.addEventListener("wheel", (event) => {
      event.preventDefault();
      const { left, top } = svg.getBoundingClientRect();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), [event.clientX - left, event.clientY - top]);
    }, { passive: false });
    svg.addEventListener("pointerdown", (event) => this.#pressed(event));
    svg.addEventListener("dblclick", (event) => {
      if (event.target.closest(".scroll")) return;
      const key = event.target.closest("[data-key]")?.dataset.key;
      const [x, y] = this.at(event);
      if (key && !event.target.closest(".box")) this.#tell("open", { key });
      else if (event.target.closest(".heading")) this.#tell("open", { key });
      else if (this.editable) this.#tell("place", { x: Math.round(x), y: Math.round(y) });
    });
    svg.addEventListener("keydown", (event) => this.#key(event));
  }

  #pressed(event) {
    if (event.button !== 0 && event.button !== 1) return;
    this.element.focus({ preventScroll: true });
    const heading = event.target.closest(".fold");
    if (heading) {
      this.#tell("toggle", { key: heading.closest(".box").dataset.key });
      return;
    }
    const group = event.target.closest("[data-key]");
    const key = group && (!group.classList.contains("box") || event.target.closest(".heading")) ? group.dataset.key : null;
    if (this.connecting) {
      this.#finish(key);
      return;
    }
    if (key) {
      if (event.shiftKey || event.ctrlKey) this.select(this.selection.has(key) ? [...this.selection].filter((k) => k !== key) : [...this.selection, key]);
      else if (!this.selection.has(key)) this.select([key]);
      else this.#tell("select", { keys: [...this.selection] });
    } else if (!event.shiftKey) this.select([]);
    this.#drag(event, key);
  }

  #drag(event, key) {
    const start = this.at(event);
    let [x, y] = [event.clientX, event.clientY];
    let far = false;
    const drawing = this.editable && this.arcMode && this.nodes.has(key);
    const keys = this.editable && key && !drawing ? this.#movable([...this.selection]) : [];
    const band = !key && event.shiftKey;
    if (drawing) this.connecting = key;
    const move = (next) => {
      if (!far && Math.hypot(next.clientX - event.clientX, next.clientY - event.clientY) < 4) return;
      far = true;
      const now = this.at(next);
      if (drawing) this.layer.band.replaceChildren(element("path", { class: "band", d: `M${start.join(" ")} L${now.join(" ")}` }));
      else if (keys.length) this.#shift(keys, (next.clientX - x) / this.view.k, (next.clientY - y) / this.view.k);
      else if (band) this.#rubber(start, now);
      else if (!key) this.pan(next.clientX - x, next.clientY - y);
      [x, y] = [next.clientX, next.clientY];
    };
    const end = (next) => {
      window.removeEventListener("pointermove", move);
      window.removeEventListener("pointerup", end);
      window.removeEventListener("pointercancel", end);
      this.layer.band.replaceChildren();
      if (drawing) this.#finish(far ? document.elementFromPoint(next.clientX, next.clientY)?.closest(".node")?.dataset.key : null);
      else if (far && keys.length) this.#moved(keys);
      else if (far && band) this.select(this.#within(start, this.at(next)));
    };
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", end);
    window.addEventListener("pointercancel", end);
  }

  #rubber(a, b) {
    const [x, y] = [Math.min(a[0], b[0]), Math.min(a[1], b[1])];
    this.layer.band.replaceChildren(element("rect", { class: "band", x, y, width: Math.abs(a[0] - b[0]), height: Math.abs(a[1] - b[1]) }));
  }

  #within(a, b) {
    const inside = ({ x, y }) => x >= Math.min(a[0], b[0]) && x <= Math.max(a[0], b[0]) && y >= Math.min(a[1], b[1]) && y <= Math.max(a[1], b[1]);
    return [...this.nodes].filter(([, { node }]) => inside(node)).map(([key]) => key);
  }

  #key(event) {
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const [first] = this.selection;
    const way = arrows[event.key];
    if (way && event.shiftKey) this.pan(-60 * way[0], -60 * way[1]);
    else if (way && event.altKey && this.editable && this.selection.size) {
      const keys = this.#movable([...this.selection]);
      this.#shift(keys, STEP * way[0], STEP * way[1]);
      this.#moved(keys);
    } else if (way) this.#step(way);
    else if (event.key === "+" || event.key === "=") this.zoom(1.25);
    else if (event.key === "-") this.zoom(0.8);
    else if (event.key === "0") this.fitOrRead();
    else if (event.key === "PageDown" || event.key === "PageUp") this.page(event.key === "PageDown" ? 1 : -1);
    else if (event.key === "Escape" && this.connecting) this.#finish(null);
    else if (event.key === "Escape") this.select([]);
    else if (event.key === "Enter" && this.connecting) this.#finish(first);
    else if (event.key === "Enter" && first) this.#tell("open", { key: first });
    else if (event.key === " " && this.boxes.has(first)) this.#tell("toggle", { key: first });
    else if (event.key === "a" && !event.ctrlKey && !event.metaKey && this.editable) this.connect();
    else if ((event.key === "Delete" || event.key === "Backspace") && this.editable && this.selection.size) this.#tell("remove", { keys: [...this.selection] });
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Select the nearest part in a direction; from nothing, the one nearest to the middle of the view. */
  #step([dx, dy]) {
    const parts = [...[...this.nodes].map(([key, { node }]) => ({ key, x: node.x, y: node.y })),
      ...[...this.boxes].map(([key, { box }]) => ({ key, x: box.x + box.width / 2, y: box.y + 10 }))];
    const [first] = this.selection;
    const here = parts.find((part) => part.key === first);
    const { width, height } = this.element.getBoundingClientRect();
    const from = here ?? { x: (width / 2 - this.view.x) / this.view.k, y: (height / 2 - this.view.y) / this.view.k };
    let best = null;
    for (const part of parts) {
      const along = (part.x - from.x) * dx + (part.y - from.y) * dy;
      const beside = Math.abs((part.x - from.x) * dy) + Math.abs((part.y - from.y) * dx);
      const cost = here ? along + 3 * beside : Math.abs(along) + beside;
      if (part.key !== first && (!here || along > 1) && (!best || cost < best.cost)) best = { ...part, cost };
    }
    if (!best) return;
    this.select([best.key]);
    const [px, py] = [best.x * this.view.k + this.view.x, best.y * this.view.k + this.view.y];
    if (px < 20 || py < 20 || px > width - 60 || py > height - 20) this.centre(best.key);
  }
}
