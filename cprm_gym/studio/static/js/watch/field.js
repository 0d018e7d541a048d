// The field: players, ball, view cones, what is believed, trails. Metres in the server's frame (y downwards).

import { el, svg } from "../dom.js";

const LENGTH = 105;
const WIDTH = 68;
const APRON = 3;

/** Draws the world of one frame after another. */
export class Field {
  constructor() {
    this.lines = svg("g");
    this.beliefs = svg("g");
    this.players = svg("g");
    this.ball = svg("circle", { class: "ball", r: 0.6 });
    this.svg = svg("svg", { class: "field", role: "img", "aria-label": "field" }, this.lines, this.beliefs, this.players, this.ball);
    this.element = el("div", { class: "panel field-panel" }, this.svg);
    this.made = new Map();
  }

  begin(run) {
    const [x, y] = [Math.min(run.region[0], LENGTH / 2) + APRON, Math.min(run.region[1], WIDTH / 2) + APRON];
    this.svg.setAttribute("viewBox", `${-x} ${-y} ${2 * x} ${2 * y}`);
    this.lines.replaceChildren(
      svg("rect", { class: "grass", x: -60, y: -40, width: 120, height: 80 }),
      svg("rect", { class: "line", x: -LENGTH / 2, y: -WIDTH / 2, width: LENGTH, height: WIDTH }),
      svg("line", { class: "line", x1: 0, x2: 0, y1: -WIDTH / 2, y2: WIDTH / 2 }),
      svg("circle", { class: "line", r: 9.15 }),
      ...[-1, 1].flatMap((s) => [
        svg("rect", { class: "line", x: s > 0 ? 36 : -52.5, y: -20.16, width: 16.5, height: 40.32 }),
        svg("rect", { class: "line", x: s > 0 ? 47 : -52.5, y: -9.16, width: 5.5, height: 18.32 }),
        svg("rect", { class: "goal", x: s > 0 ? 52.5 : -54.94, y: -run.goal_width / 2, width: 2.44, height: run.goal_width }),
      ]),
    );
    this.made.clear();
    this.players.replaceChildren();
  }

  draw(frame) {
    const there = new Set();
    for (const [number, x, y, body] of frame.world.players) {
      there.add(number);
      let one = this.made.get(number);
      if (!one) {
        one = svg(
          "g",
          { class: `player ${number <= 11 ? "left" : "right"}` },
          svg("circle", { r: 1 }),
          svg("line", { x1: 0, y1: 0, x2: 1.2, y2: 0 }),
        );
        this.made.set(number, one);
        this.players.append(one);
      }
      one.setAttribute("transform", `translate(${x} ${y})`);
      one.lastChild.setAttribute("transform", `rotate(${body})`);
    }
    for (const [number, one] of this.made) one.style.display = there.has(number) ? "" : "none";
    const [x, y] = frame.world.ball;
    this.ball.setAttribute("cx", x);
    this.ball.setAttribute("cy", y);
  }
}
