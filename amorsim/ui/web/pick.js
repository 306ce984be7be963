// What lies under the pointer: a robot, a beam's end or a beam, an obstacle.

import { fixed, wrap } from "./dom.js";
import { eachBeam, isRange } from "./readings.js";

const NEAR = 9; // pixels

/** The nearest thing to the world point (x, y), or null: `{kind, title, lines, robot?}`. */
export function pick(scene, frame, layers, camera, x, y, trueSensors) {
  const near = NEAR / camera.scale;
  for (const layer of layers) {
    const poses = layer.kind === "true" ? frame.truePoses : frame.estimatedPoses;
    const robot = nearestRobot(scene, poses, x, y, near);
    if (robot >= 0) return describeRobot(scene, frame, robot);
  }
  for (const layer of layers) {
    const beam = nearestBeam(scene, frame, layer, x, y, near, trueSensors);
    if (beam) return beam;
  }
  for (let i = 0; i < scene.obstacles.length; i++) {
    const reach = scene.obstacles[i].reach ?? 0.3;
    if (Math.hypot(frame.obstacles[3 * i] - x, frame.obstacles[3 * i + 1] - y) <= Math.max(reach, near)) {
      return { kind: "obstacle", title: scene.obstacles[i].name, lines: ["obstacle", at(frame.obstacles, i)] };
    }
  }
  return null;
}

function nearestRobot(scene, poses, x, y, near) {
  let best = -1;
  let least = Infinity;
  for (let i = 0; i < scene.robots.length; i++) {
    const gap = Math.hypot(poses[3 * i] - x, poses[3 * i + 1] - y);
    if (gap <= Math.max(scene.robots[i].reach, near) && gap < least) {
      least = gap;
      best = i;
    }
  }
  return best;
}

const at = (poses, i) =>
  `x ${fixed(poses[3 * i], 3)} m, y ${fixed(poses[3 * i + 1], 3)} m, heading ` +
  `${fixed((wrap(poses[3 * i + 2]) * 180) / Math.PI, 1)}°`;

function describeRobot(scene, frame, i) {
  const robot = scene.robots[i];
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
      `true: ${at(frame.truePoses, i)}`,
      `estimated: ${at(frame.estimatedPoses, i)}`,
      `apart: ${fixed(gap, 3)} m`,
      state + (frame.flags[i] & 1 ? ", in contact" : ""),
    ],
  };
}

function nearestBeam(scene, frame, layer, x, y, near, trueSensors) {
  const selected = frame.selected;
  const robot = scene.robots[selected];
  if (!robot) return null;
  const poses = layer.kind === "true" ? frame.truePoses : frame.estimatedPoses;
  const pose = [poses[3 * selected], poses[3 * selected + 1], poses[3 * selected + 2]];
  let best = null;
  let least = near;
  robot.sensors.forEach((sensor, s) => {
    if (!isRange(sensor) || !layer.shows(sensor.name) || !frame.sensors[s]) return;
    const values = layer.kind === "true" ? frame.sensors[s].true : frame.sensors[s].measured;
    const shape = layer.kind === "true" ? (trueSensors[s] ?? sensor) : sensor;
    eachBeam(shape, pose, values, (i, x0, y0, angle, range, met) => {
      const c = Math.cos(angle);
      const t = Math.sin(angle);
      const along = Math.min(range, Math.max(0, (x - x0) * c + (y - y0) * t));
      let gap = Math.hypot(x0 + along * c - x, y0 + along * t - y);
      if (met && Math.hypot(x0 + range * c - x, y0 + range * t - y) < near) gap *= 0.25; // ends before beams
      if (gap < least) {
        least = gap;
        best = describeBeam(sensor, frame.sensors[s], i, angle - pose[2]);
      }
    });
  });
  return best;
}

function describeBeam(sensor, reading, i, bearing) {
  const [t, m] = [reading.true[i], reading.measured[i]];
  const parted = Number.isFinite(t) && Number.isFinite(m) ? `, apart ${fixed(m - t, 4)} ${sensor.unit}` : "";
  return {
    kind: "beam",
    title: `${sensor.name}, ${sensor.half_angle ? "element" : "beam"} ${i}`,
    lines: [
      `looks ${fixed((wrap(bearing) * 180) / Math.PI, 1)}° from ahead`,
      `true ${fixed(t, 4)} ${sensor.unit}, measured ${fixed(m, 4)} ${sensor.unit}${parted}`,
      ...(Number.isFinite(m) ? [] : ["no return within its range"]),
      ...(reading.age > 0 ? [`${fixed(reading.age, 2)} s old`] : []),
    ],
  };
}
