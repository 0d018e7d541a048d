// The field: players, ball, view cones, what is believed and true, trails; and things dragged to elsewhere while the run is paused.
// Metres in the server's frame (y downwards), angles in degrees from +x towards +y.

import { el, svg } from "../dom.js";

const LENGTH = 105;
const WIDTH = 68;
const APRON = 4;
const CONE = 22;
const TRAIL = 40;
const NUDGE = 0.5;
const ROOM = 7;
const NEAREST = 46;

export const nameOf = (number) => (number === 0 ? "ball" : number <= 11 ? `left_${number}` : `right_${number - 11}`);
export const numberOf = (name) => {
  const [side, unum] = name.split("_");
  return Number(unum) + (side === "left" ? 0 : 11);
};

/** Draws the world of one frame after another; `onmove(number, x, y)` is told of what was dragged. */
export class Field {
  constructor(onmove, label = "field") {
    this.onmove = onmove;
    this.layers = Object.fromEntries(["lines", "cones", "trail", "beliefs", "other", "players", "moved"].map((name) => [name, svg("g", { class: name })]));
    this.svg = svg("svg", { class: "field", role: "group", "aria-label": label }, ...Object.values(this.layers));
    this.element = el("div", { class: "field-panel" }, this.svg);
    this.made = new Map();
    this.cones = new Map();
    this.show = { near: true, cones: true, beliefs: true, trail: true };
    this.trail = [];
    this.movable = false;
    this.#listen();
  }

  begin(run) {
    const [x, y] = [Math.min(run.region[0], LENGTH / 2) + APRON, Math.min(run.region[1], WIDTH / 2) + APRON];
    this.whole = [-x, -y, x, y];
    this.box = null;
    this.layers.lines.replaceChildren(
      svg("rect", { class: "grass", x: -200, y: -200, width: 400, height: 400 }),
      svg("rect", { class: "line", x: -LENGTH / 2, y: -WIDTH / 2, width: LENGTH, height: WIDTH }),
      svg("line", { class: "line", x1: 0, x2: 0, y1: -WIDTH / 2, y2: WIDTH / 2 }),
      svg("circle", { class: "line", r: 9.15 }),
      ...[-1, 1].flatMap((s) => [
        svg("rect", { class: "line", x: s > 0 ? 36 : -52.5, y: -20.16, width: 16.5, height: 40.32 }),
        svg("rect", { class: "line", x: s > 0 ? 47 : -52.5, y: -9.16, width: 5.5, height: 18.32 }),
        svg("rect", { class: "goal", x: s > 0 ? 52.5 : -54.94, y: -run.goal_width / 2, width: 2.44, height: run.goal_width }),
      ]),
    );
    this.agents = new Set(run.agents.map(numberOf));
    this.made.clear();
    this.cones.clear();
    this.trail = [];
    for (const name of ["cones", "players", "moved", "beliefs", "other", "trail"]) this.layers[name].replaceChildren();
  }

