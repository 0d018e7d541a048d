// The editor of nets: documents and definitions at the left, the canvas in the middle, what is selected and what checks found at the right.

import { el, memory } from "../dom.js";
import { deskOf } from "../edit/desk.js";
import { askText, openFile, openShipped, pick } from "../edit/dialogs.js";
import { closeDocument, documentKeys, documentRow, DocumentTools } from "../edit/documents.js";
import { Game } from "../edit/game.js";
import { Inspector, NEEDED, portsOf } from "../edit/inspector.js";
import { NetCanvas } from "../netcanvas.js";

const QUANTITIES = ["input", "belief", "math", "continuous"];
const PLACES = [["place", "Place"], ["input", "Input place"], ["belief", "Belief place"], ["math", "Math place"], ["continuous", "Continuous place"], ["object", "Object place"]];

export default {
  name: "nets",
  title: "Nets",
  create: (root, studio) => new NetsView(root, studio),
};

class NetsView {
  constructor(root, studio) {
    this.studio = studio;
    this.desk = deskOf(studio);
    this.unfolded = new Set();
    this.chosen = memory.get("edit.definition", "");
    this.desk.quantities = memory.get("edit.quantities", false);
    this.build(root);
    this.desk.addEventListener("documents", () => this.listDocuments());
    this.desk.addEventListener("document", () => this.changed());
    this.desk.addEventListener("findings", () => this.showFindings());
    this.keys = this.keyMap();
    this.canvas.element.parentElement.hidden = true;
    this.empty.replaceChildren(el("p", { role: "status" }, "opening…"));
    if (!this.desk.started) this.desk.begin().catch((error) => this.fail(error));
    else this.changed();
  }

  build(root) {
    const button = (text, title, onclick, name) => {
      const made = el("button", { title, onclick, "data-do": name }, text);
      return made;
    };
    this.side = el("nav", { class: "panel side", "aria-label": "documents" });
    this.arcKind = el("select", { "aria-label": "kind of arc that is drawn", title: "kind of arc that is drawn" }, ...["input or output", "test", "inhibitor", "set"].map((kind) => el("option", { value: kind }, kind)));
    this.arcMode = button("Arcs", "draw arcs by dragging from part to part (w)", () => this.setArcMode(!this.canvas.arcMode), "arcs");
    const add = el("select", { "aria-label": "add a part", "data-do": "add", onchange: () => {
      const kind = add.value;
      add.value = "";
      if (kind) this.add(kind);
    } }, el("option", { value: "" }, "Add…"), ...[...PLACES, ["transition", "Transition"], ["timed", "Timed transition"], ["output", "Transition with a command"], ["module", "Module…"]].map(([value, text]) => el("option", { value }, text)));
    this.files = new DocumentTools(this.desk, [["json", "JSON"], ["pnml", "PNML"], ["python", "Python"]]);
    this.tools = el("div", { class: "bar tools", role: "toolbar", "aria-label": "net" }, add, this.arcMode, this.arcKind, this.files.undo, this.files.redo,
      button("Arrange", "forget positions chosen by hand and lay out anew", () => this.desk.try({ op: "arrange", in: this.chosen }), "arrange"), button("Fit", "show all, or, when all is seen, as large as can be read (0)", () => this.canvas.fitOrRead(), "fit"),
      this.values = button("Quantities", "inputs, beliefs, math and continuous places, too (q)", () => this.showQuantities(!this.desk.quantities), "quantities"), button("Play", "the token game (g)", () => this.play(), "play"), el("span", { class: "room" }),
      this.files.save, this.files.file);
    this.way = el("div", { class: "bar way", "aria-label": "where" });
    const middle = el("div", { class: "canvas panel" });
    this.canvas = new NetCanvas(middle, { editable: true, label: "net; arrows select, Enter opens, a draws an arc, Delete removes" });
    this.empty = el("div", { class: "empty" });
    this.form = el("div", { class: "panel form", "aria-label": "what is selected" });
    this.found = el("div", { class: "panel found", "aria-label": "checks" });
    root.replaceChildren(el("div", { class: "nets" }, this.side, el("div", { class: "middle" }, this.tools, this.way, middle, this.empty), el("div", { class: "right" }, this.form, this.found)));
    this.inspector = new Inspector(this.form, this.desk, { definition: () => this.chosen, open: (key, part) => this.open(key, part), select: (keys) => this.select(keys) });
    this.game = new Game(this.form, this.desk, this.canvas, () => {
      this.draw({ keep: true });
      this.inspector.show([...this.canvas.selection]);
    });
    const svg = this.canvas.element;
    svg.addEventListener("select", ({ detail }) => {
      if (this.game.on) {
        if (detail.keys.length === 1) this.game.fire(detail.keys[0]);
      } else this.inspector.show(detail.keys);
    });
    svg.addEventListener("open", ({ detail }) => this.enter(detail.key));
    svg.addEventListener("toggle", ({ detail }) => this.toggle(detail.key));
    svg.addEventListener("move", ({ detail }) => this.desk.try({ op: "move", in: this.chosen, at: detail.at }));
    svg.addEventListener("connect", ({ detail }) => this.connect(detail));
    svg.addEventListener("place", ({ detail }) => this.add("place", [detail.x, detail.y]));
    svg.addEventListener("remove", ({ detail }) => this.remove(detail.keys));
    this.form.addEventListener("remove", ({ detail }) => this.remove(detail.keys));
  }

