// Shapes of a net: places, transitions and arcs in the signs of the dissertation, as SVG elements.

const SVG = "http://www.w3.org/2000/svg";
export const RADIUS = 12;
export const BAR = 40;
export const THICK = 7;
const LONGEST = 44;
const SPOTS = {
  1: [[0, 0]],
  2: [[-4, 0], [4, 0]],
  3: [[-4, 3], [4, 3], [0, -4]],
  4: [[-4, -4], [4, -4], [-4, 4], [4, 4]],
};
const TRANSITIONS = new Set(["immediate", "timed", "output"]);
const REAL = new Set(["continuous", "input", "belief", "math"]);

export function element(name, attributes = {}, ...children) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

export const isTransition = (node) => TRANSITIONS.has(node.kind);
export const isReal = (node) => REAL.has(node.kind);

const shortened = (text) => (text.length <= LONGEST ? text : `${text.slice(0, LONGEST - 1)}…`);

export function shownNumber(value) {
  if (!Number.isFinite(value)) return "";
  const size = Math.abs(value);
  if (size >= 1e5) return value.toExponential(0);
  return size >= 100 ? value.toFixed(0) : `${Number(value.toPrecision(3))}`;
}

/** What has to be in the `<defs>` of an SVG that holds these shapes; `id` tells several of them on one page apart. */
export function definitions(id) {
  const head = (name, size, ...shapes) =>
    element("marker", { id: `${name}-${id}`, class: `head ${name}`, viewBox: "0 0 16 10", refX: 15, refY: 5, markerWidth: size,
      markerHeight: size * 0.625, markerUnits: "userSpaceOnUse", orient: "auto" }, ...shapes);
  const tip = (x) => element("path", { d: `M${x} 5 L${x - 8} 1.2 L${x - 8} 8.8 z` });
  const hash = element("pattern", { id: `hash-${id}`, width: 5, height: 5, patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" },
    element("rect", { width: 5, height: 5, class: "paper" }), element("rect", { width: 1.4, height: 5, class: "stripe" }));
  return element("defs", {}, hash,
    head("arc", 14, tip(15)), head("test", 14, tip(15)), head("set", 14, tip(15), tip(9)), head("operand", 9, tip(15)),
    head("inhibitor", 14, element("circle", { cx: 11, cy: 5, r: 4 })));
}

/** The group of a place or transition; its state (tokens, clock, problem) is set by `setTokens` and the canvas. */
export function nodeShape(node, id) {
  const group = element("g", { class: `node ${node.kind}${node.timed ? " waits" : ""}${node.port ? ` ${node.port}` : ""}`,
    transform: `translate(${node.x} ${node.y})`, role: "img" });
  group.dataset.key = node.key;
  group.append(element("title", {}, [node.label, node.detail].filter(Boolean).join("  ")));
  const half = isTransition(node) ? BAR / 2 : RADIUS;
  if (isTransition(node)) {
    group.append(element("rect", { class: "halo", x: -BAR / 2 - 5, y: -THICK / 2 - 5, width: BAR + 10, height: THICK + 10, rx: 4 }));
    const fill = node.kind === "output" ? { style: `fill: url(#hash-${id})` } : {};
    group.append(element("rect", { class: "shape", x: -BAR / 2, y: -THICK / 2, width: BAR, height: THICK, ...fill }));
    if (node.timed) group.append(element("rect", { class: "clock", x: -BAR / 2, y: -THICK / 2, width: 0, height: THICK }));
    group.append(element("rect", { class: "hit", x: -BAR / 2 - 4, y: -10, width: BAR + 8, height: 20 }));
  } else {
    group.append(element("circle", { class: "halo", r: RADIUS + 5 }));
    const fill = node.kind === "input" ? { style: `fill: url(#hash-${id})` } : {};
    group.append(element("circle", { class: "shape", r: RADIUS, ...fill }));
    if (node.kind === "belief") group.append(element("circle", { class: "ring", r: RADIUS - 3 }));
    if (node.kind === "object") group.append(element("path", { class: "ring", d: "M-5 0 l5 -6 l5 6 l-5 6 z" }));
    group.append(element("g", { class: "inside" }));
  }
  if (node.port) group.append(element("path", { class: "side", d: node.port === "entry" ? "M-4 -19 h8 l-4 5 z" : "M-4 14 h8 l-4 5 z" }));
  const name = element("text", { class: "label", x: half + 5, y: node.detail ? -1 : 4 }, node.label);
  group.append(name);
  if (node.detail) group.append(element("text", { class: "detail", x: half + 5, y: 10 }, shortened(node.detail)));
  if (!isTransition(node)) setTokens(group, node, isReal(node) ? NaN : node.tokens);
  return group;
}

/** Show tokens as dots or a number, the value of a real-valued place as a number. */
export function setTokens(group, node, value) {
  const inside = group.querySelector(".inside");
  if (!inside) return;
  inside.replaceChildren();
  const marked = !isReal(node) && value > 0;
  group.classList.toggle("marked", marked);
  if (isReal(node)) {
    const text = shownNumber(value);
    if (text) inside.append(element("text", { class: "value", y: 3.5 }, text));
    else if (node.kind === "math") inside.append(element("text", { class: "sign", y: 4 }, "f"));
  } else if (node.kind === "object") {
    if (marked) inside.append(element("path", { class: "token", d: "M-4 0 l4 -5 l4 5 l-4 5 z" }));
  } else if (SPOTS[value]) {
    for (const [x, y] of SPOTS[value]) inside.append(element("circle", { class: "token", cx: x, cy: y, r: 2.8 }));
  } else if (value > 0) {
    inside.append(element("text", { class: "value count", y: 3.5 }, shownNumber(value)));
  }
}

/** How much of its delay a timed transition has waited, 0 to 1. */
export function setClock(group, share) {
  const clock = group.querySelector(".clock");
  if (clock) clock.setAttribute("width", `${BAR * Math.max(0, Math.min(1, share))}`);
}

export function boxShape(box) {
  const group = element("g", { class: `box${box.folded ? " folded" : ""}`, transform: `translate(${box.x} ${box.y})` });
  group.dataset.key = box.key;
  group.append(element("rect", { class: "shape", width: box.width, height: box.height, rx: 8 }));
  const title = element("g", { class: "heading" }, element("rect", { class: "hit", width: box.width, height: 22, rx: 8 }),
    element("text", { class: "fold", x: 8, y: 15 }, box.folded ? "▸" : "▾"), element("text", { class: "label", x: 20, y: 15 }, box.title));
  group.append(title);
  return group;
}

/** The line of an arc through the points of the automatic layout: smooth, upright at every point. */
export function curve(path) {
  const parts = [`M${path[0][0]} ${path[0][1]}`];
  for (let i = 1; i < path.length; i += 1) {
    const [x0, y0] = path[i - 1];
    const [x1, y1] = path[i];
    const middle = (y0 + y1) / 2;
    parts.push(Math.abs(x0 - x1) < 0.05 ? `L${x1} ${y1}` : `C${x0} ${middle} ${x1} ${middle} ${x1} ${y1}`);
  }
  return parts.join(" ");
}

/** Where a line from the middle of a node towards a point leaves its shape. */
function border(node, [x, y]) {
  const dx = x - node.x;
  const dy = y - node.y;
  const length = Math.hypot(dx, dy) || 1;
  if (!isTransition(node)) return [node.x + (dx / length) * RADIUS, node.y + (dy / length) * RADIUS];
  const scale = Math.min(BAR / 2 / (Math.abs(dx) || 1e-9), THICK / 2 / (Math.abs(dy) || 1e-9));
  return [node.x + dx * scale, node.y + dy * scale];
}

/** A straight arc between two nodes, bent by `bend` to keep it apart from others between the same two. */
export function straight(source, target, bend = 0) {
  const dx = target.x - source.x;
  const dy = target.y - source.y;
  const length = Math.hypot(dx, dy) || 1;
  const control = [(source.x + target.x) / 2 - (dy / length) * bend, (source.y + target.y) / 2 + (dx / length) * bend];
  const start = border(source, bend ? control : [target.x, target.y]);
  const end = border(target, bend ? control : [source.x, source.y]);
  const r = (p) => p.map((v) => Math.round(v * 10) / 10).join(" ");
  const line = bend ? `Q${r(control)} ${r(end)}` : `L${r(end)}`;
  return { d: `M${r(start)} ${line}`, middle: bend ? [(start[0] + 2 * control[0] + end[0]) / 4, (start[1] + 2 * control[1] + end[1]) / 4] : [(start[0] + end[0]) / 2, (start[1] + end[1]) / 2] };
}

/** A point on an automatic path at which its label can stand: the middle of its longest segment. */
export function labelPoint(path) {
  let best = [path[0], path[0]];
  for (let i = 1; i < path.length; i += 1) {
    const longer = Math.hypot(path[i][0] - path[i - 1][0], path[i][1] - path[i - 1][1]);
    if (longer > Math.hypot(best[1][0] - best[0][0], best[1][1] - best[0][1])) best = [path[i - 1], path[i]];
  }
  return [(best[0][0] + best[1][0]) / 2, (best[0][1] + best[1][1]) / 2];
}
