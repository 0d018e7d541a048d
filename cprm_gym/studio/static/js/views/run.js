// The view Run: what is watched is chosen, many episodes are played, results are opened, runs that analysis found are played.

import { choose, el } from "../dom.js";
import { Witnesses } from "../run/witnesses.js";

const percent = (x) => `${(100 * x).toFixed(1)} %`;
const KEPT_ROWS = 2000;

class RunView {
  constructor(root, studio) {
    this.studio = studio;
    this.connection = studio.connection;
    this.only = "all";
    this.form = el("form", { class: "panel form", onsubmit: (event) => { event.preventDefault(); this.watch(); } });
    this.progress = el("progress", { max: 1, value: 0, "aria-label": "episodes played", hidden: true });
    this.summary = el("p", { "data-show": "episodes" }, "No episodes yet.");
    this.filter = choose([["all", "all"], ["failures", "failures"], ["successes", "successes"]], "failures", () => this.#rows(), { "aria-label": "which episodes are listed" });
    this.stop = el("button", { "data-do": "stop", hidden: true, onclick: () => this.call("run.stop") }, "stop");
    this.list = el("tbody");
    this.episodes = el("div", { class: "panel" }, el("div", { class: "bar" }, el("h2", {}, "Episodes"), this.progress, this.stop, el("span", { class: "room" }), this.filter),
      el("div", { class: "tab-body" }, this.summary, el("table", { class: "rows" }, this.heads = el("thead", { hidden: true }, el("tr", {}, ...["world", "outcome", "cycles", "struck", ""].map((h) => el("th", {}, h)))), this.list)));
    this.results = el("div", { class: "panel", hidden: true });
    this.witnesses = new Witnesses((name, given) => this.call(name, given));
    root.append(el("div", { class: "run-view" }, this.form, this.episodes, this.results, this.witnesses.element));
    this.connection.on("episodes", (played) => this.#played(played));
    this.form.append(el("p", { class: "soft" }, "loading …"));
  }

  async call(name, given) {
    try {
      return await this.connection.call(name, given);
    } catch (error) {
      this.studio.note(error.message, "error");
      return null;
    }
  }

  async show() {
    const choices = await this.call("run.choices");
    if (!choices) return;
    const before = this.choices;
    this.choices = choices;
    if (!before) {
      this.#build();
      this.witnesses.begin(choices);
      const played = await this.call("run.played");
      if (played?.wanted) this.#played(played);
      if (choices.results) this.#table(await this.call("run.results"));
    } else this.#nets();
  }

  #build() {
    const { tasks, controllers, disturbances, setup } = this.choices;
    const now = setup ?? { task: "Goalie", controller: controllers[0], seed: 0, world: 0, disturbance: null };
    const whole = (name, value, least = 0) => el("input", { type: "number", min: least, step: 1, required: true, value, "data-field": name });
    const field = (text, input) => el("label", {}, el("span", {}, text), input);
    this.fields = {
      task: choose(tasks, now.task, () => {}, { "data-field": "task" }),
      controller: choose([...controllers, ["", "nobody: all are scripted"]], now.controller, () => {}, { "data-field": "controller" }),
      disturbance: choose([["", "none"], ...Object.keys(disturbances)], now.disturbance ?? "", (name) => { this.about.textContent = disturbances[name] ?? ""; }, { "data-field": "disturbance" }),
      seed: whole("seed", now.seed),
      world: whole("world", now.world),
      count: whole("count", 50, 1),
    };
    this.about = el("p", { class: "soft" }, disturbances[now.disturbance] ?? "");
    this.nets = el("div", {});
    this.form.replaceChildren(el("h2", {}, "What is played"), field("task", this.fields.task), field("controller", this.fields.controller), field("disturbance", this.fields.disturbance), this.about,
      field("seed", this.fields.seed), field("world", this.fields.world), this.nets, el("button", { class: "main", "data-do": "watch" }, "watch this episode"),
      field("episodes", this.fields.count), el("button", { type: "button", "data-do": "episodes", onclick: () => this.play() }, "play them all"));
    const { last } = this.choices;
    if (last) {
      const text = `${last.task}, seed ${last.seed}${last.world ? `, world ${last.world}` : ""}, cycle ${last.cycle}${last.changes ? `, ${last.changes} changed by hand` : ""}`;
      this.form.append(el("p", { class: "soft" }, `The last time: ${text}.`), el("button", { type: "button", "data-do": "go-on", onclick: () => this.#open("run.go_on") }, "go on with it"));
    }
    this.#nets();
  }

  #nets() {
    const { nets, models, setup } = this.choices;
    const boxes = (kind, names, chosen) => names.map((name) => el("label", { class: "check" },
      el("input", { type: "checkbox", value: name, [`data-${kind}`]: name, checked: Boolean(chosen?.includes(name)) }), ` ${kind} ${name}`));
    const made = [...boxes("net", nets, setup?.changed), ...boxes("model", models, setup?.models)];
    this.nets.replaceChildren(...(made.length ? [el("span", { class: "soft" }, "as edited here, instead of as it ships:"), ...made] : []));
  }

  #given() {
    const { task, controller, disturbance, seed, world } = this.fields;
    return { task: task.value, controller: controller.value, disturbance: disturbance.value || null, seed: Number(seed.value), world: Number(world.value),
      nets: this.#checked("net"), models: this.#checked("model") };
  }

  #checked(kind) {
    return [...this.nets.querySelectorAll(`[data-${kind}]:checked`)].map((box) => box.value);
  }

  async #open(name, given = {}) {
    this.studio.note("making the run …");
    if (await this.call(name, given)) this.studio.go("watch");
  }

  watch(given = this.#given()) {
    return this.#open("run.watch", given);
  }

  /** The episodes begin; what is played comes as events. */
  async play() {
    if (this.form.reportValidity()) await this.call("run.episodes", { ...this.#given(), count: Number(this.fields.count.value) });
  }

  #played(played) {
    this.last = played;
    const { episodes, wanted, success, going, error } = played;
    this.progress.hidden = !going;
    this.stop.hidden = !going;
    this.progress.value = episodes.length / Math.max(1, wanted);
    const n = episodes.length;
    const rate = n ? `${success} of ${n} succeeded: ${percent(success / n)} [${percent(played.low)}, ${percent(played.high)}]` : "being made …";
    this.summary.textContent = error ?? (going ? `${rate}, ${n} of ${wanted} played` : rate);
    this.summary.classList.toggle("bad", Boolean(error));
    this.#rows();
  }

  #rows() {
    if (!this.last) return;
    const wanted = { all: () => true, failures: (e) => !e.success, successes: (e) => e.success }[this.filter.value];
    const { setup } = this.last;
    this.heads.hidden = !this.last.episodes.some(wanted);
    this.list.replaceChildren(...this.last.episodes.filter(wanted).slice(0, KEPT_ROWS).map((e) => el("tr", {}, el("td", { class: "mono" }, `${e.world}`), el("td", {}, `${e.success ? "✓" : "✗"} ${e.status.replaceAll("_", " ").toLowerCase()}`), el("td", { class: "mono" }, `${e.cycles}`),
      el("td", { class: "mono" }, e.struck >= 0 ? `${e.struck}` : ""), el("td", {}, el("button", { class: "link", "data-world": e.world, onclick: () => this.watch({ task: setup.task, controller: setup.controller, disturbance: setup.disturbance, seed: setup.seed, world: e.world, nets: setup.changed, models: setup.models }) }, "watch")))));
  }

  #table(table) {
    if (!table) return;
    this.results.hidden = false;
    const shown = el("tbody");
    const list = (row, only) => shown.replaceChildren(...row.episodes.filter((e) => only === "all" || !e.success).slice(0, KEPT_ROWS).map((e) => el("tr", {}, el("td", { class: "mono" }, `${e.world}`), el("td", {}, e.success ? "✓" : "✗"), el("td", { class: "mono" }, `${e.cycles}`),
      el("td", {}, el("button", { class: "link", "data-replay": e.world, onclick: () => this.#open("run.replay", { task: row.task, controller: row.controller, world: e.world }) }, "watch")))));
    this.results.replaceChildren(el("div", { class: "bar" }, el("h2", {}, "Results"), el("span", { class: "soft" }, table.folder)),
      el("div", { class: "tab-body" }, el("table", { class: "rows" }, el("thead", {}, el("tr", {}, ...["task", "controller", "success", "95 %", "cycles", "episodes"].map((h) => el("th", {}, h)))),
        el("tbody", {}, ...table.rows.map((row) => el("tr", {}, el("td", {}, row.task), el("td", {}, row.controller), el("td", { class: "mono" }, percent(row.rate)), el("td", { class: "mono" }, `${(100 * row.low).toFixed(0)} to ${percent(row.high)}`), el("td", { class: "mono" }, row.cycles.toFixed(1)),
          el("td", {}, el("button", { class: "link", "data-row": `${row.task} ${row.controller}`, onclick: () => list(row, "failures") }, `${row.episodes.length - row.success} failures`), " ", el("button", { class: "link", onclick: () => list(row, "all") }, `all ${row.episodes.length}`)))))),
        el("table", { class: "rows" }, shown)));
  }
}

export default {
  name: "run",
  title: "Run",
  create(root, studio) {
    const view = new RunView(root, studio);
    return { show: () => view.show(), keys: [["p", "play the episodes", () => view.play()], ["o", "watch this episode", () => view.form.requestSubmit()]] };
  },
};
