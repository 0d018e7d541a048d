// The page's shell: tabs, theme, keys, notes. Each view is a module of views/ that gives {name, title, create}.
//
// create(root, studio) fills the element and returns {show?(), hide?(), keys?: [[key, what it does, function]]}. `studio` is
//   connection        net.js: call, on
//   about             what the server was started with (call `studio.about`)
//   note(text, kind)  says something at the foot of the page; kind "error" or "good"; gives the line, to be removed earlier
//   go(view, what)    changes to another view, which is given `what` in show(what)

import { el, memory } from "./dom.js";
import { Connection } from "./net.js";
import models from "./views/models.js";
import nets from "./views/nets.js";
import run from "./views/run.js";
import watch from "./views/watch.js";

const VIEWS = [watch, nets, models, run];
const token = new URLSearchParams(location.search).get("token") ?? "";
const studio = { connection: new Connection(token), about: null, note, go };
const made = new Map();
let current = null;

function note(text, kind = "good") {
  const line = el("div", { class: `note ${kind}` }, text, el("button", { "aria-label": "close", onclick: () => line.remove() }, "×"));
  const notes = document.getElementById("notes");
  for (const other of [...notes.children]) if (other.textContent === line.textContent) other.remove(); // said again, it stands once
  notes.append(line);
  while (notes.children.length > 3) notes.firstChild.remove();
  if (kind !== "error") setTimeout(() => line.remove(), 4000);
  return line;
}

function go(name, what) {
  const view = VIEWS.find((one) => one.name === name) ?? VIEWS[0];
  if (current && current.view !== view) current.hide?.();
  for (const tab of document.querySelectorAll("#tabs button")) {
    const chosen = tab.dataset.view === view.name;
    tab.setAttribute("aria-selected", chosen);
    tab.tabIndex = chosen ? 0 : -1;
  }
  for (const part of document.querySelectorAll("#views > section")) part.hidden = part.dataset.view !== view.name;
  if (!made.has(view.name)) {
    const root = document.querySelector(`#views > section[data-view=${view.name}]`);
    made.set(view.name, Object.assign(view.create(root, studio), { view }));
  }
  current = made.get(view.name);
  memory.set("view", view.name);
  history.replaceState(null, "", `${location.pathname}${location.search}#${view.name}`);
  current.show?.(what);
}

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  memory.set("dark", dark);
  document.dispatchEvent(new Event("theme"));
}

const isDark = () => document.documentElement.dataset.theme === "dark";
const SHELL_KEYS = [
  ...VIEWS.map((view, i) => [`Alt+${i + 1}`, view.title, () => go(view.name)]),
  ["Shift+L", "light or dark", () => theme(!isDark())],
  ["?", "these keys", showKeys],
];

function showKeys() {
  const rows = (keys) => keys.map(([key, what]) => el("tr", {}, el("th", {}, el("kbd", {}, key === " " ? "Space" : key)), el("td", {}, what)));
  const dialog = document.getElementById("keys");
  dialog.replaceChildren(
    el("h2", {}, "Keys"),
    el("table", {}, ...rows(SHELL_KEYS), ...rows(current?.keys ?? [])),
    el("form", { method: "dialog" }, el("button", {}, "close")),
  );
  dialog.showModal();
}

/** The name of a key with its modifiers: `Shift+L`, `Alt+1`, `ArrowLeft`, `?`. */
export function keyName(event) {
  const name = event.key.length === 1 && event.key !== "?" ? event.key : event.key;
  const shifted = event.shiftKey && (event.key.length > 1 || /^[A-Z]$/.test(event.key));
  return [event.ctrlKey || event.metaKey ? "Ctrl+" : "", event.altKey ? "Alt+" : "", shifted ? "Shift+" : "", name].join("");
}

/** Whether a key belongs to the field that has the focus: lists take all but left and right, sliders what moves them, boxes the space. */
function taken(event) {
  const field = event.target.closest("input, textarea, select, [contenteditable]");
  if (!field || event.altKey || event.ctrlKey || event.metaKey) return false;
  if (field.matches("select")) return !["ArrowLeft", "ArrowRight"].includes(event.key);
  if (field.matches("[type=range]")) return /^(Arrow|Home|End|Page)/.test(event.key);
  return field.matches("[type=checkbox]") ? event.key === " " : true;
}

// a click on a button takes no focus, so that the next key is the view's
addEventListener("mousedown", (event) => {
  if (!event.target.closest("button") || event.target.closest("dialog")) return;
  event.preventDefault();
  document.activeElement?.blur?.();
});

// what is being typed when the page is reloaded or closed is entered first
addEventListener("beforeunload", () => document.activeElement?.blur?.());

addEventListener("keydown", (event) => {
  if (document.querySelector("dialog[open]") || taken(event)) return; // an open dialog has the keys, Escape too
  const pressed = keyName(event);
  if (pressed === " " && event.target.closest("button, summary, [role=button]")) return;
  const found = [...(current?.keys ?? []), ...SHELL_KEYS].find(([key]) => key === pressed);
  if (!found) return;
  event.preventDefault();
  found[2](event);
});

function build() {
  const tabs = document.getElementById("tabs");
  const views = document.getElementById("views");
  for (const view of VIEWS) {
    tabs.append(el("button", { role: "tab", "data-view": view.name, onclick: () => go(view.name) }, view.title));
    views.append(el("section", { "data-view": view.name, "aria-label": view.title, hidden: true }));
  }
  tabs.addEventListener("keydown", (event) => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    event.stopPropagation();
    const at = VIEWS.findIndex((view) => view === current.view);
    go(VIEWS[(at + step + VIEWS.length) % VIEWS.length].name);
    tabs.querySelector("[aria-selected=true]").focus();
  });
  document.getElementById("theme").onclick = () => theme(!isDark());
  document.getElementById("help").onclick = showKeys;
}

async function begin() {
  try {
    studio.about = await studio.connection.call("studio.about");
  } catch (error) {
    return note(error.message, "error");
  }
  document.getElementById("what").textContent = studio.about.title;
  document.title = `${studio.about.title}: studio`;
  if (!current) go(location.hash.slice(1) || studio.about.view);
  return undefined;
}

theme(memory.get("dark", matchMedia("(prefers-color-scheme: dark)").matches));
build();
studio.connection.on("connection", ({ state }) => {
  const link = document.getElementById("link");
  link.textContent = { open: "connected", lost: "no connection: the studio has ended; a new start prints a new address", connecting: "connecting" }[state];
  link.className = state;
  if (state === "open") begin();
});
