// A CPD as a table whose cells can be changed, and as a picture.

import { el } from "../dom.js";

/** Show the CPD of {kind, owner, label, part, cpd, path} in an element. */
export class CpdTable {
  constructor(root, desk) {
    Object.assign(this, { root, desk });
    this.number = 0;
  }

  async show(what) {
    const mine = (this.number += 1);
    this.what = what;
    if (!what) {
      this.root.replaceChildren();
      return;
    }
    try {
      const { kind, owner, label, part } = what;
      const table = await this.desk.call("model.table", { id: this.desk.current.id, kind, owner, label, part });
      if (mine === this.number) this.draw(table);
    } catch (error) {
      if (mine === this.number) this.root.replaceChildren(el("div", { class: "empty" }, el("p", { class: "bad" }, error.message), el("p", {}, "The table is shown when the model is well defined.")));
    }
  }

  draw(table) {
    const { what } = this;
    const { parents, states, rows, left, note } = table;
    const editable = ["Uniform", "Prior", "Table", "Dense"].includes(what.cpd.is) && !note;
    const head = el("tr", {}, ...parents.map((p) => el("th", { scope: "col", class: "soft" }, p.name)), ...states.map((s) => el("th", { scope: "col" }, s)));
    const cell = (row, r, k) => {
      const share = row[1][k];
      const bar = el("div", { class: "share", style: `width:${(share * 100).toFixed(1)}%` });
      if (!editable) return el("td", { class: "cell", title: String(share) }, bar, el("span", {}, short(share)));
      const input = el("input", { value: short(share), inputmode: "decimal", "aria-label": `${[...row[0], states[k]].join(" ")}`, onchange: () => this.change(table, r, k, Number(input.value)) });
      return el("td", { class: "cell" }, bar, input);
    };
    const body = rows.slice(0, 200).map((row, r) => el("tr", {}, ...row[0].map((s) => el("th", { scope: "row", class: "soft" }, s)), ...states.map((_, k) => cell(row, r, k))));
    const rest = left + Math.max(0, rows.length - 200);
    this.root.replaceChildren(el("div", { class: "bar" }, el("h3", {}, `P(${what.owner}.${what.label}${parents.length ? ` | ${parents.map((p) => p.name).join(", ")}` : ""})${what.part === "initial" ? " in its first slice" : ""}`), el("span", { class: "soft" }, [note, editable ? "a changed cell rescales the others of its row" : ""].filter(Boolean).join("; "))),
      this.picture(table), el("div", { class: "scroll" }, el("table", { class: "cpd" }, el("thead", {}, head), el("tbody", {}, ...body)), rest > 0 ? el("p", { class: "soft" }, `and ${rest} more rows`) : null));
  }

  /** Change one chance; the others of the row keep their proportion. */
  change(table, r, k, value) {
    const { what } = this;
    if (!(value >= 0 && value <= 1)) {
      this.desk.studio.note("a chance is 0 to 1", "error");
      this.draw(table);
      return;
    }
    const [states, before] = table.rows[r];
    const others = before.reduce((sum, p, i) => sum + (i === k ? 0 : p), 0);
    const row = before.map((p, i) => (i === k ? value : others > 0 ? (p / others) * (1 - value) : (1 - value) / (before.length - 1)));
    const exact = row.map((p) => Math.round(p * 1e12) / 1e12);
    exact[row.indexOf(Math.max(...row))] += 1 - exact.reduce((a, b) => a + b, 0);
    let op;
    if (what.cpd.is === "Dense") op = { op: "set", path: [...what.path, "values", ...index(table, r)], value: exact };
    else if (!table.parents.length) op = { op: "set", path: what.path, value: { is: "Prior", p: exact } };
    else {
      const written = what.cpd.is === "Table" ? what.cpd.rows : [[table.parents.map(() => "*"), what.cpd.p ?? before]];
      const at = written.findIndex(([key]) => [key].flat().join("\t") === states.join("\t"));
      const rows = at >= 0 ? written.map((one, i) => (i === at ? [states, exact] : one)) : [[states, exact], ...written];
      op = { op: "set", path: what.path, value: { is: "Table", rows } };
    }
    this.desk.try(op, "model");
  }

  /** How the child's states share the chance, row by row: dark is likely. */
  picture({ parents, states, values, rows }) {
    if (states.length < 2 || !rows.length) return "";
    const [n, m] = [Math.min(rows.length, 240), states.length];
    const canvas = el("canvas", { width: n, height: m, class: "heat", role: "img", "aria-label": "the table as a picture: dark is likely" });
    const context = canvas.getContext("2d");
    const image = context.createImageData(n, m);
    const dark = document.documentElement.dataset.theme === "dark";
    const most = Math.max(...rows.slice(0, n).map((row) => Math.max(...row[1]))) || 1;
    for (let x = 0; x < n; x += 1) {
      for (let y = 0; y < m; y += 1) {
        const p = Math.sqrt(rows[x][1][m - 1 - y] / most);
        const colour = dark ? [28 + 70 * p, 34 + 146 * p, 41 + 192 * p] : [255 - 255 * p, 255 - 141 * p, 255 - 77 * p];
        image.data.set([...colour, 255], 4 * (y * n + x));
      }
    }
    context.putImageData(image, 0, 0);
    const end = (v) => (typeof v === "number" ? String(v) : v);
    const across = parents.length ? `each column a row of the table, ordered by ${parents.map((p) => p.name).join(", then ")}` : "";
    return el("figure", { class: "picture" }, el("div", { class: "axis" }, el("span", {}, end(values.at(-1))), el("span", {}, end(values[0]))), canvas, el("figcaption", { class: "soft" }, across));
  }
}

function index(table, r) {
  const sizes = table.parents.map((p) => p.states.length);
  const found = [];
  for (let k = sizes.length - 1, rest = r; k >= 0; k -= 1) {
    found.unshift(rest % sizes[k]);
    rest = Math.floor(rest / sizes[k]);
  }
  return found;
}

const short = (p) => (p === 0 || p === 1 ? String(p) : p >= 0.001 ? String(Number(p.toPrecision(4))) : p.toExponential(1));
