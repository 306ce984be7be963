// Readings as they are drawn and pointed at. Each style (see `Drawing` in `amorsim/ui/simulator/frames/protocol.py`) has three functions:
// `draw(brush, sensor, pose, values)`, `near(sensor, pose, values, x, y, reach, scale)`, the part of a reading within
// `reach` of a point with its `gap`, or null; and `tell(sensor, reading, part)`, what that part is and reads.

import { beams, cones } from "./beams.js";
import { fixed } from "../shared/dom.js";
import { contacts, fix, needle } from "./fixes.js";
import { glow, sticks } from "./rings.js";
import { things } from "./things.js";

const STYLES = { beams, cones, contacts, fix, glow, needle, sticks, things };

const styleOf = (sensor) => STYLES[sensor.drawing?.style];

export const isDrawn = (sensor) => styleOf(sensor) !== undefined;

/** Whether each value of a sensor is how far it is to something along a beam. */
export const isRange = (sensor) => ["beams", "cones"].includes(sensor.drawing?.style);

/** Draw a sensor's readings from a pose; the brush is `{context, camera, theme, kind}`. */
export function drawReadings(brush, sensor, pose, values) {
  if (pose.every(Number.isFinite)) styleOf(sensor).draw(brush, sensor, pose, values);
}

/** The nearest part of a sensor's reading to a point, or null. */
export function nearestPart(sensor, pose, values, x, y, reach, scale) {
  return pose.every(Number.isFinite) ? styleOf(sensor).near(sensor, pose, values, x, y, reach, scale) : null;
}

/** What a part of a reading is and reads: `{title, lines}`. */
export function tellPart(sensor, reading, part) {
  const { title, lines } = styleOf(sensor).tell(sensor, reading, part);
  return { title, lines: reading.age > 0 ? [...lines, `${fixed(reading.age, 2)} s old`] : lines };
}
