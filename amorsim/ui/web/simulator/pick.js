// What lies under the pointer: a robot, a reading (a beam's end, a sector, a mark ...), an obstacle.

import { fixed, wrap } from "../shared/dom.js";
import { isDrawn, nearestPart, tellPart } from "./readings.js";

const NEAR = 9; // pixels

/** The nearest thing to the world point (x, y), or null: `{kind, title, lines, robot?}`. */
export function pick(scene, frame, layers, camera, x, y, trueSensors) {
  const near = NEAR / camera.scale;
  const posesOf = (layer) => (layer.kind === "true" ? frame.truePoses : frame.estimatedPoses);
  const shown = (layer) => (layer.kind === "true" ? scene.robots.map((_, i) => i) : [frame.selected]);
  // At a robot's rim there may be a bumper, or what begins at its rim: there it is the robot if it is nothing else.
  for (const layer of layers) {
    const robot = nearestRobot(scene, shown(layer), posesOf(layer), x, y, near, 0.8);
    if (robot >= 0) return describeRobot(scene, frame, robot);
  }
  for (const layer of layers) {
    const reading = nearestReading(scene, frame, layer, camera, x, y, near, trueSensors);
    if (reading) return reading;
  }
  for (const layer of layers) {
    const robot = nearestRobot(scene, shown(layer), posesOf(layer), x, y, near, 1);
    if (robot >= 0) return describeRobot(scene, frame, robot);
  }
  for (let i = 0; i < scene.obstacles.length; i++) {
    const reach = scene.obstacles[i].reach ?? 0.3;
    if (Math.hypot(frame.obstacles[3 * i] - x, frame.obstacles[3 * i + 1] - y) <= Math.max(reach, near)) {
      const { name, part_of: robot } = scene.obstacles[i];
      return { kind: "obstacle", title: name, lines: [robot ? `part of ${robot}` : "obstacle", at(frame.obstacles, i)] };
    }
  }
  return null;
}

function nearestRobot(scene, robots, poses, x, y, near, part) {
  let best = -1;
  let least = Infinity;
  for (const i of robots) {
    const gap = Math.hypot(poses[3 * i] - x, poses[3 * i + 1] - y);
    if (gap <= Math.max(part * scene.robots[i].reach, near) && gap < least) {
      least = gap;
      best = i;
    }
  }
  return best;
}

const at = (poses, i, metres = 3) =>
  `x ${fixed(poses[3 * i], metres)} m, y ${fixed(poses[3 * i + 1], metres)} m, heading ` +
  `${fixed((wrap(poses[3 * i + 2]) * 180) / Math.PI, 1)}°`;

function describeRobot(scene, frame, i) {
  const robot = scene.robots[i];
  const metres = robot.reach < 0.1 ? 4 : 3;
  const gap = Math.hypot(
    frame.truePoses[3 * i] - frame.estimatedPoses[3 * i],
    frame.truePoses[3 * i + 1] - frame.estimatedPoses[3 * i + 1],
  );
  const state = frame.flags[i] & 4 ? "driven by hand" : frame.flags[i] & 2 ? "its controller ended" : "its controller drives";
  return {
    kind: "robot",
    robot: i,
    title: robot.name,
    lines: [
      robot.model || "robot",
      `true: ${at(frame.truePoses, i, metres)}`,
      `estimated: ${at(frame.estimatedPoses, i, metres)}`,
      `apart: ${fixed(gap, metres)} m`,
      state + (frame.flags[i] & 1 ? ", in contact" : ""),
    ],
  };
}

function nearestReading(scene, frame, layer, camera, x, y, near, trueSensors) {
  const selected = frame.selected;
  const robot = scene.robots[selected];
  if (!robot) return null;
  const poses = layer.kind === "true" ? frame.truePoses : frame.estimatedPoses;
  const pose = [poses[3 * selected], poses[3 * selected + 1], poses[3 * selected + 2]];
  let best = null;
  robot.sensors.forEach((sensor, s) => {
    const reading = frame.sensors[s];
    if (!isDrawn(sensor) || !layer.shows(sensor.name) || !reading) return;
    const values = layer.kind === "true" ? reading.true : reading.measured;
    const shape = layer.kind === "true" ? (trueSensors[s] ?? sensor) : sensor;
    const part = nearestPart(shape, pose, values, x, y, near, camera.scale);
    if (part && part.gap < (best?.part.gap ?? Infinity)) best = { part, sensor, reading };
  });
  return best && { kind: "reading", ...tellPart(best.sensor, best.reading, best.part) };
}
