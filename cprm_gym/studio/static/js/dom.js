// Small words for making elements.

const SVG = "http://www.w3.org/2000/svg";

function fill(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value" || name === "checked" || name === "disabled" || name === "hidden") element[name] = value;
    else if (name.startsWith("aria-") && typeof value === "boolean") element.setAttribute(name, value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** `el("button", {class: "main", onclick}, "step")` */
export const el = (name, attributes = {}, ...children) => fill(document.createElement(name), attributes, children);

/** The same in SVG. */
export const svg = (name, attributes = {}, ...children) => fill(document.createElementNS(SVG, name), attributes, children);

/** Say, to those who see it and to those who hear it, whether a field holds what cannot be taken. */
export function invalid(field, wrong) {
  if (wrong) field.setAttribute("aria-invalid", true);
  else field.removeAttribute("aria-invalid");
}

/** Put these children into an element instead of what it holds; null is left out. */
export function refill(element, ...children) {
  element.replaceChildren(...children.flat().filter((child) => child !== null && child !== undefined));
}

/** A list of choices: `choose([["a", "first"], "b"], "a", onchange)`; onchange is given the value. */
export function choose(options, chosen, onchange, attributes = {}) {
  const made = options.map((option) => (Array.isArray(option) ? option : [option, option]));
  return el(
    "select",
    { ...attributes, onchange: (event) => onchange(event.target.value) },
    ...made.map(([value, text]) => el("option", { value, selected: value === chosen }, text)),
  );
}

/** Remember something in this browser, also after a reload. */
export const memory = {
  get(name, otherwise) {
    try {
      const found = localStorage.getItem(`studio.${name}`);
      return found === null ? otherwise : JSON.parse(found);
    } catch {
      return otherwise;
    }
  },
  set(name, value) {
    try {
      localStorage.setItem(`studio.${name}`, JSON.stringify(value));
    } catch {
      /* a browser that keeps nothing works, too */
    }
  },
};
