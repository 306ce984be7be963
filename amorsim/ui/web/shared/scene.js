// Scenes made ready for drawing.

import { reach, waist } from "./footprint.js";

/**
 * A robot as it is drawn: its entry in the scene, with what its kind has.
 * @typedef {Omit<import("../simulator/messages.d.ts").Kind, "wheels"> & {
 *   name: string, colour?: string, controller: string, landmarks: number[][], knowledge: import("../simulator/messages.d.ts").MapShape | null,
 *   parts: import("../simulator/messages.d.ts").ObstacleShape[], reach: number, waist: number,
 *   wheels: {x: number, y: number, heading: number, radius: number, width: number}[],
 * }} Robot
 */

/**
 * A scene as it is drawn.
 * @typedef {Omit<import("../simulator/messages.d.ts").Scene, "map" | "robots" | "obstacles"> & {
 *   map: import("../simulator/messages.d.ts").MapShape | undefined, robots: Robot[], obstacles: (import("../simulator/messages.d.ts").ObstacleShape & {reach: number})[],
 * }} Scene
 */

/** The map of a scene.
 * @param {import("../simulator/messages.d.ts").Scene | undefined} scene */
export const mapOf = (scene) => (scene && scene.map !== null ? scene.maps[scene.map] : undefined);

/**
 * A scene with what drawing needs put in place: each robot with its kind's shape, its reach and what it knows.
 * @param {import("../simulator/messages.d.ts").Scene} raw
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
    map: mapOf(raw),
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
