// What can be added to a scenario: each kind with its outline, and the table that the file says of a new one.

import { round } from "./geometry.js";

const BOX = { polygon: [[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]] };

/** A name that is not taken. */
export function freeName(stem, things) {
  const taken = new Set(things.map(({ name }) => name));
  let [name, number] = [stem, 1];
  while (taken.has(name)) name = `${stem}${++number}`;
  return name;
}

const poseOf = ([x, y, heading]) => ({ x, y, heading_deg: heading });
const numberOf = (things) => Math.max(0, ...things.filter(({ kind }) => kind === "landmark").map(({ name }) => Number(name.split(" ")[1]) || 0)) + 1;

/** The motion of people who walk between places, as in the bundled crowd.
 * @param {number[][]} goals */
export const walking = (goals) => ({ use: "pedestrian", goals: goals.map(([x, y]) => [round(x), round(y)]), relative: true, step: 1, blocked: "skip" });

/** @param {{robot: string[]}} menu what the server knows */
export function kindsOfThings({ robot }) {
  const obstacle = (label, shape, footprint) => ({
    group: "Obstacles", label, path: "obstacles", footprint,
    make: (pose, things) => ({ name: freeName(label.replace(/ /g, "-"), things), shape, pose: poseOf(pose) }),
  });
  return [
    ...robot.map((model) => ({
      group: "Robots", label: model, path: "robots", footprint: { circle: 0.22 },
      make: (pose, things) => ({ name: freeName("robot", things), model, pose: poseOf(pose) }),
    })),
    obstacle("box", { rectangle: [0.6, 0.4] }, BOX),
    obstacle("post", { circle: 0.15 }, { circle: 0.15 }),
    {
      group: "Obstacles", label: "person on foot", path: "obstacles", footprint: { circle: 0.22 },
      make: (pose, things) => ({
        name: freeName("person", things), shape: { circle: 0.22 }, pose: poseOf(pose), motion: walking([pose, [pose[0] + 3 * Math.cos((pose[2] * Math.PI) / 180), pose[1] + 3 * Math.sin((pose[2] * Math.PI) / 180)]]),
      }),
    },
    {
      group: "World", label: "landmark", path: "landmarks", footprint: { circle: 0.05 },
      make: ([x, y], things) => ({ id: numberOf(things), x, y }),
    },
    { group: "World", label: "light", path: "lights", footprint: { circle: 0.1 }, make: ([x, y]) => ({ x, y }) },
    {
      group: "World", label: "zone", path: "zones", footprint: { polygon: [[-1, -1], [1, -1], [1, 1], [-1, 1]] },
      make: (pose, things) => ({ name: freeName("zone", things), shape: { rectangle: [2.0, 2.0] }, pose: poseOf(pose) }),
    },
    { group: "Floor", label: "line on the floor", path: "floor.markings", isPath: true },
    {
      group: "Floor", label: "area of another brightness", path: "floor.markings", footprint: BOX,
      make: (pose) => ({ shape: { rectangle: [0.6, 0.4] }, pose: poseOf(pose) }),
    },
    { group: "Floor", label: "drop in the floor", path: "floor.drops", footprint: { circle: 0.3 }, make: (pose) => ({ shape: { circle: 0.3 }, pose: poseOf(pose) }) },
  ];
}
