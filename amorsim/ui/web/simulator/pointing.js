// What is pointed at: a thing in a pane, or something that happened.

import { h } from "../shared/dom.js";

/** @typedef {import("./simulator.js").Simulator} Simulator */

/** Show where and when something happened.
 * @param {Simulator} simulator
 * @param {import("./messages.d.ts").EventLine} event */
export async function goTo(simulator, event) {
  const { stage } = simulator;
  if (event.point) {
    stage.mark = { point: event.point, tick: event.tick };
    stage.setOption("follow", false);
    stage.camera.centre(event.point[0], event.point[1]);
  }
  const index = simulator.scene.robots.findIndex((/** @type {{name: string}} */ robot) => robot.name === event.robot);
  if (index >= 0 && index !== simulator.selected) await simulator.ask({ do: "select", robot: index });
  if (simulator.newest.tick !== event.tick) await simulator.ask({ do: "scrub", tick: event.tick });
}

/** Something was pointed at, or nothing: tell what it is, and turn to a robot.
 * @param {Simulator} simulator
 * @param {{canvas: HTMLCanvasElement, magnify: number}} pane
 * @param {import("../shared/tool.js").Place} place */
export function picked(simulator, { canvas, magnify }, { left, top }) {
  const found = simulator.stage.selection.only;
  if (!found) return;
  const { card } = simulator.parts;
  card.replaceChildren(h("strong", {}, found.title), ...found.lines.map((line) => h("div", {}, line)));
  const box = canvas.getBoundingClientRect();
  card.style.left = `${Math.min(box.left + left * magnify + 14, innerWidth - 330)}px`;
  card.style.top = `${Math.min(box.top + top * magnify + 14, innerHeight - 150)}px`;
  if (found.robot !== undefined && found.robot !== simulator.selected) simulator.ask({ do: "select", robot: found.robot });
}
