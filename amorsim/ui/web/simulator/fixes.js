// Readings that need no beams: parts of the footprint that press on something, a place in the world, a heading.

import { fixed, wrap } from "../shared/dom.js";
import { gapToLine } from "../shared/spatial.js";
import { columnOf, mountPoses, toWorld } from "./mounts.js";
import { DASHES } from "../shared/theme.js";

const ARM = 9; // pixels of a cross
const NEEDLE = 44; // pixels

const degrees = (/** @type {number} */ angle) => fixed((wrap(angle) * 180) / Math.PI, 2);

// -------------------------------------------------------------------------------------------------------- contacts

/** The lines of each segment of a bumper: `visit(i, x0, y0, x1, y1)`.
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {(i: number, x0: number, y0: number, x1: number, y1: number) => void} visit */
function eachLine(sensor, pose, visit) {
  sensor.drawing.lines.forEach((lines, i) => {
    for (const [u0, v0, u1, v1] of lines) {
      const [[x0, y0], [x1, y1]] = [toWorld(pose, u0, v0), toWorld(pose, u1, v1)];
      visit(i, x0, y0, x1, y1);
    }
  });
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawContacts({ context, camera, theme, kind }, sensor, pose, values) {
  for (const pressed of [false, true]) {
    context.beginPath();
    eachLine(sensor, pose, (i, x0, y0, x1, y1) => {
      if (values[i] > 0.5 !== pressed) return;
      context.moveTo(x0, y0);
      context.lineTo(x1, y1);
    });
    context.strokeStyle = theme[kind];
    context.lineWidth = (pressed ? 7 : 3) / camera.scale;
    context.globalAlpha = pressed ? 1 : 0.35;
    context.stroke();
  }
  context.globalAlpha = 1;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} _values
 * @param {number} x
 * @param {number} y
 * @param {number} reach */
function nearContact(sensor, pose, _values, x, y, reach) {
  /** @type {import("./readings.js").Part | null} */
  let best = null;
  eachLine(sensor, pose, (i, x0, y0, x1, y1) => {
    const gap = gapToLine(x, y, x0, y0, x1, y1);
    if (gap < reach && gap < (best?.gap ?? Infinity)) best = { i, gap, angle: 0 };
  });
  return best;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading
 * @param {import("./readings.js").Part} part */
function tellContact(sensor, reading, { i }) {
  const word = (/** @type {number} */ value) => (Number.isNaN(value) ? "–" : value > 0.5 ? "pressed" : "free");
  return {
    title: `${sensor.name}, segment ${i}`,
    lines: [`true ${word(reading.true[i])}, measured ${word(reading.measured[i])}`],
  };
}

// ------------------------------------------------------------------------------------------------- a place in the world

/** @param {import("./readings.js").Shape} sensor
 * @param {ArrayLike<number>} values */
function fixOf(sensor, values) {
  const [x, y, heading] = ["x", "y", "heading"].map((name) => values[columnOf(sensor, name)]);
  return Number.isFinite(x) && Number.isFinite(y) ? [x, y, heading] : null;
}

/** A cross in a circle where the robot is said to be, and a dotted line from where its antenna is drawn.
 * @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawFix({ context, camera, theme, kind }, sensor, pose, values) {
  const fix = fixOf(sensor, values);
  if (!fix) return;
  const [x, y, heading] = fix;
  const arm = ARM / camera.scale;
  const [x0, y0] = mountPoses(sensor, pose)[0];
  context.strokeStyle = theme[kind];
  context.lineWidth = 1.5 / camera.scale;
  context.beginPath();
  for (const [u, v] of [[arm, 0], [0, arm]]) {
    context.moveTo(x - u, y - v);
    context.lineTo(x + u, y + v);
  }
  context.moveTo(x + 0.6 * arm, y);
  context.arc(x, y, 0.6 * arm, 0, 2 * Math.PI);
  if (Number.isFinite(heading)) {
    context.moveTo(x, y);
    context.lineTo(x + 2.2 * arm * Math.cos(heading), y + 2.2 * arm * Math.sin(heading));
  }
  context.stroke();
  context.setLineDash(DASHES.measured.map((d) => d / camera.scale));
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x, y);
  context.stroke();
  context.setLineDash([]);
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} _pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach */
function nearFix(sensor, _pose, values, x, y, reach) {
  const fix = fixOf(sensor, values);
  if (!fix) return null;
  const gap = Math.hypot(fix[0] - x, fix[1] - y);
  return gap < reach ? { i: 0, gap, angle: 0 } : null;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading */
function tellFix(sensor, reading) {
  const [t, m] = [fixOf(sensor, reading.true), fixOf(sensor, reading.measured)];
  const word = (/** @type {number[] | null} */ fix) =>
    fix ? `${fixed(fix[0], 3)}, ${fixed(fix[1], 3)} m${Number.isFinite(fix[2]) ? `, ${degrees(fix[2])}°` : ""}` : "no fix";
  return { title: sensor.name, lines: [`true ${word(t)}`, `measured ${word(m)}`] };
}

// -------------------------------------------------------------------------------------------------------- a heading

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} scale */
function tipOf(sensor, pose, values, scale) {
  const [x, y] = mountPoses(sensor, pose)[0];
  return [x, y, x + (NEEDLE / scale) * Math.cos(values[0]), y + (NEEDLE / scale) * Math.sin(values[0])];
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawNeedle({ context, camera, theme, kind }, sensor, pose, values) {
  if (!Number.isFinite(values[0])) return;
  const [x0, y0, x, y] = tipOf(sensor, pose, values, camera.scale);
  context.strokeStyle = theme[kind];
  context.lineWidth = 2 / camera.scale;
  context.setLineDash(DASHES[kind].map((d) => d / camera.scale));
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x, y);
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  for (const side of [-1, 1]) {
    const angle = values[0] + side * 2.7;
    context.moveTo(x, y);
    context.lineTo(x + (8 / camera.scale) * Math.cos(angle), y + (8 / camera.scale) * Math.sin(angle));
  }
  context.stroke();
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach
 * @param {number} scale */
function nearNeedle(sensor, pose, values, x, y, reach, scale) {
  if (!Number.isFinite(values[0])) return null;
  const [x0, y0, x1, y1] = tipOf(sensor, pose, values, scale);
  const gap = gapToLine(x, y, x0, y0, x1, y1);
  return gap < reach ? { i: 0, gap, angle: 0 } : null;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading */
function tellNeedle(sensor, reading) {
  const [t, m] = [reading.true[0], reading.measured[0]];
  return { title: sensor.name, lines: [`true ${degrees(t)}°, measured ${degrees(m)}°, apart ${degrees(m - t)}°`] };
}

export const contacts = { draw: drawContacts, near: nearContact, tell: tellContact };
export const fix = { draw: drawFix, near: nearFix, tell: tellFix };
export const needle = { draw: drawNeedle, near: nearNeedle, tell: tellNeedle };
