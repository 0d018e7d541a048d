import { el } from "../dom.js";

/** What is to be played. */
export default {
  name: "run",
  title: "Run",
  create(root) {
    root.append(el("div", { class: "empty" }, el("p", {}, "Start the studio with --demo to watch a demonstration.")));
    return {};
  },
};