  keyMap() {
    const edit = (f) => () => !this.game.on && this.desk.net && f();
    return [
      ...documentKeys(this.desk),
      ["p", "add a place", edit(() => this.add("place"))], ["t", "add a transition", edit(() => this.add("transition"))], ["m", "add a module", edit(() => this.add("module"))],
      ["a", "on the canvas: an arc from what is selected; the next part chosen is its end", edit(() => this.canvas.connect())], ["w", "draw arcs by dragging, or move parts", edit(() => this.setArcMode(!this.canvas.arcMode))],
      ["Ctrl+c", "copy what is selected", edit(() => this.copy())], ["Ctrl+v", "paste it, in this net or another", edit(() => this.paste())], ["f", "find a part", () => this.find()],
      ["e", "go to the form of what is selected", () => this.form.querySelector("input")?.focus()], ["u", "up to the net around", () => this.up()],
      ["g", "begin or end the token game", () => (this.game.on ? this.game.end() : this.play())], ["c", "in the token game: run a cycle", () => this.game.on && this.game.take("cycle")], ["b", "in the token game: take back", () => this.game.on && this.game.take("back")],
      ["q", "show or hide quantities", () => this.showQuantities(!this.desk.quantities)], ["Escape", "end the token game", () => this.game.on && this.game.end()],
      ["Arrows", "on the canvas: select; with Shift move the view, with Alt move what is selected", () => {}], ["Enter", "on the canvas: open a module, or the form; in the token game: fire", () => {}], ["Delete", "on the canvas: remove what is selected", () => {}],
    ];
  }

  show(what) {
    if (what?.part) this.wanted = what;
    if (this.wanted && this.desk.current) {
      const wanted = this.wanted;
      this.wanted = null;
      this.seek(wanted);
    }
    if (this.canvas.waitingToFit) requestAnimationFrame(() => this.canvas.read());
    if (this.desk.current && !this.canvas.plan) this.changed();
  }

  fail(error) {
    this.empty.hidden = false;
    this.empty.replaceChildren(el("h1", {}, "Not to be opened"), el("p", {}, error.message));
  }

  // -- documents ----------------------------------------------------------------------------------------------------------------------

  listDocuments() {
    const { current } = this.desk;
    const net = this.desk.net;
    const definitions = net ? Object.keys(net.definitions).reverse() : [];
    const mark = (key) => ({ false: "✗ ", null: "", true: "" })[String(this.worst(key))];
    this.side.replaceChildren(el("h3", {}, "Open"), ...this.desk.documents.map((one) => documentRow(this.desk, one)),
      el("div", { class: "bar" }, el("button", { onclick: () => openFile(this.desk) }, "Open…"), el("button", { onclick: () => this.newNet() }, "New…"), el("button", { onclick: () => openShipped(this.desk) }, "Copy of…")),
      ...(net ? [el("h3", {}, "Nets in it"), ...definitions.map((key) => el("button", { class: "doc", "aria-current": key === this.chosen, onclick: () => this.open(key) }, mark(key), key, key === net.net ? el("span", { class: "soft" }, " file") : "")),
        el("div", { class: "bar" }, el("button", { title: "a new, empty net in this file", onclick: () => this.define() }, "New"), el("button", { title: "the nets of another file", onclick: () => this.bringIn() }, "From file…"), el("button", { title: "remove the net that is shown", disabled: this.chosen === net.net, onclick: () => this.undefine() }, "Remove"))] : []),
      ...(current ? [el("div", { class: "bar" }, current.path ? el("button", { title: "take back all changes since the file was saved", disabled: current.saved, onclick: () => this.desk.ask("discard") }, "Back to the file") : null, el("button", { onclick: () => closeDocument(this.desk) }, "Close"))] : []));
    this.files.show();
  }

