import { el } from "../dom.js";

/** What is open, by name. */
export default {
  name: "nets",
  title: "Nets",
  create(root, studio) {
    root.append(el("div", { class: "empty" }, el("p", {}, studio.about.nets.join(", ") || "Nothing is open here.")));
    return {};
  },
};
