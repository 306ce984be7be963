// Readings that are ranges along beams: a scan as the area seen and the beams' ends, a ring of cones as sectors.

import { fixed, wrap } from "../shared/dom.js";
import { gapToLine } from "../shared/spatial.js";
import { mountPoses } from "./mounts.js";

/**
 * The beams of a range sensor: `visit(i, x, y, angle, range, met)`; a reading of infinity reaches `range_max` and one
 * of minus infinity nowhere, both with `met` false; one that is not a number is left out.
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {(i: number, x: number, y: number, angle: number, range: number, met: boolean) => void} visit
 */
export function eachBeam(sensor, pose, values, visit) {
  const mounts = mountPoses(sensor, pose);
  const one = mounts.length === 1;
  for (let i = 0; i < values.length; i++) {
    const [x, y, heading] = mounts[one ? 0 : i] ?? mounts[0];
    const value = values[i];
    if (Number.isNaN(value)) continue;
    const met = Number.isFinite(value);
    const bearing = sensor.bearings?.length ? (sensor.bearings[i] ?? 0) : 0;
    const none = value < 0 ? 0 : sensor.range_max; // -Infinity: something, too near to measure
    visit(i, x, y, heading + bearing, met ? Math.max(value, 0) : none, met);
  }
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawCones({ context, camera, theme, kind }, sensor, pose, values) {
  const half = sensor.half_angle;
  context.beginPath();
  eachBeam(sensor, pose, values, (_i, x, y, angle, range) => {
    context.moveTo(x, y);
    context.arc(x, y, range, angle - half, angle + half);
    context.closePath();
  });
  context.globalAlpha = 0.6;
  context.fillStyle = theme[`${kind}-fill`];
  context.fill("nonzero");
  context.globalAlpha = 1;
  context.beginPath();
  eachBeam(sensor, pose, values, (_i, x, y, angle, range, met) => {
    if (!met) return;
    context.moveTo(x + range * Math.cos(angle - half), y + range * Math.sin(angle - half));
    context.arc(x, y, range, angle - half, angle + half);
  });
  context.strokeStyle = theme[kind];
  context.lineWidth = 1.5 / camera.scale;
  context.stroke();
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function drawScan({ context, camera, theme, kind }, sensor, pose, values) {
  const dot = (kind === "true" ? 1.2 : 1.7) / camera.scale;
  const isWide = values.length > 1;
  context.beginPath();
  let begun = false;
  eachBeam(sensor, pose, values, (_i, x, y, angle, range) => {
    if (!begun || !isWide) context.moveTo(x, y);
    begun = true;
    context.lineTo(x + range * Math.cos(angle), y + range * Math.sin(angle));
  });
  if (isWide) {
    context.closePath();
    context.fillStyle = theme[`${kind}-fill`];
    context.fill();
  } else {
    context.strokeStyle = theme[kind];
    context.lineWidth = 1 / camera.scale;
    context.stroke();
  }
  // Ends as small squares: for the measured ones apart, which tells them from the solid line of the true ones.
  context.beginPath();
  eachBeam(sensor, pose, values, (_i, x, y, angle, range, met) => {
    if (!met) return;
    const u = x + range * Math.cos(angle);
    const v = y + range * Math.sin(angle);
    context.rect(u - dot, v - dot, 2 * dot, 2 * dot);
  });
  context.fillStyle = theme[kind];
  context.fill();
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach */
function near(sensor, pose, values, x, y, reach) {
  /** @type {import("./readings.js").Part | null} */
  let best = null;
  eachBeam(sensor, pose, values, (i, x0, y0, angle, range, met) => {
    const [x1, y1] = [x0 + range * Math.cos(angle), y0 + range * Math.sin(angle)];
    let gap = gapToLine(x, y, x0, y0, x1, y1);
    if (met && Math.hypot(x1 - x, y1 - y) < reach) gap *= 0.25; // ends before beams
    if (gap < reach && gap < (best?.gap ?? Infinity)) best = { i, gap, angle: angle - pose[2] };
  });
  return best;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading
 * @param {import("./readings.js").Part} part */
function tell(sensor, reading, { i, angle }) {
  const m = reading.measured[i];
  return {
    title: `${sensor.name}, ${sensor.half_angle ? "element" : "beam"} ${i}`,
    lines: [
      `looks ${fixed((wrap(angle) * 180) / Math.PI, 1)}° from ahead`,
      bothOf(reading.true[i], m, sensor.unit, 4),
      ...(Number.isFinite(m) ? [] : [m < 0 ? "nearer than it can measure" : "no return within its range"]),
    ],
  };
}

/** What is true and what is measured of a value, and the difference.
 * @param {number} t
 * @param {number} m
 * @param {string} unit
 * @param {number} decimals */
export function bothOf(t, m, unit, decimals) {
  const parted = Number.isFinite(t) && Number.isFinite(m) ? `, apart ${fixed(m - t, decimals)} ${unit}` : "";
  return `true ${fixed(t, decimals)} ${unit}, measured ${fixed(m, decimals)} ${unit}${parted}`;
}

export const beams = { draw: drawScan, near, tell };
export const cones = { draw: drawCones, near, tell };
