// The view Watch: field, net, beliefs and decisions of a run, live and back; stopped, asked and changed by hand.

import { choose, el, memory } from "../dom.js";
import { askText } from "../edit/dialogs.js";
import { Beliefs } from "../watch/beliefs.js";
import { Beside } from "../watch/beside.js";
import { Curves } from "../watch/curves.js";
import { Field, nameOf } from "../watch/field.js";
import { NetView } from "../watch/netview.js";
import { Ask, Breaks, Hands, Log, Numbers } from "../watch/panels.js";

const SPEEDS = [["1", "1 / s"], ["5", "5 / s"], ["10", "10 / s"], ["30", "30 / s"], ["100", "100 / s"], ["1000", "fastest"]];

class Watch {
  constructor(root, studio) {
    this.studio = studio;
    this.connection = studio.connection;
    this.state = { playing: false, shown: [], cycles: [0, 0] };
    this.breakpoints = { nets: {}, file: "" };
    this.known = new Map(); // agent -> what watch.inside says
    this.frame = null; // what is shown
    this.live = null; // where the run stands
    this.firings = null; // of the shown cycle: {list, at}
    this.chosen = null;
    this.turn = Promise.resolve(); // ends when all that was asked for by keys and buttons is done
    this.#build(root);
    const on = (event, listener) => this.connection.on(event, listener);
    on("frame", ({ frame, cycles }) => this.#arrived(frame, cycles));
    on("log", ({ passed }) => passed.forEach((line) => this.log.add(line)));
    on("state", ({ state }) => this.#said(state));
    on("run", () => this.openAgain());
    on("stopped", ({ cycle, why }) => this.studio.note(`stopped in cycle ${cycle}: ${why.join("; ")}`));
    on("trouble", ({ error }) => this.studio.note(error, "error"));
    on("breakpoints", ({ breakpoints }) => this.#broken(breakpoints));
  }

  // ------------------------------------------------------------------ the page

  #build(root) {
    const button = (name, text, title, onclick) => el("button", { "data-do": name, title, "aria-label": title, onclick }, text);
    this.trouble = el("p", { class: "bad trouble", hidden: true, "data-show": "trouble" });
    this.field = new Field((number, x, y) => this.change({ kind: number === 0 ? "ball" : "player", whom: number === 0 ? "" : nameOf(number), values: number === 0 ? [x, y, 0, 0] : [x, y] }));
    this.play = button("play", "play", "play or pause (Space)", () => this.inTurn(() => this.toggle()));
    this.play.classList.add("main");
    this.slider = el("input", { type: "range", min: 0, max: 0, value: 0, "aria-label": "cycle", list: "differences", oninput: () => this.#slide() });
    this.at = el("output", { class: "mono", "data-show": "cycle" });
    this.resume = button("resume", "go on from here", "make this cycle the one in which the run stands (Enter)", () => this.inTurn(() => this.goOn()));
    this.speed = choose(SPEEDS, "10", (value) => this.call("watch.speed", { cycles: Number(value) }), { "aria-label": "speed" });
    this.agents = el("div", { class: "agents", role: "group", "aria-label": "agents shown in full" });
    this.firing = el("output", { class: "mono soft", "data-show": "firing" });
    this.compare = el("select", { "aria-label": "side by side", "data-show": "compare", onchange: () => this.#compare() });
    this.beliefs = new Beliefs((variable) => this.moved(variable), (names) => this.showBeliefs(names));
    this.net = new NetView((name, given) => this.call(name, given), (key) => this.choose(key));
    this.beside = new Beside({ call: (name, given) => this.connection.call(name, given), note: (text, kind) => this.studio.note(text, kind), choose: (key) => this.choose(key, true), seek: (key) => this.net.seek(key), moved: (v) => this.moved(v), look: (cycle) => this.inTurn(() => this.look(cycle)), here: { field: this.field, net: this.net } });
    this.ask = new Ask({ ask: (t) => this.why(t), seek: (key) => this.net.seek(key), breakAt: (kind, what) => this.breakAt(kind, what), moved: (v) => this.moved(v), edit: (part) => this.edit(part), curve: (text) => { this.tab("curves"); this.curves.add(text); } });
    const typed = (kind, text) => this.connection.call("watch.typed", { agent: this.agent, kind, text });
    this.breaks = new Breaks({ typed, set: (kind, what, on = true) => this.setBreak(kind, what, on), remove: (kind, what) => this.call("watch.unbreak", { net: this.inside?.net, kind, what }) });
    this.log = new Log((cycle) => this.inTurn(() => this.look(cycle)));
    this.hands = new Hands({ change: (given) => this.change(given, true), undo: () => this.call("watch.undo") });
    this.numbers = new Numbers(() => this.writeReadings());
    this.curves = new Curves({ typed, ask: (agent, what, cycles) => this.connection.call("watch.curves", { agent, what, cycles }), look: (cycle) => this.look(cycle) });
    this.tabs = [["beliefs", "Beliefs", this.beliefs], ["numbers", "Percepts", this.numbers], ["curves", "Curves", this.curves], ["differences", "Differences", this.beside]];
    this.panels = [["ask", "Why?", this.ask], ["breaks", "Breakpoints", this.breaks], ["log", "Log", this.log], ["hands", "Change", this.hands]];
    const toggle = (name, text) => el("label", {}, el("input", { type: "checkbox", checked: this.field.show[name], onchange: (e) => { this.field.show[name] = e.target.checked; this.#draw(); } }), ` ${text}`);
    this.bar = el("div", { class: "bar timeline" },
      button("start", "|◀", "back to the first cycle (Home)", () => this.inTurn(() => this.look(this.state.cycles[0]))), button("back", "◀", "one cycle back (←)", () => this.inTurn(() => this.look(this.frame.cycle - 1))),
      this.ticks = el("datalist", { id: "differences" }), this.play, button("step", "▶", "one cycle on (→)", () => this.inTurn(() => this.forth())), this.slider, this.at, this.resume,
      button("firing-back", "◂", "one firing back (,)", () => this.inTurn(() => this.fire(-1))), this.firing, button("firing", "▸", "one firing on (.)", () => this.inTurn(() => this.fire(1))), this.speed, this.agents,
      el("span", { class: "room" }), this.compare);
    this.empty = el("div", { class: "empty" });
    this.body = el("div", { class: "watch" },
      el("div", { class: "panel field-here" }, el("div", { class: "bar" }, el("h2", {}, "Field"), this.what = el("span", { class: "soft" }), el("span", { class: "room" }), toggle("near", "near"), toggle("beliefs", "beliefs"), toggle("cones", "view"), toggle("trail", "trails")), this.field.element, this.trouble, this.beside.saidHere),
      this.beside.fieldPanel, el("div", { class: "panel net-here" }, this.net.element), this.beside.netPanel,
      this.#tabbed(this.tabs, "left"), this.#tabbed(this.panels, "right"));
    root.append(el("div", { class: "watch-view" }, this.bar, this.body, this.empty));
    this.#blank("Opening …");
  }

  #tabbed(parts, side) {
    const heads = parts.map(([name, title]) => el("button", { role: "tab", "data-tab": name, onclick: () => this.tab(name) }, title));
    const bodies = parts.map(([name, , panel]) => el("div", { class: "tab-body", "data-body": name }, panel.element));
    this.sides = { ...this.sides, [side]: { heads, bodies } };
    const made = el("div", { class: `panel tabbed side-${side}` }, el("div", { class: "bar tabs", role: "tablist" }, ...heads), ...bodies);
    const remembered = memory.get(`tab.${side}`, parts[0][0]);
    this.#pick(this.sides[side], parts.some(([name]) => name === remembered) ? remembered : parts[0][0]);
    return made;
  }

  #pick({ heads, bodies }, name) {
    for (const head of heads) head.setAttribute("aria-selected", head.dataset.tab === name);
    for (const body of bodies) body.hidden = body.dataset.body !== name;
  }

  tab(name) {
    for (const [side, part] of Object.entries(this.sides)) {
      if (!part.heads.some((head) => head.dataset.tab === name)) continue;
      this.#pick(part, name);
      memory.set(`tab.${side}`, name);
    }
    this.#draw();
  }

  #shows(name) {
    return Object.values(this.sides).some(({ bodies }) => bodies.some((body) => body.dataset.body === name && !body.hidden));
  }

  #blank(text, more = null) {
    this.body.hidden = Boolean(text);
    this.bar.hidden = Boolean(text);
    this.empty.hidden = !text;
    this.empty.replaceChildren(el("p", {}, text ?? ""), ...(more ? [more] : []));
  }

  // ------------------------------------------------------------------ speaking with the server

  async call(name, given) {
    try {
      return await this.connection.call(name, given);
    } catch (error) {
      this.studio.note(error.message, "error");
      return null;
    }
  }

  openAgain() {
    return this.#inTurn(() => this.open());
  }

  async open() {
    const opening = this.frame === null;
    if (opening) this.#blank("Opening: nets and models are compiled, which takes some seconds the first time.");
    let opened;
    this.failed = false;
    try {
      opened = await this.connection.call("watch.open");
    } catch (error) {
      this.failed = true; // tried again with the next connection
      this.#blank(`It cannot be opened: ${error.message}`);
      return;
    }
    if (!opened.run) {
      this.#blank("Nothing is being watched.", el("button", { class: "main", onclick: () => this.studio.go("run") }, "choose what to play"));
      return;
    }
    this.run = opened.run;
    this.known.clear();
    this.log.clear();
    this.frame = null;
    this.field.begin(this.run);
    this.beside.begin(this.run);
    this.#chips();
    this.#comparisons();
    this.state = opened.state;
    this.live = opened.frame;
    opened.log.forEach((line) => this.log.add(line));
    this.#broken(await this.call("watch.breakpoints"));
    await this.#agent();
    this.#blank(null);
    this.#said(opened.state);
    this.#show(opened.frame);
    this.net.canvas.read();
  }

  #arrived(frame, cycles) {
    if (!this.run) return;
    const following = this.frame === null || this.live === null || this.frame.cycle === this.live.cycle || frame.cycle <= this.frame.cycle;
    this.live = frame;
    this.state.cycles = cycles;
    if (following) this.#show(frame);
    else this.#range();
  }

  #said(state) {
    const before = this.state.shown?.[0];
    this.state = { ...this.state, ...state };
    this.play.textContent = state.playing ? "pause" : "play";
    this.play.setAttribute("aria-pressed", state.playing);
    if (![...this.speed.options].some((o) => o.value === `${state.speed}`)) this.speed.append(el("option", { value: state.speed }, `${state.speed} / s`));
    this.speed.value = `${state.speed}`;
    for (const chip of this.agents.children) {
      const at = state.shown.indexOf(chip.dataset.agent);
      chip.setAttribute("aria-pressed", at >= 0);
      chip.classList.toggle("first", at === 0);
    }
    this.field.setMovable(!state.playing);
    if (before !== state.shown[0] && this.run) this.#agent().then(() => this.#draw());
  }

  get agent() {
    return this.state.shown[0];
  }

  async #agent() {
    if (!this.agent) {
      this.inside = null;
      this.beliefs.begin(null);
      return this.net.begin(null, null);
    }
    const { agent } = this;
    this.inside = null;
    if (!this.known.has(agent)) this.known.set(agent, await this.call("watch.inside", { agent }));
    if (agent !== this.agent) return undefined; // another one was chosen meanwhile
    this.inside = this.known.get(agent);
    this.chosen = null;
    this.ask.clear();
    this.beliefs.begin(this.inside);
    this.curves.begin(this.agent, this.inside);
    this.hands.begin(this.agent, this.inside, this.run);
    this.log.holds = this.inside?.holds ?? {};
    await this.net.begin(this.agent, this.inside);
    return this.#draw();
  }

  #chips() {
    const click = (agent, event) => {
      const shown = this.state.shown;
      const others = shown.filter((name) => name !== agent);
      const more = event.shiftKey || event.ctrlKey;
      this.call("watch.show", { agents: more ? (shown.includes(agent) ? others : [...shown, agent]) : [agent] });
    };
    this.agents.replaceChildren(...this.run.agents.map((agent) => el("button", { "data-agent": agent, title: `${agent}: shown in full; with Shift beside those shown`, onclick: (e) => click(agent, e) }, agent.replace("left_", "L").replace("right_", "R"))));
  }

  #comparisons() {
    const options = [["", "alone"], ["same", "beside: nothing changed by hand"], ...(this.run.changed.length + this.run.models.length ? [["shipped", "beside: as it ships"]] : []),
      ...(this.studio.about.controllers ?? []).map((name) => [`controller ${name}`, `beside: played by ${name}`])];
    this.body.classList.toggle("recorded", Boolean(this.run.recorded));
    this.compare.hidden = Boolean(this.run.recorded);
    this.compare.replaceChildren(...options.map(([value, text]) => el("option", { value }, text)));
  }

  async #compare() {
    const wanted = this.compare.value;
    this.comparing = true;
    this.chosenBeside = wanted || this.chosenBeside;
    const note = wanted && this.studio.note("playing the other run …");
    if (wanted === "") await this.call("watch.alone");
    else if (await this.call("watch.compare", wanted.startsWith("controller ") ? { controller: wanted.slice(11) } : { changed: wanted !== "shipped" })) this.tab("differences");
    if (note) note.remove();
    this.comparing = false;
    this.#draw();
  }

  /** Side by side, or alone again, by a key. */
  #sideBySide() {
    if (this.run.recorded) return null;
    this.compare.value = this.beside.on ? "" : this.chosenBeside ?? "same";
    return this.#compare();
  }

