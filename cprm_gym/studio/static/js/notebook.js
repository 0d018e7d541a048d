// The studio's views in a page of their own, for notebooks: the data stand in the page, there is no server.

import { NetCanvas } from "./netcanvas.js";
import { element } from "./netshapes.js";

const make = (name, attributes = {}, ...children) => {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
};

document.documentElement.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";

/** A slider over steps; calls `show(step)`. */
function slider(steps, show) {
  const said = make("output", {}, "");
  const input = make("input", { type: "range", min: 0, max: steps.length - 1, value: steps.length - 1, "aria-label": "cycle", oninput: () => move() });
  let timer = null;
  const play = make("button", { onclick: () => {
    if (timer) stop();
    else {
      if (Number(input.value) === steps.length - 1) input.value = 0;
      play.textContent = "pause";
      timer = setInterval(() => (Number(input.value) < steps.length - 1 ? ((input.value = Number(input.value) + 1), move()) : stop()), 100);
    }
  } }, "play");
  const stop = () => {
    clearInterval(timer);
    timer = null;
    play.textContent = "play";
  };
  const move = () => {
    const step = steps[Number(input.value)];
    said.textContent = `cycle ${step.cycle}`;
    show(step);
  };
  setTimeout(move);
  return make("div", { class: "bar" }, play, input, said);
}

/** A net, its marking over time, and what is told of a decision. */
export function showNet({ plans, steps }) {
  const place = make("div", { class: "place" });
  const told = make("div", { class: "told" });
  const bar = make("div", { class: "bars" });
  document.body.append(bar, make("div", { class: "both" }, ...(plans.length ? [place] : []), ...(steps.some((step) => step.told) ? [told] : [])));
  const canvas = plans.length ? new NetCanvas(place) : null;
  let now = null;
  const colour = (step) => {
    now = step;
    if (canvas) {
      const rest = step.whole ? Object.fromEntries(canvas.plan.nodes.filter((node) => !["immediate", "timed", "output"].includes(node.kind)).map((node) => [node.key, 0])) : {};
      canvas.update({ marking: { ...rest, ...step.marking }, fired: step.fired ?? [], enabled: step.enabled ?? [] });
    }
    if (step.told) tell(told, step);
  };
  if (canvas) {
    canvas.show(plans[0]);
    let which = 0;
    const fit = make("button", { onclick: () => canvas.fit() }, "fit");
    const unfold = make("button", { onclick: () => {
      which = 1 - which;
      unfold.textContent = which ? "fold" : "unfold";
      canvas.show(plans[which]);
      if (now) colour(now);
    } }, "unfold");
    bar.append(make("div", { class: "bar" }, fit, ...(plans.length > 1 ? [unfold] : [])));
  }
  if (steps.length > 1) bar.append(slider(steps, colour));
  else if (steps.length) colour(steps[0]);
}

function tell(root, step) {
  const list = (title, lines) => [make("h3", {}, title), ...(lines.length ? lines.map((line) => make("div", {}, line)) : [make("div", { class: "soft" }, "nothing")])];
  const values = (of) => Object.entries(of).map(([name, value]) => `${name} = ${value ?? "unknown"}`);
  const { commands, relations, beliefs, evidence } = step.told;
  root.replaceChildren(...list("sent", Object.entries(commands).map(([name, params]) => `${name}(${values(params).join(", ")})`)), ...list("fired", step.fired), ...list("enabled, not fired", step.enabled), ...list("relations", relations), ...list("beliefs", values(beliefs)), ...list("observed", values(evidence)));
}

/** A picture that is there already. */
export function showPicture({ svg }) {
  const place = make("div", { class: "still" });
  place.innerHTML = svg;
  document.body.append(place);
}

/** A match: players and ball over time. */
export function showMatch({ steps, pitch }) {
  const [x, y] = [pitch.x + 3, pitch.y + 3];
  const rect = (left, top, width, height) => element("rect", { class: "mark", x: left, y: top, width, height });
  const moving = element("g");
  const [long, wide] = pitch.area;
  const svg = element("svg", { class: "match", viewBox: `${-x} ${-y} ${2 * x} ${2 * y}`, role: "img", "aria-label": "the field" }, element("rect", { class: "grass", x: -x, y: -y, width: 2 * x, height: 2 * y }), rect(-pitch.x, -pitch.y, 2 * pitch.x, 2 * pitch.y), rect(-pitch.x, -wide / 2, long, wide), rect(pitch.x - long, -wide / 2, long, wide), rect(-pitch.x - 1.5, -pitch.goal / 2, 1.5, pitch.goal), rect(pitch.x, -pitch.goal / 2, 1.5, pitch.goal), element("path", { class: "mark", d: `M0 ${-pitch.y} V${pitch.y}` }), moving);
  const score = make("span", { class: "soft" });
  const show = (step) => {
    const trail = steps.slice(Math.max(0, steps.indexOf(step) - 40), steps.indexOf(step) + 1).map((one) => one.ball.join(",")).join(" ");
    moving.replaceChildren(element("polyline", { class: "trail", points: trail }), ...step.players.map(([side, unum, px, py, body]) => {
      const group = element("g", { class: side === 1 ? "left" : "right", transform: `translate(${px} ${py})` }, element("circle", { r: 1.3 }), element("path", { d: "M0 0 H1.9", transform: `rotate(${body})` }));
      const text = element("text", { y: 0.55 });
      text.textContent = unum;
      group.append(text);
      return group;
    }), element("circle", { class: "ball", cx: step.ball[0], cy: step.ball[1], r: 0.7 }));
    score.textContent = `${step.mode.replaceAll("_", " ")}  ${step.score.join(":")}`;
  };
  const bar = make("div", { class: "bars" }, ...(steps.length > 1 ? [slider(steps, show)] : []), score);
  document.body.append(bar, make("div", { class: "place" }, svg));
  if (steps.length === 1) show(steps[0]);
}
