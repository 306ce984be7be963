// What `amorsim/ui/simulator/packing.py` packs, unpacked: the bytes of a frame; and a scene made ready for drawing.

import { reach, waist } from "../shared/marks.js";
import { BLOCKS, FLAG, HEADER, HEADER_SIZE, MAGIC, ROBOT } from "./wire.js";

export { FLAG, ROBOT };

/**
 * A frame of its bytes; the scene says how the selected robot's values part into sensors.
 * @param {ArrayBuffer} buffer
 * @param {Scene | null} scene
 * @returns {import("./wire.js").Frame}
 */
export function readFrame(buffer, scene) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER_SIZE || view.getUint32(0, true) !== MAGIC) throw new Error("these are not a frame's bytes");
  /** @type {any} */
  const frame = {};
  for (const [name, kind, at] of HEADER) frame[name] = view[`get${kind}`](at, true);
  let at = HEADER_SIZE;
  for (const [name, Kind, counted, each] of BLOCKS) {
    frame[name] = new Kind(buffer, at, each * (counted ? frame[counted] : 1));
    at += frame[name].byteLength;
  }
  frame.sensors = [];
  const shapes = scene && scene.version === frame.version ? (scene.robots[frame.selected]?.sensors ?? []) : [];
  let from = 0;
  shapes.forEach((sensor, s) => {
    const to = from + sensor.size;
    if (to > frame.valueCount || s >= frame.sensorCount) return;
    frame.sensors.push({ true: frame.trueValues.subarray(from, to), measured: frame.measuredValues.subarray(from, to), age: frame.ages[s] });
    from = to;
  });
  return frame;
}

/**
 * A robot as it is drawn: its entry in the scene, with what its kind has.
 * @typedef {Omit<import("./wire.js").Kind, "wheels"> & {
 *   name: string, colour?: string, controller: string, landmarks: number[][], knowledge: import("./wire.js").MapShape | null,
 *   parts: import("./wire.js").ObstacleShape[], reach: number, waist: number,
 *   wheels: {x: number, y: number, heading: number, radius: number, width: number}[],
 * }} Robot
 */

/**
 * A scene as it is drawn.
 * @typedef {Omit<import("./wire.js").Scene, "map" | "robots" | "obstacles"> & {
 *   map: import("./wire.js").MapShape, robots: Robot[], obstacles: (import("./wire.js").ObstacleShape & {reach: number})[],
 * }} Scene
 */

/**
 * A scene with what drawing needs put in place: each robot with its kind's shape, its reach and what it was told.
 * @param {import("./wire.js").Scene} raw
 * @returns {Scene}
 */
export function readScene(raw) {
  const kinds = raw.kinds.map((kind) => ({
    ...kind,
    reach: reach(kind.footprint),
    waist: waist(kind.footprint),
    wheels: kind.wheels.map(([x, y, heading, radius]) => ({ x, y, heading, radius, width: 0.4 * radius })),
  }));
  return {
    ...raw,
    map: raw.maps[raw.map],
    robots: raw.robots.map((robot) => ({
      ...kinds[robot.kind],
      name: robot.name,
      colour: robot.colour,
      controller: robot.controller,
      landmarks: robot.knowledge.landmarks,
      parts: raw.obstacles.filter((body) => body.part_of === robot.name),
      knowledge: robot.knowledge.map === null ? null : raw.maps[robot.knowledge.map],
    })),
    obstacles: raw.obstacles.map((obstacle) => ({ ...obstacle, reach: reach(obstacle.footprint) })),
  };
}
