import { el } from "../dom.js";

/** What is open, by name. */
export default {
  name: "models",
  title: "Models",
  create(root, studio) {
    root.append(el("div", { class: "empty" }, el("p", {}, studio.about.models.join(", ") || "Nothing is open here.")));
    return {};
  },
};