  async newNet() {
    const name = await askText("A new net", { value: "behaviour", action: "make" });
    if (name) await this.desk.bring("new", { kind: "net", name });
  }

  async define() {
    const name = await askText("A new net in this file", { value: "module", action: "make" });
    if (name && (await this.desk.try({ op: "define", name }))) this.open(name);
  }

  async undefine() {
    const gone = this.chosen;
    if (await this.desk.try({ op: "undefine", name: gone })) this.open(this.desk.net.net);
  }

  async bringIn() {
    const files = await this.desk.call("browse", {});
    const path = await pick("Nets of another file", files.map((file) => [file, file]), { empty: `no files in ${this.desk.root}` });
    if (path) await this.desk.ask("take_file", { path });
  }

  // -- what is shown --------------------------------------------------------------------------------------------------------------------

  async changed() {
    const net = this.desk.net;
    const none = !net;
    this.canvas.element.parentElement.hidden = none;
    this.empty.hidden = !none;
    for (const part of [this.way, this.form, this.found]) part.hidden = none;
    for (const part of this.tools.querySelectorAll("button, select")) part.disabled = none;
    if (none) {
      const text = this.desk.current ? "This file holds a model, no net." : "No net is open.";
      this.empty.replaceChildren(el("h1", {}, text), el("p", {}, "Open a file, begin a new net, or take a copy of one that comes with the package."), el("div", { class: "bar" }, el("button", { class: "main", onclick: () => openShipped(this.desk) }, "Copy of…"), el("button", { onclick: () => openFile(this.desk) }, "Open…"), el("button", { onclick: () => this.newNet() }, "New…"),
        this.desk.current ? el("button", { onclick: () => this.studio.go("models") }, "Show the model") : null));
      this.listDocuments();
      this.findNow();
      return;
    }
    if (!net.definitions[this.chosen]) this.chosen = net.net;
    memory.set("edit.definition", this.chosen);
    this.desk.front = this.chosen;
    if (this.game.on) await this.game.end();
    await this.draw({ keep: this.drawn === `${this.desk.current.id} ${this.chosen}` });
    this.listDocuments();
    this.inspector.show([...this.canvas.selection]);
    this.showFindings();
    if (this.wanted) this.show();
    this.findNow();
  }

  /** The search that was asked for before a net was there. */
  findNow() {
    if (!this.finding) return;
    this.finding = false;
    this.find();
  }

  async draw({ keep = false } = {}) {
    const [id, definition] = [this.desk.current.id, this.chosen];
    try {
      const plan = await this.desk.call("view", { id, definition, unfold: [...this.unfolded], quantities: this.desk.quantities });
      if (id !== this.desk.current?.id || definition !== this.chosen) return;
      this.canvas.show(plan, { keep });
      this.values.setAttribute("aria-pressed", this.desk.quantities);
      this.drawn = `${id} ${definition}`;
      this.mark();
    } catch (error) {
      this.studio.note(error.message, "error");
    }
    this.showWay();
  }

  showWay() {
    const path = this.trail ?? [];
    this.way.replaceChildren(...path.flatMap((key) => [el("button", { class: "plain", onclick: () => this.open(key) }, key), "›"]), el("strong", {}, this.chosen), el("span", { class: "room" }), this.files.state);
  }

  async open(key, part) {
    const trail = this.trail ?? [];
    this.trail = trail.includes(key) ? trail.slice(0, trail.indexOf(key)) : this.uses(this.chosen, key) ? [...trail, this.chosen] : [];
    this.chosen = key;
    this.unfolded.clear();
    this.canvas.select([], false);
    await this.changed();
    if (!this.desk.findingsOf(key).length) this.desk.call("check", { id: this.desk.current.id, first: key }).catch(() => {});
    if (part) await this.select([part]);
  }

  uses(outer, inner) {
    return Object.values(this.desk.net?.definitions[outer]?.modules ?? {}).includes(inner);
  }

