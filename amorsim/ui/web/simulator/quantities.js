// Every quantity of the selected robot as true, measured, estimated: the rows of the table and the curves of the plot.

import { wrap } from "../shared/dom.js";
import { isRange } from "./readings.js";

const DEGREES = 180 / Math.PI;
/**
 * As much of a frame as quantities are made of.
 * @typedef {{
 *   time: number, truePoses: ArrayLike<number>, estimatedPoses: ArrayLike<number>, covariances: ArrayLike<number>,
 *   trueTwist: ArrayLike<number>, estimatedTwist: ArrayLike<number>, trueRates: ArrayLike<number>, measuredRates: ArrayLike<number>,
 *   sensors: {true: ArrayLike<number>, measured: ArrayLike<number>}[],
 * }} Moment
 */

/**
 * A row of the table. `of` gives what is true, measured, estimated and the difference.
 * @typedef {(frame: Moment, i: number) => number[]} Of
 * @typedef {{key: string, label: string, unit: string, decimals: number, of: Of, sigma?: (frame: Moment, i: number) => number}} Quantity
 */

export const KINDS = ["true", "measured", "estimated", "difference"];

/**
 * The quantities of a robot: `{key, label, unit, decimals, of(frame, i), sigma(frame, i)}`, where `of` gives `[true,
 * measured, estimated, difference]` with NaN for what there is not. The difference is estimated less true, or measured
 * less true of what nobody estimates. `sigma`, of what has a covariance, is the standard deviation that the robot
 * believes in.
 * @param {import("../shared/scene.js").Robot} robot
 */
export function quantitiesOf(robot) {
  const metres = robot.reach < 0.1 ? 4 : 3; // of a tabletop robot to a tenth of a millimetre
  const find = (/** @type {string} */ kind) => robot.sensors.findIndex((sensor) => sensor.kind === kind && sensor.size === 1);
  const [compass, gyro] = [find("compass"), find("gyro")];
  // A receiver at the base point measures the pose itself; elsewhere its readings are rows of their own.
  const gps = robot.sensors.findIndex(({ kind, mounts: [[x, y]] }) => kind === "gps" && x === 0 && y === 0);
  const fix = (/** @type {Moment} */ frame, /** @type {number} */ k) => (gps >= 0 ? (frame.sensors[gps]?.measured[k] ?? NaN) : NaN);
  const reading = (/** @type {Moment} */ frame, /** @type {number} */ s, /** @type {"true" | "measured"} */ which) => (s >= 0 ? (frame.sensors[s]?.[which][0] ?? NaN) : NaN);
  /** @type {Quantity[]} */
  const list = [
    {
      ...plain("x", named("x", robot, gps), "m", metres, (f, i) => [f.truePoses[3 * i], fix(f, 0), f.estimatedPoses[3 * i]]),
      sigma: (/** @type {Moment} */ f, /** @type {number} */ i) => Math.sqrt(f.covariances[6 * i]),
    },
    {
      ...plain("y", named("y", robot, gps), "m", metres, (f, i) => [f.truePoses[3 * i + 1], fix(f, 1), f.estimatedPoses[3 * i + 1]]),
      sigma: (/** @type {Moment} */ f, /** @type {number} */ i) => Math.sqrt(f.covariances[6 * i + 3]),
    },
    {
      ...angle("heading", named("heading", robot, compass), (f, i) => [
        f.truePoses[3 * i + 2],
        reading(f, compass, "measured"),
        f.estimatedPoses[3 * i + 2],
      ]),
      sigma: (/** @type {Moment} */ f, /** @type {number} */ i) => DEGREES * Math.sqrt(f.covariances[6 * i + 5]),
    },
    {
      key: "apart",
      label: "apart",
      unit: "m",
      decimals: metres,
      of: (/** @type {Moment} */ f, /** @type {number} */ i) => {
        const gap = Math.hypot(
          f.estimatedPoses[3 * i] - f.truePoses[3 * i],
          f.estimatedPoses[3 * i + 1] - f.truePoses[3 * i + 1],
        );
        return [NaN, NaN, believed(f.covariances, i), gap];
      },
    },
    plain("forward", "speed ahead", "m/s", metres, (f) => [f.trueTwist[0], NaN, f.estimatedTwist[0]]),
  ];
  if (robot.twist[1] > 0) {
    list.push(plain("left", "speed to the left", "m/s", metres, (f) => [f.trueTwist[1], NaN, f.estimatedTwist[1]]));
  }
  list.push(
    degrees("turn", named("turning", robot, gyro), "°/s", (f) => [
      f.trueTwist[2],
      reading(f, gyro, "measured"),
      f.estimatedTwist[2],
    ]),
  );
  robot.joints.forEach((joint, j) => {
    const label = joint.replaceAll("_", " ");
    list.push(plain(`joint.${joint}`, label, "rad/s", 3, (f) => [f.trueRates[j], f.measuredRates[j], NaN]));
  });
  robot.sensors.forEach((sensor, s) => {
    if (s === compass || s === gyro || s === gps) return;
    if (isRange(sensor)) {
      const least = (/** @type {ArrayLike<number> | undefined} */ values) => (values?.length ? Array.from(values).reduce((a, b) => (b < a || Number.isNaN(a) ? b : a)) : NaN);
      const of = (/** @type {Moment} */ f) => [least(f.sensors[s]?.true), least(f.sensors[s]?.measured), NaN];
      list.push(plain(`sensor.${sensor.name}`, `${sensor.name}, nearest`, sensor.unit, metres, of));
      return;
    }
    // Of a table its first line, which is that of the nearest thing; of many values the first.
    for (let k = 0; k < Math.min(sensor.size, sensor.columns.length || 8); k++) {
      const [name, unit] = sensor.columns[k] ?? [valueName(robot, sensor, k), sensor.unit];
      const of = (/** @type {Moment} */ f) => [f.sensors[s]?.true[k] ?? NaN, f.sensors[s]?.measured[k] ?? NaN, NaN];
      const key = `sensor.${sensor.name}.${k}`;
      const label = `${sensor.name} ${name}`.trim();
      if (unit === "rad") list.push(angle(key, label, of));
      else if (unit === "rad/s") list.push(degrees(key, label, "°/s", of));
      else list.push(plain(key, label, unit, ["m", "m/s", "m/s^2"].includes(unit) ? metres : 0, of));
    }
  });
  return list;
}

