// Readings of things that were found: marks with an identity, blobs of a colour. A line to each, a square there, and by
// it what it is said to be.

import { bothOf } from "./beams.js";
import { fixed, wrap } from "../shared/dom.js";
import { gapToLine } from "../shared/spatial.js";
import { columnOf, mountPoses } from "./mounts.js";
import { DASHES } from "../shared/theme.js";

/** The things that a finder sees: `visit(line, x0, y0, x, y, angle)`, from the mount to each.
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {(line: number, x0: number, y0: number, x: number, y: number, angle: number) => void} visit */
function eachFound(sensor, pose, values, visit) {
  const [x0, y0, heading] = mountPoses(sensor, pose)[0];
  const [range, bearing, wide] = [columnOf(sensor, "range"), columnOf(sensor, "bearing"), sensor.columns.length];
  for (let at = 0; at + wide <= values.length; at += wide) {
    const angle = heading + values[at + bearing];
    const far = values[at + range];
    if (Number.isFinite(far) && Number.isFinite(angle)) {
      visit(at / wide, x0, y0, x0 + far * Math.cos(angle), y0 + far * Math.sin(angle), angle);
    }
  }
}

/** What a line of the table says that a thing is: a colour's name or an identity; "" where it says neither.
 * @param {import("./readings.js").Shape} sensor
 * @param {ArrayLike<number>} values
 * @param {number} line */
function nameOf(sensor, values, line) {
  const [colour, id, at] = [columnOf(sensor, "colour"), columnOf(sensor, "id"), line * sensor.columns.length];
  if (colour >= 0) return sensor.drawing.names?.[values[at + colour]] ?? "";
  return id >= 0 && values[at + id] > 0 ? fixed(values[at + id], 0) : "";
}

/** @param {import("./readings.js").ReadingBrush} brush
 * @param {import("./readings.js").Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
function draw({ context, camera, theme, kind }, sensor, pose, values) {
  const size = 5 / camera.scale;
  const colour = columnOf(sensor, "colour");
  context.strokeStyle = theme[kind];
  context.lineWidth = 1.2 / camera.scale;
  context.setLineDash(DASHES[kind].map((d) => d / camera.scale));
  context.beginPath();
  eachFound(sensor, pose, values, (_line, x0, y0, x, y) => {
    context.moveTo(x0, y0);
    context.lineTo(x, y);
  });
  context.stroke();
  context.setLineDash([]);
  context.font = "11px system-ui, sans-serif";
  eachFound(sensor, pose, values, (line, _x0, _y0, x, y) => {
    context.beginPath();
    context.rect(x - size, y - size, 2 * size, 2 * size);
    if (colour >= 0) {
      context.fillStyle = sensor.drawing.colours?.[values[line * sensor.columns.length + colour]] ?? theme.paper;
      context.fill();
    }
    context.stroke();
    const name = nameOf(sensor, values, line);
    if (!name) return;
    context.save();
    context.translate(x, y);
    context.scale(1 / camera.scale, -1 / camera.scale); // letters stand upright where y goes up
    context.fillStyle = theme[kind];
    context.fillText(name, 8, colour >= 0 ? 14 : -6); // a blob and a mark may be one and the same thing
    context.restore();
  });
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
  eachFound(sensor, pose, values, (i, x0, y0, x1, y1, angle) => {
    let gap = gapToLine(x, y, x0, y0, x1, y1);
    if (Math.hypot(x1 - x, y1 - y) < reach) gap *= 0.25;
    if (gap < reach && gap < (best?.gap ?? Infinity)) best = { i, gap, angle: angle - pose[2] };
  });
  return best;
}

/** @param {import("./readings.js").Shape} sensor
 * @param {import("./readings.js").Reading} reading
 * @param {import("./readings.js").Part} part */
function tell(sensor, reading, { i }) {
  const wide = sensor.columns.length;
  const lines = sensor.columns.map(([name, unit], k) => {
    const [t, m] = [reading.true[i * wide + k], reading.measured[i * wide + k]];
    if (name === "colour") return `colour: true ${named(sensor, t)}, measured ${named(sensor, m)}`;
    if (unit === "rad") return `${name}: ${bothOf(degrees(t), degrees(m), "°", 2)}`;
    return `${name}: ${bothOf(t, m, unit === "id" ? "" : unit, unit === "m" ? 3 : 0)}`;
  });
  return { title: `${sensor.name}, ${nameOf(sensor, reading.measured, i) || `thing ${i}`}`, lines };
}

const named = (/** @type {import("./readings.js").Shape} */ sensor, /** @type {number} */ colour) => sensor.drawing.names?.[colour] ?? "none";
const degrees = (/** @type {number} */ angle) => (wrap(angle) * 180) / Math.PI;

export const things = { draw, near, tell };