  up() {
    const outer = this.trail?.at(-1) ?? Object.keys(this.desk.net?.definitions ?? {}).find((key) => this.uses(key, this.chosen));
    if (outer) this.open(outer);
  }

  async select(keys) {
    const isQuantity = (name) => this.desk.net?.definitions[this.chosen]?.places.some((p) => p.name === name && QUANTITIES.includes(p.kind));
    if (!this.desk.quantities && keys.some((key) => !this.canvas.nodes.has(key) && isQuantity(key))) await this.showQuantities(true);
    this.canvas.select(keys.filter((key) => this.canvas.nodes.has(key) || this.canvas.boxes.has(key)));
    if (keys.length) this.canvas.centre(keys[0]);
  }

  enter(key) {
    if (this.game.on) this.game.fire(key);
    else if (this.desk.net.definitions[this.chosen].modules?.[key]) this.open(this.desk.net.definitions[this.chosen].modules[key]);
    else if (this.canvas.boxes.has(key)) this.open(this.canvas.boxes.get(key).box.definition);
    else this.form.querySelector("input")?.focus();
  }

  async toggle(key) {
    if (this.unfolded.has(key)) for (const path of [...this.unfolded]) (path === key || path.startsWith(`${key}.`)) && this.unfolded.delete(path);
    else this.unfolded.add(key);
    await this.draw({ keep: true });
    this.canvas.reveal(key);
    if (this.game.on) this.game.show();
  }

  async showQuantities(on) {
    this.desk.quantities = on;
    memory.set("edit.quantities", on);
    if (!this.desk.net) return;
    await this.draw({ keep: false });
    if (this.game.on) this.game.show();
  }

  setArcMode(on) {
    this.canvas.arcMode = on;
    this.arcMode.setAttribute("aria-pressed", on);
  }

  // -- changes ------------------------------------------------------------------------------------------------------------------------

  free(wanted) {
    const own = this.desk.net.definitions[this.chosen];
    const taken = new Set([...own.places, ...own.transitions].map((part) => part.name).concat(Object.keys(own.modules ?? {})));
    let [name, number] = [wanted, 1];
    while (taken.has(name)) name = `${wanted}_${(number += 1)}`;
    return name;
  }

  /** Where a new part stands: in the middle of what is seen, beside others; where nothing was put by hand, the layout finds a place. */
  spot() {
    if (!this.desk.net.layout?.[this.chosen]) return undefined;
    const { width, height } = this.canvas.element.getBoundingClientRect();
    const { x, y, k } = this.canvas.view;
    const at = [Math.round((width / 2 - x) / k), Math.round((height / 2 - y) / k)];
    const near = () => [...this.canvas.nodes.values()].some(({ node }) => Math.hypot(node.x - at[0], node.y - at[1]) < 40);
    while (near()) at[1] += 45;
    return at;
  }

  async add(kind, at = this.spot()) {
    if (!this.desk.net || this.game.on) return;
    if (kind === "module") {
      this.addModule(at);
      return;
    }
    const isPlace = PLACES.some(([name]) => name === kind);
    if (QUANTITIES.includes(kind) && !this.desk.quantities) await this.showQuantities(true);
    let name;
    const made = () => {
      name = this.free(isPlace ? kind : kind === "output" ? "command" : "transition");
      return isPlace ? { op: "add_place", in: this.chosen, place: { kind, name, ...(NEEDED[kind] ?? {}) }, at }
        : { op: "add_transition", in: this.chosen, transition: { name, ...(kind === "timed" || kind === "output" ? { delay: 1 } : {}), ...(kind === "output" ? { emits: { command: "turn", params: { moment: 0 } } } : {}) }, at };
    };
    if (await this.desk.try(made)) {
      await this.drawing();
      this.select([name]);
      this.form.querySelector("input")?.select();
      this.form.querySelector("input")?.focus();
    }
  }

  async addModule(at) {
    const others = Object.keys(this.desk.net.definitions).filter((key) => key !== this.chosen).map((key) => [`own:${key}`, key, "of this file"]);
    const shipped = (await this.desk.call("shipped", {})).map((name) => [`ship:${name}`, name, "comes with the package"]);
    const choice = await pick("Embed a module", [...others, ...shipped], { hint: "Nets of other files: “From file…” at the left brings them in." });
    if (!choice) return;
    const name = choice.slice(choice.indexOf(":") + 1);
    const instance = this.free(name.replace(/\W/g, "_"));
    const embed = { op: "embed", in: this.chosen, instance, definition: name, at };
    const done = choice.startsWith("own:") ? await this.desk.try(embed) : await this.desk.ask("take_shipped", { name, embed });
    if (done) {
      await this.drawing();
      this.select([instance]);
    }
  }

