// What lies under the pointer: a robot, a reading (a beam's end, a sector, a mark ...), an obstacle, a landmark, a lamp, a wall.

import { fixed, wrap } from "../shared/dom.js";
import { SpatialIndex } from "../shared/spatial.js";
import { gapToLine } from "./mounts.js";
import { ROBOT } from "./protocol.js";
import { isDrawn, nearestPart, tellPart } from "./readings.js";

/**
 * A thing that was found: its place among robots, or where it lies and in which view, where that is to be shown.
 * @typedef {{robot?: number, line?: number[], point?: number[], view?: import("./layers.js").View}} Where
 * @typedef {import("../shared/selection.js").Thing & Where} Found
 */

const NEAR = 9; // pixels
const CELLS = 64; // of an index, along the longer side of a map
const CORE = 0.8; // of a robot: nearer its rim there may be a bumper, or what begins there

/** Lines and points that stand still, of the world or of what a robot knows. */
class Standing {
  /** @param {import("./layers.js").View} view
   * @param {number[]} extent */
  constructor(view, [x0, y0, x1, y1]) {
    this.view = view;
    /** @type {SpatialIndex<{kind: string, key: string, place: number[]}>} */
    this.index = new SpatialIndex(Math.max(x1 - x0, y1 - y0, 1e-3) / CELLS);
  }

  /** @param {number[][]} segments
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

export class Picker {
  setScene(scene) {
    this.scene = scene;
    this.world = new Standing("true", scene.map.extent);
    this.world.addWalls(scene.map.segments, "wall");
    this.world.addPoints(scene.floor.landmarks, "landmark");
    this.world.addPoints(scene.floor.lights, "lamp");
    /** @type {Map<object, Standing>} */
    this.known = new Map();
    this.bodies = null;
    this.farthest = Math.max(0, ...scene.robots.map((robot) => robot.reach));
  }

  /** What a robot knows, indexed when it is first pointed at. */
  knownBy(robot) {
    if (!this.known.has(robot)) {
      const standing = new Standing("estimated", (robot.knowledge ?? this.scene.map).extent);
      standing.addWalls(robot.knowledge?.segments, "wall of its map");
      standing.addPoints(robot.landmarks, "landmark that it knows");
      this.known.set(robot, standing);
    }
    return this.known.get(robot);
  }

  /** Robots and obstacles by where they truly are in a frame. */
  bodiesOf(frame) {
    if (this.bodies?.frame === frame) return this.bodies;
    const index = new SpatialIndex(Math.max(2 * this.farthest, 0.1));
    this.scene.robots.forEach((robot, i) => index.addDisc(i, frame.truePoses[3 * i], frame.truePoses[3 * i + 1], robot.reach));
    this.bodies = { frame, index };
    return this.bodies;
  }

  /**
   * The nearest thing to a point, or null.
   * @param {object} frame
   * @param {import("./layers.js").View[]} views what is shown there, the topmost first
   * @param {{x: number, y: number, scale: number}} at the point [m], and pixels a metre
   * @param {{hidden: Set<string>, trueSensors: object[]}} shown sensors that are not drawn, and those by true parameters
   * @returns {Found | null}
   */
  pick(frame, views, { x, y, scale }, shown) {
    const near = NEAR / scale;
    const asRobot = (part) => {
      for (const view of views) {
        const i = this.nearestRobot(frame, view, x, y, near, part);
        if (i >= 0) return this.tellRobot(frame, i);
      }
      return null;
    };
    const asReading = () => {
      for (const view of views) {
        const reading = this.nearestReading(frame, view, x, y, near, scale, shown);
        if (reading) return reading;
      }
      return null;
    };
    return asRobot(CORE) ?? asReading() ?? asRobot(1) ?? this.nearestStanding(frame, views, x, y, near);
  }

  nearestStanding(frame, views, x, y, near) {
    if (views.includes("true")) {
      const found = this.nearestObstacle(frame, x, y, near) ?? this.world.nearest(x, y, near);
      if (found) return found;
    }
    const robot = this.scene.robots[frame.selected];
    return views.includes("estimated") && robot ? this.knownBy(robot).nearest(x, y, near) : null;
  }

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

  nearestReading(frame, view, x, y, near, scale, { hidden, trueSensors }) {
    const i = frame.selected;
    const robot = this.scene.robots[i];
    if (!robot) return null;
    const isTrue = view === "true";
    const poses = isTrue ? frame.truePoses : frame.estimatedPoses;
    const pose = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    /** @type {any} */
    let best = null;
    robot.sensors.forEach((sensor, s) => {
      const reading = frame.sensors[s];
      if (!isDrawn(sensor) || hidden.has(sensor.name) || !reading) return;
      const shape = isTrue ? (trueSensors[s] ?? sensor) : sensor;
      const part = nearestPart(shape, pose, isTrue ? reading.true : reading.measured, x, y, near, scale);
      if (part && part.gap < (best?.part.gap ?? Infinity)) best = { part, sensor, reading };
    });
    return best && { kind: "reading", key: best.sensor.name, ...tellPart(best.sensor, best.reading, best.part) };
  }

  tellRobot(frame, i) {
    const robot = this.scene.robots[i];
    const metres = robot.reach < 0.1 ? 4 : 3;
    const { truePoses: truth, estimatedPoses: belief } = frame;
    const gap = Math.hypot(truth[3 * i] - belief[3 * i], truth[3 * i + 1] - belief[3 * i + 1]);
    const flags = frame.flags[i];
    const state = flags & ROBOT.byHand ? "driven by hand" : flags & ROBOT.ended ? "its controller ended" : "its controller drives";
    return {
      kind: "robot",
      key: robot.name,
      robot: i,
      title: robot.name,
      lines: [
        robot.model || "robot",
        `true: ${at(truth, i, metres)}`,
        `estimated: ${at(belief, i, metres)}`,
        `apart: ${fixed(gap, metres)} m`,
        state + (flags & ROBOT.touching ? ", in contact" : ""),
      ],
    };
  }
}

const at = (poses, i, metres = 3) =>
  `x ${fixed(poses[3 * i], metres)} m, y ${fixed(poses[3 * i + 1], metres)} m, heading ` +
  `${fixed((wrap(poses[3 * i + 2]) * 180) / Math.PI, 1)}°`;