/** What a value of several is called: by the joint that is counted, or by its number.
 * @param {import("../shared/scene.js").Robot} robot
 * @param {import("./messages.d.ts").SensorShape} sensor
 * @param {number} k */
function valueName(robot, sensor, k) {
  if (sensor.size === 1) return "";
  return robot.joints.length === sensor.size ? robot.joints[k].replaceAll("_", " ") : String(k);
}

const named = (/** @type {string} */ label, /** @type {import("../shared/scene.js").Robot} */ robot, /** @type {number} */ sensor) => (sensor >= 0 ? `${label} (${robot.sensors[sensor].name})` : label);

const apart = (/** @type {number[]} */ [t, m, e]) => (Number.isNaN(e) ? m - t : e - t);

/** @param {string} key
 * @param {string} label
 * @param {string} unit
 * @param {number} decimals
 * @param {(frame: Moment, i: number) => number[]} of */
function plain(key, label, unit, decimals, of) {
  const whole = (/** @type {Moment} */ frame, /** @type {number} */ i) => {
    const three = of(frame, i);
    return [...three, apart(three)];
  };
  return { key, label, unit, decimals, of: whole };
}

/** @param {string} key
 * @param {string} label
 * @param {string} unit
 * @param {(frame: Moment, i: number) => number[]} of */
function degrees(key, label, unit, of) {
  return plain(key, label, unit, 2, (frame, i) => of(frame, i).map((value) => value * DEGREES));
}

/** Angles are shown in (-180, 180], and so is their difference.
 * @param {string} key
 * @param {string} label
 * @param {(frame: Moment, i: number) => number[]} of */
function angle(key, label, of) {
  const whole = (/** @type {Moment} */ frame, /** @type {number} */ i) => {
    const three = of(frame, i);
    return [...three.map(wrap), wrap(apart(three))].map((value) => value * DEGREES);
  };
  return { key, label, unit: "°", decimals: 2, of: whole };
}

/** How far off the robot believes to be with 95 %: the long half axis of its ellipse.
 * @param {ArrayLike<number>} covariances
 * @param {number} i */
function believed(covariances, i) {
  const [xx, xy, yy] = [covariances[6 * i], covariances[6 * i + 1], covariances[6 * i + 3]];
  return Math.sqrt(5.991 * Math.max((xx + yy) / 2 + Math.hypot((xx - yy) / 2, xy), 0));
}