  /** Until the drawing shows the newest state. */
  async drawing() {
    await this.draw({ keep: true });
  }

  async remove(keys) {
    if (this.game.on) return;
    const own = this.desk.net.definitions[this.chosen];
    const ops = [];
    const names = [];
    for (const key of keys) {
      if (!key.includes("\t")) names.push(key);
      else {
        const [style, source, target] = key.split("\t");
        const transition = own.transitions.find((t) => t.name === source || t.name === target)?.name;
        const place = transition === source ? target : source;
        const arc = style === "arc" ? (transition === target ? "input" : "output") : style;
        if (style === "fuse") ops.push({ op: "fuse", in: this.chosen, port: target, place: "" });
        else if (["arc", "test", "inhibitor", "set"].includes(style)) ops.push({ op: "disconnect", in: this.chosen, place, transition, arc });
      }
    }
    if (names.length) ops.push({ op: "remove", in: this.chosen, names });
    if (!ops.length) return;
    if (await this.desk.try(ops.length === 1 ? ops[0] : { op: "all", ops, what: "remove" })) this.canvas.select([]);
  }

  async connect({ source, target }) {
    const own = this.desk.net.definitions[this.chosen];
    const isTransition = (key) => own.transitions.some((t) => t.name === key);
    const wish = this.arcKind.value;
    if (isTransition(source) === isTransition(target)) {
      const port = [source, target].find((key) => key.includes("."));
      if (isTransition(source) || !port) this.studio.note("an arc joins a place and a transition; a port of a module and a place are made one", "error");
      else await this.desk.try({ op: "fuse", in: this.chosen, port, place: port === source ? target : source });
      return;
    }
    const inward = isTransition(target);
    const arc = inward ? (["test", "inhibitor"].includes(wish) ? wish : "input") : wish === "set" ? "set" : "output";
    await this.desk.try({ op: "connect", in: this.chosen, place: inward ? source : target, transition: inward ? target : source, arc });
  }

  /** Find a part; asked before a net is there, it begins when the net comes. */
  async find() {
    if (!this.desk.net) {
      this.finding = !this.desk.begun;
      this.studio.note(this.finding ? "the net is being opened; the search begins when it is here" : "no net is open, so there is no part to be found", this.finding ? "good" : "error");
      return;
    }
    const { definitions } = this.desk.net;
    const parts = Object.entries(definitions).flatMap(([key, own]) => [...own.places, ...own.transitions, ...Object.keys(own.modules ?? {}).map((name) => ({ name }))].map(({ name }) => [`${key}\t${name}`, name, `in ${key}`]));
    parts.sort(([a], [b]) => b.startsWith(`${this.chosen}\t`) - a.startsWith(`${this.chosen}\t`));
    const found = await pick("Find a part", parts);
    if (found) await this.goTo(...found.split("\t"));
    this.canvas.element.focus();
  }

  async goTo(definition, part) {
    if (definition !== this.chosen) await this.open(definition, part);
    else await this.select([part]);
  }

  /** Show a part by its flat name, of the net of that name. */
  async seek({ part, net }) {
    if (net && this.desk.net?.net !== net) {
      for (const one of this.desk.documents.filter((d) => d.net)) {
        await this.desk.show(one.id);
        if (this.desk.net?.net === net) break;
      }
    }
    if (!this.desk.net) return;
    let [key, rest] = [this.desk.net.net, part];
    for (;;) {
      const instance = rest.split(".")[0];
      const inner = this.desk.net.definitions[key].modules?.[instance];
      if (!inner || rest === instance) break;
      [key, rest] = [inner, rest.slice(instance.length + 1)];
    }
    await this.goTo(key, rest);
  }

  /** Take the selected places and transitions along, with the arcs among them and those to places of the same name. */
  copy() {
    const own = this.desk.net.definitions[this.chosen];
    const chosen = (list) => structuredClone(list.filter((part) => this.canvas.selection.has(part.name)));
    const at = Object.fromEntries([...this.canvas.selection].filter((key) => this.canvas.nodes.has(key)).map((key) => [key, [this.canvas.nodes.get(key).node.x, this.canvas.nodes.get(key).node.y]]));
    this.taken = { places: chosen(own.places), transitions: chosen(own.transitions), at };
    this.studio.note(`copied ${this.taken.places.length} places and ${this.taken.transitions.length} transitions`);
  }

