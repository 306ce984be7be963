// What lies under the pointer in the Simulator: a robot, a reading (a beam's end, a sector, a mark ...), or what stands in the world.

import { fixed } from "../shared/dom.js";
import { NEAR, Standing, WorldPicker, at } from "../shared/pick.js";
import { ROBOT } from "./protocol.js";
import { isDrawn, nearestPart, tellPart } from "./readings.js";

/** @typedef {import("../shared/pick.js").Found} Found */

const CORE = 0.8; // of a robot: nearer its rim there may be a bumper, or what begins there

export class Picker extends WorldPicker {
  /** What robots know, by the robot. @type {Map<object, Standing>} */
  known = new Map();

  /** @param {any} scene */
  setScene(scene, extent = scene.map.extent) {
    super.setScene(scene, extent);
    this.known.clear();
  }

  /** What a robot knows, indexed when it is first pointed at.
   * @param {import("../shared/scene.js").Robot} robot */
  knownBy(robot) {
    const had = this.known.get(robot);
    if (had) return had;
    const standing = new Standing("estimated", (robot.knowledge ?? this.scene.map).extent);
    standing.addWalls(robot.knowledge?.segments, "wall of its map");
    standing.addPoints(robot.landmarks, "landmark that it knows");
    this.known.set(robot, standing);
    return standing;
  }

  /**
   * The nearest thing to a point, or null.
   * @param {import("./messages.d.ts").Frame} frame
   * @param {import("../shared/world.js").View[]} views what is shown there, the topmost first
   * @param {{x: number, y: number, scale: number}} at the point [m], and pixels a metre
   * @param {{hidden: Set<string>, trueSensors: import("./messages.d.ts").SensorShape[]}} shown sensors that are not drawn, and those by true parameters
   * @returns {Found | null}
   */
  pick(frame, views, { x, y, scale }, shown) {
    const near = NEAR / scale;
    const asRobot = (/** @type {number} */ part) => {
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

  /** @param {import("./messages.d.ts").Frame} frame
   * @param {import("../shared/world.js").View[]} views
   * @param {number} x
   * @param {number} y
   * @param {number} near */
  nearestStanding(frame, views, x, y, near) {
    if (views.includes("true")) {
      const found = this.nearestObstacle(frame, x, y, near) ?? this.world.nearest(x, y, near);
      if (found) return found;
    }
    const robot = this.scene.robots[frame.selected];
    return views.includes("estimated") && robot ? this.knownBy(robot).nearest(x, y, near) : null;
  }

  /** @param {import("./messages.d.ts").Frame} frame
   * @param {import("../shared/world.js").View} view
   * @param {number} x
   * @param {number} y
   * @param {number} near
   * @param {number} scale
   * @param {{hidden: Set<string>, trueSensors: import("./messages.d.ts").SensorShape[]}} shown */
  nearestReading(frame, view, x, y, near, scale, { hidden, trueSensors }) {
    const i = frame.selected;
    const robot = this.scene.robots[i];
    if (!robot) return null;
    const isTrue = view === "true";
    const poses = isTrue ? frame.truePoses : frame.estimatedPoses;
    const pose = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    /** @type {any} */
    let best = null;
    robot.sensors.forEach((/** @type {import("./readings.js").Shape} */ sensor, /** @type {number} */ s) => {
      const reading = frame.sensors[s];
      if (!isDrawn(sensor) || hidden.has(sensor.name) || !reading) return;
      const shape = isTrue ? /** @type {import("./readings.js").Shape} */ (trueSensors[s] ?? sensor) : sensor;
      const part = nearestPart(shape, pose, isTrue ? reading.true : reading.measured, x, y, near, scale);
      if (part && part.gap < (best?.part.gap ?? Infinity)) best = { part, sensor, reading };
    });
    return best && { kind: "reading", key: best.sensor.name, ...tellPart(best.sensor, best.reading, best.part) };
  }

  /** @param {import("./messages.d.ts").Frame} frame
   * @param {number} i */
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
