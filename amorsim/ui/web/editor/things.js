// What can be added to a scenario: each kind with its outline, and the table that the file says of a new one.

import { there } from "../shared/dom.js";
import { round } from "./geometry.js";

/** The outline of a shape as files have it.
 * @param {{circle?: number, rectangle?: number[]}} shape */
export function footprintOf({ circle, rectangle }) {
  if (circle) return { circle };
  const [a, b] = there(rectangle).map((side) => side / 2);
  return { polygon: [[-a, -b], [a, -b], [a, b], [-a, b]] };
}

/** A name that is not taken.
 * @param {string} stem
 * @param {{name: string}[]} things */
export function freeName(stem, things) {
  const taken = new Set(things.map(({ name }) => name));
  let [name, number] = [stem, 1];
  while (taken.has(name)) name = `${stem}${++number}`;
  return name;
}

const poseOf = (/** @type {number[]} */ [x, y, heading]) => ({ x, y, heading_deg: heading });
const numberOf = (/** @type {{kind: string, name: string}[]} */ things) => Math.max(0, ...things.filter(({ kind }) => kind === "landmark").map(({ name }) => Number(name.split(" ")[1]) || 0)) + 1;

/** The motion of people who walk between places, as in the bundled crowd.
 * @param {number[][]} goals */
export const walking = (goals) => ({ use: "pedestrian", goals: goals.map(([x, y]) => [round(x), round(y)]), relative: true, step: 1, blocked: "skip" });

/** @param {{robot: string[]}} menu what the server knows */
export function kindsOfThings({ robot }) {
  const obstacle = (/** @type {string} */ label, /** @type {object} */ shape, /** @type {string} */ sentence, group = "Obstacles") => ({
    group, label, path: "obstacles", footprint: footprintOf(shape), sentence, sized: Object.keys(shape)[0],
    make: (/** @type {number[]} */ pose, /** @type {import("./stage.js").Thing[]} */ things, /** @type {object | undefined} */ size) => ({ name: freeName(label.replace(/ /g, "-"), things), shape: size ?? shape, pose: poseOf(pose) }),
  });
  const furniture = (/** @type {string} */ label, /** @type {object} */ shape, /** @type {string} */ sentence) => obstacle(label, shape, sentence, "Furniture");
  return [
    ...robot.map((model) => ({
      group: "Robots", label: model, path: "robots", footprint: { circle: 0.22 },
      make: (/** @type {number[]} */ pose, /** @type {import("./stage.js").Thing[]} */ things) => ({ name: freeName("robot", things), model, pose: poseOf(pose) }),
    })),
    obstacle("box", { rectangle: [0.6, 0.4] }, "Stands still. Drag it out as large as it is to be."),
    obstacle("post", { circle: 0.15 }, "A round one. Drag from its middle to its rim."),
    furniture("desk", { rectangle: [1.6, 0.8] }, "1.6 × 0.8 m"),
    furniture("chair", { rectangle: [0.45, 0.45] }, "0.45 × 0.45 m"),
    furniture("round table", { circle: 0.55 }, "1.1 m across"),
    furniture("shelf", { rectangle: [1.2, 0.35] }, "1.2 × 0.35 m"),
    furniture("pallet", { rectangle: [1.2, 0.8] }, "1.2 × 0.8 m, as of EUR 1"),
    {
      group: "People", label: "person on foot", path: "obstacles", footprint: { circle: 0.22 }, sentence: "Walks to and fro between two places.",
      make: (/** @type {number[]} */ pose, /** @type {import("./stage.js").Thing[]} */ things) => ({
        name: freeName("person", things), shape: { circle: 0.22 }, pose: poseOf(pose), motion: walking([pose, [pose[0] + 3 * Math.cos((pose[2] * Math.PI) / 180), pose[1] + 3 * Math.sin((pose[2] * Math.PI) / 180)]]),
      }),
    },
    {
      group: "World", label: "landmark", path: "landmarks", sentence: "A mark that robots may know and see.", footprint: { circle: 0.05 },
      make: (/** @type {number[]} */ [x, y], /** @type {import("./stage.js").Thing[]} */ things) => ({ id: numberOf(things), x, y }),
    },
    { group: "World", label: "light", path: "lights", sentence: "A lamp, for sensors of light.", footprint: { circle: 0.1 }, make: (/** @type {number[]} */ [x, y]) => ({ x, y }) },
    {
      group: "World", label: "zone", path: "zones", footprint: footprintOf({ rectangle: [2.0, 2.0] }), sized: "rectangle", sentence: "A part of the floor with a ground of its own.",
      make: (/** @type {number[]} */ pose, /** @type {import("./stage.js").Thing[]} */ things, /** @type {object | undefined} */ size) => ({ name: freeName("zone", things), shape: size ?? { rectangle: [2.0, 2.0] }, pose: poseOf(pose) }),
    },
    { group: "Floor", label: "line on the floor", path: "floor.markings", isPath: true, sentence: "Click its points, for a robot to follow." },
    {
      group: "Floor", label: "area of another brightness", path: "floor.markings", footprint: footprintOf({ rectangle: [0.6, 0.4] }), sized: "rectangle",
      make: (/** @type {number[]} */ pose, /** @type {unknown} */ _, /** @type {object | undefined} */ size) => ({ shape: size ?? { rectangle: [0.6, 0.4] }, pose: poseOf(pose) }),
    },
    { group: "Floor", label: "drop in the floor", path: "floor.drops", footprint: { circle: 0.3 }, sized: "circle", make: (/** @type {number[]} */ pose, /** @type {unknown} */ _, /** @type {object | undefined} */ size) => ({ shape: size ?? { circle: 0.3 }, pose: poseOf(pose) }) },
  ];
}