  async paste() {
    if (!this.taken?.places.length && !this.taken?.transitions.length) return;
    let names = [];
    const made = () => {
      const { ops, names: given } = this.pasted(this.taken);
      names = given;
      return { op: "all", ops, what: "paste" };
    };
    if (await this.desk.try(made)) {
      await this.drawing();
      this.select(names);
    }
  }

  /** What adds copied parts to this net, and the names that they get here. */
  pasted({ places, transitions, at }) {
    const own = this.desk.net.definitions[this.chosen];
    const used = new Set([...own.places, ...own.transitions].map((part) => part.name).concat(Object.keys(own.modules ?? {})));
    const there = new Set([...own.places.map((p) => p.name), ...Object.entries(own.modules ?? {}).flatMap(([i, target]) => portsOf(this.desk.net.definitions[target]).map((port) => `${i}.${port}`))]);
    const names = new Map();
    for (const part of [...places, ...transitions]) {
      let [name, number] = [part.name, 1];
      while (used.has(name)) name = `${part.name}_${(number += 1)}`;
      used.add(name);
      names.set(part.name, name);
    }
    const fixed = this.desk.net.layout?.[this.chosen];
    const moved = (name) => (fixed && at[name] ? at[name].map((v) => Math.round(v + 40)) : undefined);
    const arcs = (of = {}) => Object.fromEntries(Object.entries(of).filter(([place]) => places.some((p) => p.name === place) || there.has(place)).map(([place, weight]) => [places.some((p) => p.name === place) ? names.get(place) : place, weight]));
    const copied = (t) => ({ ...t, name: names.get(t.name), ...Object.fromEntries(["inputs", "outputs", "tests", "inhibitors", "sets"].filter((key) => t[key]).map((key) => [key, arcs(t[key])])) });
    const ops = [...places.map((p) => ({ op: "add_place", in: this.chosen, place: { ...p, name: names.get(p.name) }, at: moved(p.name) })), ...transitions.map((t) => ({ op: "add_transition", in: this.chosen, transition: copied(t), at: moved(t.name) }))];
    return { ops, names: [...names.values()] };
  }

  play() {
    if (this.desk.net) this.game.begin(this.chosen);
  }

  // -- checks ---------------------------------------------------------------------------------------------------------------------------

  worst(key) {
    const all = this.desk.findingsOf(key).map((one) => one.holds);
    return all.includes(false) ? false : all.length ? true : null;
  }

  mark() {
    const problems = {};
    for (const one of this.desk.findingsOf(this.chosen)) if (one.holds === false) for (const name of one.names) problems[name] = `${one.kind}, ${one.title}: ${one.text}`;
    this.canvas.update({ problems });
  }

  showFindings() {
    if (!this.desk.net) return;
    this.mark();
    const findings = this.desk.findingsOf(this.chosen);
    const checking = this.desk.isChecking(this.chosen);
    const signs = { true: ["✓", "holds"], false: ["✗", "broken"], null: ["–", "open"] };
    const row = (one) => {
      const [sign, word] = signs[String(one.holds)];
      const line = el("button", { class: `finding ${word}`, title: `${one.kind}: ${word}`, onclick: () => this.select(one.names) }, el("span", { class: "sign", "aria-label": word }, sign), el("span", {}, el("strong", {}, one.title), ` ${one.text}`));
      return one.run.length ? el("div", {}, line, el("details", {}, el("summary", {}, `a run of ${one.run.length} ${one.run.length === 1 ? "step" : "steps"} shows it`), el("ol", { class: "run" }, ...one.run.map((step) => el("li", {}, step))))) : line;
    };
    const groups = ["contract", "composition", "structure"].map((kind) => [kind, findings.filter((one) => one.kind === kind).sort((a, b) => (a.holds === false ? 0 : 1) - (b.holds === false ? 0 : 1))]);
    this.found.replaceChildren(el("h3", {}, "Checks", el("span", { class: "soft" }, checking ? " running…" : findings.length ? "" : " none yet")), ...groups.flatMap(([kind, all]) => (all.length ? [el("h4", {}, kind), ...all.map(row)] : [])));
    this.found.classList.toggle("stale", checking);
    this.listDocuments();
  }
}
