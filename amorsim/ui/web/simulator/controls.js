// Who has the controls: one of the windows that look at a simulation.

import { say } from "../shared/dom.js";

/** @typedef {import("./simulator.js").Simulator} Simulator */

/** Show whether this window has them, and enable what it may do.
 * @param {Simulator} simulator */
export function showControls(simulator) {
  const { holder, asking = [] } = simulator.state;
  const isMine = holder === simulator.window;
  if (simulator.isMine !== undefined && isMine !== simulator.isMine) {
    if (isMine) simulator.hint("You have the controls now.");
    else simulator.hint(holder ? "Another window has the controls now. You watch." : "You do not have the controls any more.");
  }
  simulator.isMine = isMine;
  simulator.root.classList.toggle("watching", !isMine);
  const { reset, run, step, speed, line, toEnd } = simulator.timebar;
  for (const one of [reset, run, step, speed, line, toEnd, simulator.driving.switch]) one.disabled = !isMine;
  if (!isMine) simulator.timebar.carryOn.disabled = true;
  simulator.parts.controls.hidden = isMine && !asking.length;
  let words = "another window asks: give it the controls";
  if (!isMine) words = holder ? "you watch: ask for the controls" : "take the controls";
  if (asking.includes(simulator.window)) words = "you watch: asked for the controls";
  say(simulator.parts.controls, words);
}

/** Ask for the controls, or give them to a window that asks.
 * @param {Simulator} simulator */
export function askControls(simulator) {
  const { isMine, state } = simulator;
  const command = { do: "controls", want: isMine ? "give" : "ask", to: isMine ? state.asking[0] : undefined };
  return simulator.ask(command).then(() => simulator.reader.readState());
}
