import { el } from "../dom.js";
import { Field } from "../watch/field.js";

/** The field, the net, the beliefs, the commands of a run, live and back. */
export default {
  name: "watch",
  title: "Watch",
  create(root, studio) {
    const { connection, note } = studio;
    const field = new Field();
    const play = el("button", { class: "main", "data-do": "play", onclick: toggle }, "play");
    const step = el("button", { "data-do": "step", onclick: () => call("watch.step") }, "step");
    const cycle = el("output", { class: "mono", "data-show": "cycle" }, "");
    root.append(el("div", { class: "bar" }, play, step, cycle), field.element);
    let playing = false;

    async function call(name, given) {
      try {
        return await connection.call(name, given);
      } catch (error) {
        note(error.message, "error");
        return null;
      }
    }
    function toggle() {
      return call(playing ? "watch.pause" : "watch.play");
    }
    function draw(frame) {
      cycle.textContent = `cycle ${frame.cycle} ${frame.status}`;
      field.draw(frame);
    }
    function said(state) {
      playing = state.playing;
      play.textContent = playing ? "pause" : "play";
    }
    connection.on("frame", ({ frame }) => draw(frame));
    connection.on("state", ({ state }) => said(state));
    async function show() {
      const opened = await call("watch.open");
      if (!opened?.run) return;
      field.begin(opened.run);
      said(opened.state);
      draw(opened.frame);
    }
    return { show, keys: [[" ", "play or pause", toggle], [".", "one cycle on", () => call("watch.step")]] };
  },
};