  /** The part of the field that is shown: all of it, or where ball and players are; it moves only when one of them would leave it. */
  #frameIn(frame) {
    const [left, top, right, bottom] = this.whole;
    let box = this.whole;
    if (this.show.near) {
      const things = [frame, frame.other].filter(Boolean).flatMap(({ world }) => [world.ball, ...world.players.map((row) => row.slice(1))]);
      const inside = this.box && things.every(([x, y]) => x > this.box[0] + 2 && x < this.box[2] - 2 && y > this.box[1] + 2 && y < this.box[3] - 2);
      if (inside) return;
      const xs = things.map((t) => t[0]);
      const ys = things.map((t) => t[1]);
      const span = (low, high, least, from, to) => {
        const half = Math.min(Math.max((high - low) / 2 + ROOM, least / 2), (to - from) / 2);
        const middle = Math.max(from + half, Math.min(to - half, (low + high) / 2));
        return [middle - half, middle + half];
      };
      const [x, y] = [span(Math.min(...xs), Math.max(...xs), NEAREST, left, right), span(Math.min(...ys), Math.max(...ys), NEAREST * 0.65, top, bottom)];
      box = [x[0], y[0], x[1], y[1]];
    }
    this.#look(box);
  }

  #look(box) {
    this.box = box;
    this.svg.setAttribute("viewBox", `${box[0]} ${box[1]} ${box[2] - box[0]} ${box[3] - box[1]}`);
  }

  /** Draw a cycle; `differs` are the numbers of what is otherwise in the run beside, `as` a field that shows the same part of the pitch. */
  draw(frame, shown, { differs = [], as = null } = {}) {
    this.frame = frame;
    if (as) this.#look(as.box);
    else this.#frameIn(frame);
    const { players, ball } = frame.world;
    const there = new Set([0]);
    const watched = new Set(shown.map(numberOf));
    for (const [number, x, y, body, face, half] of players) {
      there.add(number);
      const one = this.#player(number);
      one.setAttribute("transform", `translate(${x} ${y})`);
      one.querySelector(".body").setAttribute("transform", `rotate(${body})`);
      one.classList.toggle("watched", watched.has(number));
      this.#label(one.querySelector(".mark"), this.#mark(frame, shown, number), x);
      this.#cone(number, this.show.cones && watched.has(number) ? [x, y, face, half] : null);
    }
    for (const [number, one] of this.made) one.style.display = there.has(number) ? "" : "none";
    this.#player(0).setAttribute("transform", `translate(${ball[0]} ${ball[1]})`);
    for (const [number, one] of this.made) this.#differ(one, number, differs.includes(number));
    this.#trace(frame);
    this.#believe(frame, shown);
    this.#compare(frame);
    this.#changed(frame);
  }

  /** A ring and a sign around what is otherwise in the run beside. */
  #differ(one, number, differs) {
    if (one.classList.contains("differs") === differs) return;
    one.classList.toggle("differs", differs);
    const name = nameOf(number).replace("_", " ");
    one.setAttribute("aria-label", differs ? `${name}, otherwise there` : name);
    if (differs) one.append(svg("circle", { class: "otherwise", r: 1.7 }), svg("text", { class: "unequal", x: -1.4, y: -1.3 }, "≠"));
    else for (const part of one.querySelectorAll(".otherwise, .unequal")) part.remove();
  }

  /** What is said of a player, to the left of him where it would be cut off at the right. */
  #label(text, words, x) {
    if (text.textContent !== words) text.textContent = words;
    const left = words && x + 1.3 + 0.85 * words.length > this.box[2];
    text.setAttribute("x", left ? -1.3 : 1.3);
    text.setAttribute("text-anchor", left ? "end" : "start");
  }

  #mark(frame, shown, number) {
    for (const agent of shown) {
      const text = frame.agents[agent]?.marks?.[number];
      if (text) return text;
    }
    return "";
  }

  #player(number) {
    let one = this.made.get(number);
    if (!one) {
      const shape =
        number === 0
          ? [svg("circle", { class: "ball", r: 0.65 })]
          : [
              number <= 11 ? svg("circle", { r: 1 }) : svg("rect", { x: -0.95, y: -0.95, width: 1.9, height: 1.9, rx: 0.3 }),
              svg("line", { class: "body", x1: 0, y1: 0, x2: 1.6, y2: 0 }),
              svg("text", { class: "number", y: 0.45 }, `${((number - 1) % 11) + 1}`),
            ];
      one = svg("g", { class: `thing ${number === 0 ? "" : number <= 11 ? "left" : "right"}`, role: "button" },
        svg("circle", { class: "grip", r: 1.8 }), ...shape, svg("text", { class: "mark", x: 1.3, y: -1 }));
      one.dataset.number = number;
      one.setAttribute("aria-label", nameOf(number).replace("_", " "));
      this.made.set(number, one);
      this.layers.players.append(one);
      this.#reach(one);
    }
    return one;
  }

  #cone(number, at) {
    let cone = this.cones.get(number);
    if (!cone) {
      if (!at) return;
      cone = svg("path", { class: "cone" });
      this.cones.set(number, cone);
      this.layers.cones.append(cone);
    }
    cone.style.display = at ? "" : "none";
    if (!at) return;
    const [x, y, face, half] = at;
    const edge = (angle) => [CONE * Math.cos((angle * Math.PI) / 180), CONE * Math.sin((angle * Math.PI) / 180)].map((v) => v.toFixed(2)).join(" ");
    cone.setAttribute("d", `M0 0 L${edge(face - half)} A${CONE} ${CONE} 0 ${half > 90 ? 1 : 0} 1 ${edge(face + half)} Z`);
    cone.setAttribute("transform", `translate(${x} ${y})`);
  }

  #trace(frame) {
    const last = this.trail.at(-1);
    if (last && (frame.cycle < last.cycle || frame.cycle > last.cycle + 30)) this.trail = this.trail.filter((p) => p.cycle < frame.cycle && p.cycle > frame.cycle - 30);
    if (!last || last.cycle !== frame.cycle) this.trail.push({ cycle: frame.cycle, world: frame.world });
    while (this.trail.length > TRAIL) this.trail.shift();
    if (!this.show.trail) return this.layers.trail.replaceChildren();
    const line = (points, name) => svg("polyline", { class: name, points: points.map((p) => `${p[0]},${p[1]}`).join(" ") });
    const lines = [line(this.trail.map((p) => p.world.ball), "of-ball")];
    for (const number of this.agents) {
      const points = this.trail.map((p) => p.world.players.find((row) => row[0] === number)).filter(Boolean).map((row) => [row[1], row[2]]);
      lines.push(line(points, "of-player"));
    }
    return this.layers.trail.replaceChildren(...lines);
  }

  #believe(frame, shown) {
    const parts = [];
    if (this.show.beliefs) {
      for (const agent of shown) {
        const inner = frame.agents[agent];
        for (const [x, y, w] of inner?.ball ?? []) {
          parts.push(svg("circle", { class: "belief-point", cx: x, cy: y, r: 0.42, "fill-opacity": (0.12 + 0.6 * w).toFixed(2) }));
        }
        for (const [number, x, y, sx, sy] of inner?.spots ?? []) {
          const true_ = number === 0 ? frame.world.ball : frame.world.players.find((row) => row[0] === number)?.slice(1);
          parts.push(svg("ellipse", { class: "spread", cx: x, cy: y, rx: Math.max(sx, 0.15), ry: Math.max(sy, 0.15) },
            svg("title", {}, `${agent} believes ${nameOf(number)} at ${x}, ${y} ± ${sx}, ${sy} m`)));
          if (true_) parts.push(svg("line", { class: "error", x1: x, y1: y, x2: true_[0], y2: true_[1] }));
        }
      }
    }
    this.layers.beliefs.replaceChildren(...parts);
  }

  #compare(frame) {
    const parts = [];
    if (frame.other) {
      const { players, ball } = frame.other.world;
      for (const [number, x, y] of [...players, [0, ...ball]]) {
        const here = number === 0 ? frame.world.ball : frame.world.players.find((row) => row[0] === number)?.slice(1);
        if (here && Math.hypot(here[0] - x, here[1] - y) > 1) parts.push(svg("line", { class: "to-ghost", x1: here[0], y1: here[1], x2: x, y2: y }));
      }
      for (const [number, x, y] of players) parts.push(svg("circle", { class: `ghost ${number <= 11 ? "left" : "right"}`, cx: x, cy: y, r: 1 }));
      parts.push(svg("circle", { class: "ghost ball", cx: ball[0], cy: ball[1], r: 0.65 }));
    }
    this.layers.other.replaceChildren(...parts);
  }

  #changed(frame) {
    const parts = [];
    for (const change of frame.changes ?? []) {
      const row = change.kind === "ball" ? frame.world.ball : change.kind === "player" ? frame.world.players.find((p) => p[0] === numberOf(change.whom))?.slice(1) : null;
      if (!row) continue;
      const [x, y] = change.values;
      parts.push(svg("line", { class: "drag", x1: row[0], y1: row[1], x2: x, y2: y }), svg("circle", { class: "drag", cx: x, cy: y, r: change.kind === "ball" ? 0.7 : 1.1 }));
    }
    this.layers.moved.replaceChildren(...parts);
  }

  // ------------------------------------------------------------------ by hand

  setMovable(movable) {
    this.movable = movable;
    this.svg.classList.toggle("movable", movable);
    for (const one of this.made.values()) this.#reach(one);
  }

  #reach(one) {
    if (this.movable) one.setAttribute("tabindex", 0);
    else one.removeAttribute("tabindex");
  }

  #at(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [point.x, point.y];
  }

  #where(number) {
    return number === 0 ? this.frame.world.ball : this.frame.world.players.find((row) => row[0] === number).slice(1);
  }

  #sketch(number, x, y) {
    const [fx, fy] = this.#where(number);
    this.layers.moved.replaceChildren(svg("line", { class: "drag", x1: fx, y1: fy, x2: x, y2: y }),
      svg("circle", { class: "drag", cx: x, cy: y, r: number === 0 ? 0.7 : 1.1 }));
  }

  #listen() {
    // a click moves no focus: arrows go on to step the run
    this.svg.addEventListener("mousedown", (event) => event.preventDefault());
    this.svg.addEventListener("pointerdown", (event) => {
      const thing = event.target.closest(".thing");
      if (!thing || !this.movable || event.button !== 0) return;
      const number = Number(thing.dataset.number);
      let moved = null;
      this.svg.setPointerCapture(event.pointerId);
      const move = (e) => {
        moved = this.#at(e);
        this.#sketch(number, ...moved);
      };
      const end = (e) => {
        this.svg.removeEventListener("pointermove", move);
        this.svg.removeEventListener("pointerup", end);
        this.svg.removeEventListener("pointercancel", end);
        if (moved && e.type === "pointerup") this.#drop(number, ...moved);
        else if (moved) this.#changed(this.frame);
      };
      this.svg.addEventListener("pointermove", move);
      this.svg.addEventListener("pointerup", end);
      this.svg.addEventListener("pointercancel", end);
    });
    this.svg.addEventListener("keydown", (event) => {
      const thing = event.target.closest(".thing");
      if (!thing || !this.movable) return;
      const number = Number(thing.dataset.number);
      const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
      if (step) {
        const from = this.nudged?.number === number ? this.nudged.at : this.#where(number).slice(0, 2);
        const by = event.shiftKey ? 10 * NUDGE : NUDGE;
        this.nudged = { number, at: [from[0] + by * step[0], from[1] + by * step[1]] };
        this.#sketch(number, ...this.nudged.at);
      } else if (event.key === "Enter" && this.nudged?.number === number) {
        this.#drop(number, ...this.nudged.at);
        this.nudged = null;
      } else if (event.key === "Escape") {
        this.nudged = null;
        this.#changed(this.frame);
      } else return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  #drop(number, x, y) {
    const clip = (v, most) => Math.round(Math.max(-most, Math.min(most, v)) * 100) / 100;
    this.onmove(number, clip(x, 57), clip(y, 38));
  }
}
