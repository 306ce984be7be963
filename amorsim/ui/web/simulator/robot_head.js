// The selected robot: its name on each panel, and the switches of its sensors and beliefs.

import { colourChip, h, say } from "../shared/dom.js";
import { BELIEFS } from "./layout.js";
import { isDrawn } from "./readings.js";
import { Record } from "./record.js";

/** @typedef {import("./simulator.js").Simulator} Simulator */

/** Name the selected robot wherever the window does, and begin its record.
 * @param {Simulator} simulator */
export function showRobot(simulator) {
  simulator.parts.robot.value = String(simulator.selected);
  const chip = () => (simulator.robot.colour ? colourChip(simulator.robot.colour) : null);
  simulator.parts.errorsTitle.replaceChildren(...[chip(), `Errors of ${simulator.robot.name}`].filter(Boolean));
  simulator.parts.numbersTitle.replaceChildren(...[chip(), simulator.robot.name].filter(Boolean));
  simulator.parts.plotTitle.replaceChildren(...[chip(), "Over time"].filter(Boolean));
  const lack = simulator.robot.knowledge ? "" : `${simulator.robot.name} has no map (robots.knowledge.map)`;
  say(simulator.stage.control.lack, lack);
  simulator.record = new Record(simulator.robot);
  simulator.futures.clear();
  simulator.numbers.setQuantities(simulator.record.quantities);
  simulator.plots.setRecord(simulator.record);
  simulator.driving.setRobot(simulator.robot);
  const ranges = simulator.robot.sensors.filter(isDrawn);
  simulator.parts.sensors.replaceChildren(
    ...ranges.map((/** @type {import("./messages.d.ts").SensorShape} */ sensor) => {
      const button = h("button", { class: "tool", "aria-pressed": String(!simulator.stage.hidden.has(sensor.name)) }, sensor.name);
      button.addEventListener("click", () => {
        const { hidden } = simulator.stage;
        const shows = hidden.delete(sensor.name);
        if (!shows) hidden.add(sensor.name);
        button.setAttribute("aria-pressed", String(shows));
        simulator.stage.redraw();
      });
      return button;
    }),
  );
}

/** Switches for what the selected robot's estimator believes, where it believes any.
 * @param {Simulator} simulator
 * @param {any} frame */
export function showBeliefs(simulator, frame) {
  for (const [name, count] of BELIEFS) {
    const button = simulator.parts.tools.get(name);
    if (!frame[count]) button.remove();
    else if (!button.isConnected) simulator.parts.sensors.append(button);
  }
}
