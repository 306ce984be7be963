// Readings as they are drawn and pointed at. Each style (see `Drawing` in `amorsim/ui/simulator/frames/protocol.py`) has three functions:
// `draw(brush, sensor, pose, values)`, `near(sensor, pose, values, x, y, reach, scale)`, the part of a reading within
// `reach` of a point with its `gap`, or null; and `tell(sensor, reading, part)`, what that part is and reads.

import { beams, cones } from "./beams.js";
import { fixed } from "../shared/dom.js";
import { contacts, fix, needle } from "./fixes.js";
import { glow, sticks } from "./rings.js";
import { things } from "./things.js";

/**
 * A sensor that is drawn: what its style needs is there.
 * @typedef {import("./messages.d.ts").SensorShape & {drawing: Required<import("./messages.d.ts").Drawing>, range_max: number, half_angle: number}} Shape
 * @typedef {{true: ArrayLike<number>, measured: ArrayLike<number>, age: number}} Reading
 * @typedef {{i: number, gap: number, angle: number}} Part the part of a reading that is near a point: its number, how far, where it looks
 * @typedef {import("../shared/layer.js").Brush & {kind: string}} ReadingBrush
 */

/**
 * @typedef {{
 *   draw: (brush: ReadingBrush, sensor: Shape, pose: import("./mounts.js").Pose, values: ArrayLike<number>) => void,
 *   near: (sensor: Shape, pose: import("./mounts.js").Pose, values: ArrayLike<number>, x: number, y: number, reach: number, scale: number) => Part | null,
 *   tell: (sensor: Shape, reading: Reading, part: Part) => {title: string, lines: string[]},
 * }} Style
 */

/** @type {Record<string, Style>} */
const STYLES = { beams, cones, contacts, fix, glow, needle, sticks, things };

const styleOf = (/** @type {import("./messages.d.ts").SensorShape} */ sensor) => STYLES[sensor.drawing?.style ?? ""];

export const isDrawn = (/** @type {import("./messages.d.ts").SensorShape} */ sensor) => styleOf(sensor) !== undefined;

/** Whether each value of a sensor is how far it is to something along a beam. */
export const isRange = (/** @type {import("./messages.d.ts").SensorShape} */ sensor) => ["beams", "cones"].includes(sensor.drawing?.style ?? "");

/** Draw a sensor's readings from a pose; the brush is `{context, camera, theme, kind}`.
 * @param {ReadingBrush} brush
 * @param {Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values */
export function drawReadings(brush, sensor, pose, values) {
  if (pose.every(Number.isFinite)) styleOf(sensor).draw(brush, sensor, pose, values);
}

/** The nearest part of a sensor's reading to a point, or null.
 * @param {Shape} sensor
 * @param {import("./mounts.js").Pose} pose
 * @param {ArrayLike<number>} values
 * @param {number} x
 * @param {number} y
 * @param {number} reach
 * @param {number} scale */
export function nearestPart(sensor, pose, values, x, y, reach, scale) {
  return pose.every(Number.isFinite) ? styleOf(sensor).near(sensor, pose, values, x, y, reach, scale) : null;
}

/** What a part of a reading is and reads: `{title, lines}`.
 * @param {Shape} sensor
 * @param {Reading} reading
 * @param {Part} part */
export function tellPart(sensor, reading, part) {
  const { title, lines } = styleOf(sensor).tell(sensor, reading, part);
  return { title, lines: reading.age > 0 ? [...lines, `${fixed(reading.age, 2)} s old`] : lines };
}
