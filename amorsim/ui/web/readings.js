// Range readings as they are drawn: where each beam begins, looks and ends. Also asked by the pointer.

import { DASHES } from "./theme.js";

/** World poses of a sensor's mounts on a robot at `pose`, one a value (a ring) or one for all (a scan). */
function mountPoses(sensor, pose) {
  const c = Math.cos(pose[2]);
  const s = Math.sin(pose[2]);
  return sensor.mounts.map(([u, v, heading]) => [pose[0] + u * c - v * s, pose[1] + u * s + v * c, pose[2] + heading]);
}

/** Whether each value of a sensor is how far it is to something along a beam. */
export const isRange = (sensor) => sensor.unit === "m" && sensor.range_max !== null && sensor.bearings !== null;

const place = (sensor, name) => sensor.columns.findIndex(([column]) => column === name);

/** Whether each line of a sensor's table is something seen at a range and a bearing. */
export const isFinder = (sensor) => place(sensor, "range") >= 0 && place(sensor, "bearing") >= 0;

export const isDrawn = (sensor) => isRange(sensor) || isFinder(sensor);

/** The things that a finder sees: `visit(line, x0, y0, x, y)`, from the mount to each. */
function eachFound(sensor, pose, values, visit) {
  const [x0, y0, heading] = mountPoses(sensor, pose)[0];
  const [range, bearing, wide] = [place(sensor, "range"), place(sensor, "bearing"), sensor.columns.length];
  for (let at = 0; at + wide <= values.length; at += wide) {
    const angle = heading + values[at + bearing];
    const far = values[at + range];
    if (Number.isFinite(far) && Number.isFinite(angle)) {
      visit(at / wide, x0, y0, x0 + far * Math.cos(angle), y0 + far * Math.sin(angle));
    }
  }
}

/**
 * The beams of a range sensor: `visit(i, x, y, angle, range, met)`; a reading of infinity reaches `range_max` and has
 * `met` false, one that is no number is left out.
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
    visit(i, x, y, heading + bearing, met ? Math.max(value, 0) : sensor.range_max, met);
  }
}

/** Draw a sensor's readings from a pose: a scan as the area seen and its ends, a ring of cones as sectors. */
export function drawReadings(context, camera, sensor, pose, values, kind, theme) {
  if (!pose.every(Number.isFinite)) return;
  if (isFinder(sensor)) drawFound(context, camera, sensor, pose, values, kind, theme);
  else if (sensor.half_angle) drawCones(context, camera, sensor, pose, values, kind, theme);
  else drawScan(context, camera, sensor, pose, values, kind, theme);
}

function drawFound(context, camera, sensor, pose, values, kind, theme) {
  const size = 5 / camera.scale;
  context.strokeStyle = theme[kind];
  context.lineWidth = 1.2 / camera.scale;
  context.setLineDash(DASHES[kind].map((d) => d / camera.scale));
  context.beginPath();
  eachFound(sensor, pose, values, (line, x0, y0, x, y) => {
    context.moveTo(x0, y0);
    context.lineTo(x, y);
  });
  context.stroke();
  context.setLineDash([]);
  context.beginPath();
  eachFound(sensor, pose, values, (line, x0, y0, x, y) => context.rect(x - size, y - size, 2 * size, 2 * size));
  context.stroke();
}

function drawCones(context, camera, sensor, pose, values, kind, theme) {
  const half = sensor.half_angle;
  context.beginPath();
  eachBeam(sensor, pose, values, (i, x, y, angle, range) => {
    context.moveTo(x, y);
    context.arc(x, y, range, angle - half, angle + half);
    context.closePath();
  });
  context.globalAlpha = 0.6;
  context.fillStyle = theme[`${kind}-fill`];
  context.fill("nonzero");
  context.globalAlpha = 1;
  context.beginPath();
  eachBeam(sensor, pose, values, (i, x, y, angle, range, met) => {
    if (!met) return;
    context.moveTo(x + range * Math.cos(angle - half), y + range * Math.sin(angle - half));
    context.arc(x, y, range, angle - half, angle + half);
  });
  context.strokeStyle = theme[kind];
  context.lineWidth = 1.5 / camera.scale;
  context.stroke();
}

function drawScan(context, camera, sensor, pose, values, kind, theme) {
  const dot = (kind === "true" ? 1.2 : 1.7) / camera.scale;
  const isWide = values.length > 1;
  context.beginPath();
  let begun = false;
  eachBeam(sensor, pose, values, (i, x, y, angle, range) => {
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
  eachBeam(sensor, pose, values, (i, x, y, angle, range, met) => {
    if (!met) return;
    const u = x + range * Math.cos(angle);
    const v = y + range * Math.sin(angle);
    context.rect(u - dot, v - dot, 2 * dot, 2 * dot);
  });
  context.fillStyle = theme[kind];
  context.fill();
}
