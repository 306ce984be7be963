// What of a scene's world lies under the pointer: a robot, an obstacle, a landmark, a lamp, a wall.

import { fixed, wrap } from "./dom.js";
import { SpatialIndex, gapToLine } from "./spatial.js";

/**
 * A thing that was found: its place among robots, or where it lies and in which view, where that is to be shown.
 * @typedef {{robot?: number, line?: number[], point?: number[], view?: import("./world.js").View}} Where
 * @typedef {import("./selection.js").Thing & Where} Found
 */

export const NEAR = 9; // pixels
const CELLS = 64; // of an index, along the longer side of a map

/** Lines and points that stand still, of the world or of what a robot knows. */
export class Standing {
  /** @param {import("./world.js").View} view
   * @param {number[]} extent */
  constructor(view, [x0, y0, x1, y1]) {
    this.view = view;
    /** @type {SpatialIndex<{kind: string, key: string, place: number[]}>} */
    this.index = new SpatialIndex(Math.max(x1 - x0, y1 - y0, 1e-3) / CELLS);
  }

  /** @param {number[][] | null | undefined} segments
   * @param {string} kind */
  addWalls(segments, kind) {
    segments?.forEach(([x0, y0, x1, y1], n) => {
      this.index.addLine({ kind, key: `${kind} ${n}`, place: [x0, y0, x1, y1] }, x0, y0, x1, y1);
    });
  }

  /** @param {number[][]} points
   * @param {string} kind */
  addPoints(points, kind) {
    points?.forEach(([x, y, radius], n) => this.index.addDisc({ kind, key: `${kind} ${n}`, place: [x, y] }, x, y, radius ?? 0));
  }

  /** The nearest point, or else the nearest wall.
   * @param {number} x
   * @param {number} y
   * @param {number} near
   * @returns {Found | null} */
  nearest(x, y, near) {
    let best = null;
    for (const thing of this.index.near(x, y, near)) {
      const isWall = thing.place.length === 4;
      const [x0, y0, x1, y1] = thing.place;
      const gap = isWall ? gapToLine(x, y, x0, y0, x1, y1) : Math.hypot(x0 - x, y0 - y);
      // A point in a wall is pointed at, not the wall.
      const rank = gap + (isWall ? near : 0);
      if (gap <= near && rank < (best?.rank ?? Infinity)) best = { thing, rank };
    }
    if (!best) return null;
    const { view } = this;
    const { kind, key, place } = best.thing;
    const [x0, y0, x1, y1] = place;
    if (place.length === 2) return { kind: "point", view, key, title: kind, lines: [where(x0, y0)], point: place };
    const length = `${fixed(Math.hypot(x1 - x0, y1 - y0), 3)} m long`;
    return { kind: "wall", view, key, title: kind, lines: [`from ${where(x0, y0)}`, `to ${where(x1, y1)}`, length], line: place };
  }
}

const where = (/** @type {number} */ x, /** @type {number} */ y) => `${fixed(x, 3)}, ${fixed(y, 3)} m`;

/** A pose in words. */
export const at = (/** @type {ArrayLike<number>} */ poses, /** @type {number} */ i, metres = 3) =>
  `x ${fixed(poses[3 * i], metres)} m, y ${fixed(poses[3 * i + 1], metres)} m, heading ` +
  `${fixed((wrap(poses[3 * i + 2]) * 180) / Math.PI, 1)}°`;

/**
 * As much of a frame as is picked from.
 * @typedef {{truePoses: ArrayLike<number>, estimatedPoses: ArrayLike<number>, obstacles: ArrayLike<number>, selected: number}} Bodies
 */

/** Finds what there truly is in a scene. */
export class WorldPicker {
  /** @type {any} */
  scene = null;
  /** @type {Standing} */
  world;
  /** @type {{frame: any, index: SpatialIndex<number>} | null} */
  bodies = null;
  farthest = 0; // the reach of any robot [m]

  constructor() {
    this.world = new Standing("true", [0, 0, 1, 1]);
  }

  /** @param {any} scene
   * @param {number[]} extent of what is to be seen [m] */
  setScene(scene, extent) {
    this.scene = scene;
    this.world = new Standing("true", extent);
    this.world.addWalls(scene.map?.segments, "wall");
    this.world.addPoints(scene.floor.landmarks, "landmark");
    this.world.addPoints(scene.floor.lights, "lamp");
    this.bodies = null;
    this.farthest = Math.max(0, ...scene.robots.map((/** @type {import("./scene.js").Robot} */ robot) => robot.reach));
  }

  /** Robots and obstacles by where they truly are in a frame.
   * @param {Bodies} frame
   * @returns {{frame: any, index: SpatialIndex<number>}} */
  bodiesOf(frame) {
    const had = this.bodies;
    if (had && had.frame === frame) return had;
    const index = new SpatialIndex(Math.max(2 * this.farthest, 0.1));
    this.scene.robots.forEach((/** @type {import("./scene.js").Robot} */ robot, /** @type {number} */ i) => index.addDisc(i, frame.truePoses[3 * i], frame.truePoses[3 * i + 1], robot.reach));
    const bodies = { frame, index };
    this.bodies = bodies;
    return bodies;
  }

  /** @param {Bodies} frame
   * @param {import("./world.js").View} view
   * @param {number} x
   * @param {number} y
   * @param {number} near
   * @param {number} part */
  nearestRobot(frame, view, x, y, near, part) {
    const poses = view === "true" ? frame.truePoses : frame.estimatedPoses;
    const candidates = view === "true" ? this.bodiesOf(frame).index.near(x, y, near) : [frame.selected];
    let best = -1;
    let least = Infinity;
    for (const i of candidates) {
      if (!this.scene.robots[i]) continue;
      const gap = Math.hypot(poses[3 * i] - x, poses[3 * i + 1] - y);
      if (gap <= Math.max(part * this.scene.robots[i].reach, near) && gap < least) {
        least = gap;
        best = i;
      }
    }
    return best;
  }

  /** @param {Bodies} frame
   * @param {number} x
   * @param {number} y
   * @param {number} near */
  nearestObstacle(frame, x, y, near) {
    const { obstacles } = this.scene;
    for (let i = 0; i < obstacles.length; i++) {
      const [u, v] = [frame.obstacles[3 * i], frame.obstacles[3 * i + 1]];
      if (Math.hypot(u - x, v - y) > Math.max(obstacles[i].reach ?? 0.3, near)) continue;
      const { name, part_of: robot } = obstacles[i];
      return { kind: "obstacle", key: name, title: name, lines: [robot ? `part of ${robot}` : "obstacle", at(frame.obstacles, i)] };
    }
    return null;
  }
}