  /** Two fields and two nets while another run is beside, one of each else. */
  #split() {
    const on = Boolean(this.live?.other);
    const { heads } = this.sides.left;
    heads.at(-1).hidden = !on;
    if (!on && this.#shows("differences")) this.#pick(this.sides.left, "beliefs");
    if (this.beside.on === on) return;
    this.beside.on = on;
    if (!on) this.beside.forget();
    this.body.classList.toggle("split", on);
  }

  // ------------------------------------------------------------------ what is shown

  #show(frame) {
    if (this.frame?.cycle !== frame.cycle) this.firings = null;
    this.frame = frame;
    this.#range();
    this.#draw();
  }

  #range() {
    const [low, high] = this.state.cycles;
    this.slider.min = low;
    this.slider.max = high;
    this.slider.value = this.frame.cycle;
    const past = this.live && this.frame.cycle !== this.live.cycle;
    this.resume.hidden = !past;
    this.at.textContent = `cycle ${this.frame.cycle}${past ? ` of ${this.live.cycle}` : ""}`;
    this.play.disabled = this.live.over && !past;
  }

  /** Ask again what an agent is made of: relations bring variables. */
  async #learn() {
    if (this.learning) return;
    this.learning = true;
    const { agent } = this;
    const inside = await this.call("watch.inside", { agent });
    this.learning = false;
    if (!inside) return;
    this.known.set(agent, inside);
    if (agent === this.agent) this.inside = this.beliefs.inside = inside;
  }

  #draw() {
    let { frame } = this;
    if (!frame || !this.run || (this.agent && !this.inside)) return;
    const unknown = Object.keys(frame.agents[this.agent]?.beliefs ?? {}).some((name) => !(name in (this.inside.variables ?? {})));
    if (unknown && frame === this.live) this.#learn();
    this.#split();
    if (frame.other && !this.beside.on) frame = { ...frame, other: undefined }; // of a comparison that has ended
    const inner = frame.agents[this.agent];
    const { mode, score } = frame.world;
    const goals = score[0] + score[1] ? `, ${score.join(" : ")}` : "";
    this.what.textContent = this.run.recorded ? `${this.run.task}, ${mode.replaceAll("_", " ")}, ${score.join(" : ")}` : `${this.run.task}, seed ${this.run.seed}${this.run.world ? `, world ${this.run.world}` : ""}, ${mode.replaceAll("_", " ")}${goals}${frame.over ? `, ${frame.status.replaceAll("_", " ").toLowerCase()}` : ""}${frame.struck >= 0 ? `, ${this.run.disturbance} in cycle ${frame.struck}` : ""}`;
    const other = frame.other?.agents[this.agent];
    this.field.draw(frame, this.state.shown, { differs: frame.other?.differs.players });
    this.net.draw(inner, this.#breakKeys(), this.#atFiring(inner, this.firings?.list), this.beside.marked(frame, this.agent));
    this.beside.draw(frame, this.state.shown, this.#atFiring(other, this.firings?.there));
    if (this.#shows("beliefs")) this.beliefs.draw(inner, other, frame.other?.differs.agents?.[this.agent]?.beliefs);
    if (this.#shows("differences")) this.beside.list(frame, this.agent);
    if (this.#shows("numbers")) this.numbers.draw(inner);
    if (this.#shows("curves")) this.curves.draw(frame, this.state.cycles);
    if (this.#shows("breaks")) this.breaks.draw(this.breakpoints.nets[this.inside?.net] ?? [], this.breakpoints.file, (frame.hit ?? []).filter((h) => h.agent === this.agent));
    if (this.#shows("hands")) this.hands.draw(frame);
    if (this.#shows("ask")) this.ask.stand(frame.cycle);
    const count = inner?.fired?.length ?? 0;
    this.ticks.replaceChildren(...(frame.other?.first ? [el("option", { value: frame.other.first.cycle })] : []));
    this.firing.textContent = this.firings ? `${this.firings.at} of ${Math.max(this.firings.list.length, this.firings.there?.length ?? 0)} ${this.firings.list[this.firings.at - 1]?.transition ?? ""}` : `${count} fired`;
    this.trouble.hidden = !frame.trouble;
    this.trouble.textContent = frame.trouble ?? "";
    if (!this.comparing) this.compare.value = this.beside.on ? this.chosenBeside ?? "same" : "";
    if (frame.other_error) this.studio.note(`the other run could not go on: ${frame.other_error}`, "error");
  }

  #breakKeys() {
    return (this.breakpoints.nets[this.inside?.net] ?? []).filter((b) => b.on && b.kind !== "when").map((b) => b.what);
  }

  #atFiring(inner, list) {
    if (!list || !inner?.marking) return null;
    const { at } = this.firings;
    const tokens = {};
    for (const firing of [...list].reverse()) for (const [place, [before]] of Object.entries(firing.tokens)) tokens[place] = before;
    for (const firing of list.slice(0, at)) for (const [place, [, after]] of Object.entries(firing.tokens)) tokens[place] = after;
    const now = list[at - 1];
    return { tokens, fired: now ? [now.transition] : [], enabled: list[at] ? [list[at].transition, ...list[at].enabled] : [] };
  }

  #broken(breakpoints) {
    if (breakpoints) this.breakpoints = breakpoints;
    this.#draw();
  }

  // ------------------------------------------------------------------ what one does

  toggle() {
    if (this.state.playing) return this.call("watch.pause");
    return this.#past() ? this.goOn().then(() => this.call("watch.play")) : this.call("watch.play");
  }

  #past() {
    return this.live && this.frame && this.frame.cycle !== this.live.cycle;
  }

  /** Do something when all that was asked for before is done: what it does depends on where that led, and no key is lost. */
  inTurn(doing) {
    return this.#inTurn(() => (this.frame ? doing() : null));
  }

  #inTurn(doing) {
    const done = this.turn.then(doing);
    this.turn = done.catch(() => {});
    return done;
  }

  /** Look at where the slider is: while it is dragged, at the places that the server can keep up with. */
  #slide() {
    const waits = this.wanted !== undefined;
    this.wanted = Number(this.slider.value);
    if (waits) return null;
    return this.#inTurn(() => {
      const { wanted } = this;
      this.wanted = undefined;
      return this.frame ? this.look(wanted) : null;
    });
  }

  async look(cycle) {
    const [low, high] = this.state.cycles;
    const wanted = Math.max(low, Math.min(high, cycle));
    if (this.state.playing) await this.call("watch.pause");
    const frame = wanted === this.live.cycle ? this.live : await this.call("watch.frame", { cycle: wanted });
    if (frame) this.#show(frame);
  }

  forth() {
    return this.#past() ? this.look(this.frame.cycle + 1) : this.call("watch.step");
  }

  async goOn() {
    const frame = await this.call("watch.go", { cycle: this.frame.cycle });
    if (!frame) return;
    this.live = frame;
    this.#show(frame);
  }

  /** One firing on or back; after the last comes the next cycle, before the first the one before. */
  async fire(by) {
    if (!this.inside?.net) return;
    if (this.state.playing) await this.call("watch.pause");
    if (!this.firings) await this.#fetch(by > 0 ? 0 : Infinity);
    if (!this.firings) return;
    const at = this.firings.at + by;
    if (at > Math.max(this.firings.list.length, this.firings.there?.length ?? 0)) {
      if (this.live.over && !this.#past()) return;
      await this.forth();
      await this.#fetch(0);
    } else if (at < 0) {
      if (this.frame.cycle <= this.state.cycles[0]) return;
      await this.look(this.frame.cycle - 1);
      await this.#fetch(Infinity);
    } else this.firings.at = at;
    this.#draw();
  }

  async #fetch(at) {
    const { agent, frame } = this;
    const list = await this.call("watch.firings", { agent, cycle: frame.cycle });
    const there = this.beside.on && frame.other?.agents[agent]?.marking && frame.other.cycle === frame.cycle ? await this.beside.ask("watch.firings", { agent, cycle: frame.cycle }) : null;
    const still = list && agent === this.agent && frame.cycle === this.frame?.cycle;
    this.firings = still ? { list, there, at: Math.min(at, Math.max(list.length, there?.length ?? 0)) } : null;
  }

  /** A part of the net was chosen; `there`: in the run beside. */
  choose(key, there = false) {
    this.chosen = key;
    const inside = there ? this.beside.inside : this.inside;
    if (!inside?.net || !this.frame) return null; // chosen before a run is there
    if (inside.transitions.includes(key)) return this.why(key, there);
    if (inside.places.includes(key)) {
      this.tab("ask");
      const other = this.beside.on ? this.frame.other?.agents[this.agent] : null;
      this.ask.asked(this.frame.cycle, () => this.choose(key, there));
      if (there) this.ask.place(key, other, inside);
      else this.ask.place(key, this.frame.agents[this.agent], inside, other?.marking ? other : null);
    }
    return null;
  }

  why(transition, there = false) {
    return this.#answer(transition, "watch.why", { transition, ...(there ? { beside: true } : {}) }, (answer) => this.ask.transition(answer, there));
  }

  /** Show the distributions of these variables of the agent; null: of those that his net reads. */
  showBeliefs(names) {
    this.beliefs.back.hidden = names === null;
    return this.call("watch.show", { agents: this.state.shown, variables: names === null ? {} : { [this.agent]: names } });
  }

  moved(variable) {
    const unit = this.inside.variables[variable]?.unit;
    return this.#answer(variable, "watch.moved", { variable }, (answer) => this.ask.belief(answer, unit ? ` ${unit}` : ""));
  }

  async #answer(what, name, given, show) {
    this.tab("ask");
    if (this.state.playing) await this.call("watch.pause");
    if (!this.frame) return;
    const { cycle } = this.frame;
    this.ask.wait(what);
    this.ask.asked(cycle, () => this.#answer(what, name, given, show));
    try {
      show(await this.connection.call(name, { agent: this.agent, cycle, ...given }));
    } catch (error) {
      this.ask.fail(error.message);
    }
  }

  async breakAt(kind, what) {
    try {
      await this.setBreak(kind, what, true);
      this.tab("breaks");
    } catch (error) {
      this.studio.note(error.message, "error");
    }
  }

  async setBreak(kind, what, on) {
    this.#broken(await this.connection.call("watch.break", { net: this.inside?.net ?? "", kind, what, on }));
  }

  change(given, told = false) {
    return this.inTurn(async () => {
      if (this.#past()) await this.goOn();
      return told ? this.connection.call("watch.change", given) : this.call("watch.change", given);
    });
  }

  /** Keep what the model was told as a log. */
  async writeReadings() {
    const path = await askText("Readings as a log", { value: `${this.agent}_readings.json`, label: "file", action: "write", hint: "A new .json file in the folder of the studio; Learn… in Models reads it." });
    const done = path && (await this.call("watch.readings", { agent: this.agent, path }));
    if (done) this.studio.note(`written: ${done.written}, ${done.slices} cycles`);
  }

  edit(part) {
    if (part && this.inside?.net) this.studio.go("nets", { part, net: this.inside.net });
  }

  #breakChosen() {
    if (this.chosen && this.inside?.places?.concat(this.inside.transitions).includes(this.chosen)) this.breakAt(this.inside.transitions.includes(this.chosen) ? "fires" : "marked", this.chosen);
  }

  keys() {
    return [
      ...[
        [" ", "play or pause", () => this.toggle()], ["ArrowRight", "one cycle on", () => this.forth()], ["ArrowLeft", "one cycle back", () => this.look(this.frame.cycle - 1)],
        ["Home", "the first cycle", () => this.look(this.state.cycles[0])], ["End", "where the run stands", () => this.look(this.live.cycle)],
        ["Enter", "go on from the cycle shown", () => this.#past() && this.goOn()], [".", "one firing on", () => this.fire(1)], [",", "one firing back", () => this.fire(-1)],
      ].map(([key, what, doing]) => [key, what, () => this.inTurn(doing)]),
      ["b", "stop at the chosen part", () => this.#breakChosen()], ["e", "edit the chosen part in Nets", () => this.edit(this.chosen)], ["f", "find a part of the net", () => this.inTurn(() => this.net.find.focus())], ["n", "to the net (then arrows choose, + - 0 zoom)", () => this.net.canvas.element.focus()],
      ["w", "why?", () => this.tab("ask")], ["s", "breakpoints", () => this.tab("breaks")], ["g", "curves", () => this.tab("curves")], ["l", "log", () => this.tab("log")], ["c", "change by hand", () => this.tab("hands")],
      ["x", "another run beside this one, or this one alone", () => this.inTurn(() => this.#sideBySide())], ["d", "to the first difference of two runs side by side", () => this.beside.on && (this.tab("differences"), this.beside.toFirst())],
      ["m", "move things: Tab to one, arrows, Enter", () => this.field.svg.querySelector(".thing")?.focus()],
    ];
  }
}

export default {
  name: "watch",
  title: "Watch",
  create(root, studio) {
    const watch = new Watch(root, studio);
    studio.connection.on("connection", ({ state }) => state === "open" && (watch.run || watch.failed) && watch.openAgain());
    return { show: () => (watch.run ? undefined : watch.openAgain()), keys: watch.keys() };
  },
};
