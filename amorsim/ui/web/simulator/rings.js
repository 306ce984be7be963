// Readings of strengths around a robot. Proximity glows: a sector before each element, as strong as its reading. Light
// is a stick before each, as long as its reading is bright: neither could be taken for how far something is.

import { bothOf } from "./beams.js";
import { fixed, wrap } from "../shared/dom.js";
import { gapToLine } from "../shared/spatial.js";
import { mountPoses } from "./mounts.js";
import { DASHES } from "../shared/theme.js";

const LONGEST = 30; // pixels of a stick

/** From 0 for a reading of nothing to 1 for the most.
 * @param {import("./readings.js").Shape} sensor
 * @param {ArrayLike<number>} values */
function levels({ drawing }, values) {
  const [none, most = farthest(values, none)] = drawing.span;
  return Array.from(values, (value) => {
    const level = (value - none) / (most - none);
    return Number.isFinite(level) ? Math.min(1, Math.max(0, level)) : 0;
  });
}

const farthest = (/** @type {ArrayLike<number>} */ values, /** @type {number} */ from) => Array.from(values).reduce((far, v) => (Math.abs(v - from) > Math.abs(far - from) ? v : far), from);

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawGlow({ context, camera, theme, kind }, sensor, pose, values) {
  const { half_angle: half, reach } = sensor.drawing;
  const mounts = mountPoses(sensor, pose);
  const seen = levels(sensor, values);
  context.fillStyle = theme[kind];
  context.strokeStyle = theme[kind];
  context.setLineDash(DASHES[kind].map((d) => d / camera.scale));
  seen.forEach((level, i) => {
    const [x, y, heading] = mounts[i] ?? mounts[0];
    context.beginPath();
    context.moveTo(x, y);
    context.arc(x, y, reach, heading - half, heading + half);
    context.closePath();
    if (level > 0) {
      context.globalAlpha = 0.12 + 0.63 * level;
      context.fill();
    }
    context.globalAlpha = level > 0 ? 1 : 0.45;
    context.lineWidth = (level > 0 ? 1.2 : 0.8) / camera.scale;
    context.stroke();
  });
  context.globalAlpha = 1;
  context.setLineDash([]);
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach */
function nearGlow(sensor, pose, values, x, y, reach) {
  const mounts = mountPoses(sensor, pose);
  /** @type {import("./readings.js").Part | null} */
  let best = null;
  for (let i = 0; i < values.length; i++) {
    const [x0, y0, heading] = mounts[i] ?? mounts[0];
    const angle = wrap(Math.atan2(y - y0, x - x0) - heading);
    const far = Math.hypot(x - x0, y - y0);
    if (far > sensor.drawing.reach || Math.abs(angle) > sensor.drawing.half_angle) continue;
    // Where two overlap it is the one that looks there; a beam that passes is nearer than any.
    const gap = reach * (0.9 + 0.1 * Math.abs(angle / Math.PI));
    if (gap < (best?.gap ?? reach)) best = { i, gap, angle: heading - pose[2] };
  }
  return best;
}

/** The sticks of a reading: `visit(i, x0, y0, x1, y1, heading)`.
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} scale
 * @param {(i: number, x0: number, y0: number, x1: number, y1: number, heading: number) => void} visit */
function eachStick(sensor, pose, values, scale, visit) {
  const mounts = mountPoses(sensor, pose);
  levels(sensor, values).forEach((level, i) => {
    const [x, y, heading] = mounts[i] ?? mounts[0];
    const long = (level * LONGEST) / scale;
    visit(i, x, y, x + long * Math.cos(heading), y + long * Math.sin(heading), heading);
  });
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawSticks({ context, camera, theme, kind }, sensor, pose, values) {
  const dot = 2.2 / camera.scale;
  context.strokeStyle = theme[kind];
  context.fillStyle = theme[kind];
  context.lineWidth = 1.6 / camera.scale;
  context.setLineDash(DASHES[kind].map((d) => d / camera.scale));
  context.beginPath();
  eachStick(sensor, pose, values, camera.scale, (_i, x0, y0, x1, y1) => {
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
  });
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  eachStick(sensor, pose, values, camera.scale, (_i, _x0, _y0, x1, y1) => {
    context.moveTo(x1 + dot, y1);
    context.arc(x1, y1, dot, 0, 2 * Math.PI);
  });
  context.fill();
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach
 * @param {number} scale */
function nearStick(sensor, pose, values, x, y, reach, scale) {
  /** @type {import("./readings.js").Part | null} */
  let best = null;
  eachStick(sensor, pose, values, scale, (i, x0, y0, x1, y1, heading) => {
    const gap = gapToLine(x, y, x0, y0, x1, y1);
    if (gap < reach && gap < (best?.gap ?? Infinity)) best = { i, gap, angle: heading - pose[2] };
  });
  return best;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading
 * @param {import("./readings.js").Part} part */
function tell(sensor, reading, { i, angle }) {
  return {
    title: `${sensor.name}, element ${i}`,
    lines: [
      `looks ${fixed((wrap(angle) * 180) / Math.PI, 1)}° from ahead`,
      bothOf(reading.true[i], reading.measured[i], sensor.unit, 1),
    ],
  };
}

export const glow = { draw: drawGlow, near: nearGlow, tell };
export const sticks = { draw: drawSticks, near: nearStick, tell };
