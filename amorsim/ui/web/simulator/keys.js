// The keys of the window, except those that drive.

import { takesKeys } from "./drive.js";
import { showKeys } from "./key_list.js";

/** Who uses the mouse wants the keys for the simulator: what was clicked does not keep them. */
function freeKeysAfterMouse() {
  let byMouse = false;
  const free = (/** @type {Event} */ event, /** @type {string} */ kinds) => {
    const one = event.target instanceof HTMLElement && /** @type {HTMLElement | null} */ (event.target.closest(kinds));
    if (byMouse && one && !one.closest("dialog")) setTimeout(() => one.blur());
  };
  window.addEventListener("pointerdown", () => (byMouse = true), true);
  window.addEventListener("keydown", () => (byMouse = false), true);
  window.addEventListener("pointerup", (event) => free(event, "button, input[type=range]"));
  window.addEventListener("change", (event) => free(event, "select"));
}

/** @param {import("./simulator.js").Simulator} simulator */
export function listenToKeys(simulator) {
  freeKeysAfterMouse();
  const { stage, timebar, driving } = simulator;
  const flip = (/** @type {string} */ name) => stage.setOption(name, !stage.options[name]);
  const pan = (/** @type {number} */ right, /** @type {number} */ down) => {
    stage.setOption("follow", false);
    stage.robot.pan(right, down);
    stage.control.pointed = null;
  };
  /** @type {Record<string, (() => void) | undefined>} */
  const plain = {
    " ": () => timebar.toggle(),
    ".": () => timebar.doStep(),
    ",": () => timebar.doStepBack(),
    R: () => timebar.doReset(),
    m: () => driving.toggle(),
    x: () => driving.isByHand && driving.stop(),
    o: () => flip("overlay"),
    f: () => flip("follow"),
    t: () => flip("trails"),
    g: () => flip("grid"),
    0: () => stage.fit(),
    "+": () => stage.camera.zoom(1.3),
    "=": () => stage.camera.zoom(1.3),
    "-": () => stage.camera.zoom(1 / 1.3),
    n: () => simulator.nextRobot(1),
    p: () => simulator.nextRobot(-1),
    b: () => simulator.toggleFleet(),
    l: () => simulator.toggleTheme(),
    c: () => simulator.setLecture(!simulator.isLecture),
    "?": () => showKeys(timebar.isRecorded),
    Escape: () => stage.selection.clear(),
  };
  /** @type {Record<string, (() => void) | undefined>} */
  const shifted = {
    ArrowLeft: () => pan(60, 0),
    ArrowRight: () => pan(-60, 0),
    ArrowUp: () => pan(0, 60),
    ArrowDown: () => pan(0, -60),
  };
  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || document.querySelector("dialog[open]")) return;
    const target = /** @type {HTMLInputElement} */ (event.target);
    if (takesKeys(target)) {
      // What is typed the form looks after; a slider or a list gives the keyboard back itself.
      const isDone = ["Enter", "Escape"].includes(event.key) && target.type !== "text" && !target.closest("dialog");
      if (isDone) target.blur();
      return;
    }
    // Space presses a button and opens a group; elsewhere it runs and pauses.
    if (event.key === " " && ["BUTTON", "SUMMARY"].includes(target.tagName)) return;
    const does = (event.shiftKey && shifted[event.key]) || plain[event.key];
    if (!does) return;
    event.preventDefault();
    if (event.repeat && !".,".includes(event.key) && !shifted[event.key] && !"+-=".includes(event.key)) return;
    does();
  });
}
