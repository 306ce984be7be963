// The past of a robot as the session tells it (see `Past` in `amorsim/ui/simulator/frames/protocol.py`), as moments that read like frames.

import { isRange } from "./readings.js";

const FIRST = 8;

/**
 * Moments `{time, truePoses, ...}` of a history, in order: all that is kept of the robot, and where that has gaps the
 * poses alone, with NaN for the rest.
 * @param {Pick<import("./messages.d.ts").History, "past" | "ticks" | "true" | "estimated">} history
 * @param {import("../shared/scene.js").Robot} robot
 * @param {number} dt
 */
export function momentsOf(history, robot, dt) {
  const { ticks, lines } = linesOf(history.past);
  const moments = ticks.map((tick, n) => ({ tick, moment: whole(lines[n], robot, tick * dt) }));
  const far = Math.max(1, ...history.ticks.slice(1).map((tick, n) => tick - history.ticks[n])) * 4;
  let next = 0; // the first of those that are kept at or after a tick
  history.ticks.forEach((tick, n) => {
    while (next < ticks.length && ticks[next] < tick) next++;
    const near = Math.min(...[ticks[next - 1], ticks[next]].map((kept) => Math.abs((kept ?? Infinity) - tick)));
    if (near > far || !ticks.length) moments.push({ tick, moment: bare(history.true[n].map((value) => value ?? NaN), history.estimated[n], robot, tick * dt) });
  });
  return moments.sort((one, other) => one.tick - other.tick).map(({ moment }) => moment);
}

/** @param {import("./messages.d.ts").Past} past */
function linesOf({ ticks, values }) {
  const bytes = Uint8Array.from(atob(values), (letter) => letter.charCodeAt(0));
  const all = new Float64Array(bytes.buffer);
  const width = ticks.length ? all.length / ticks.length : 0;
  return { ticks, lines: ticks.map((_, n) => all.subarray(n * width, (n + 1) * width)) };
}

/** @param {Float64Array} line
 * @param {import("../shared/scene.js").Robot} robot
 * @param {number} time
 * @returns {import("./quantities.js").Moment} */
function whole(line, robot, time) {
  let at = 0;
  const take = (/** @type {number} */ count) => line.subarray(at, (at += count));
  const joints = robot.joints.length;
  const kept = {
    time,
    truePoses: take(3),
    estimatedPoses: take(3),
    covariances: take(6),
    trueTwist: take(3),
    estimatedTwist: take(3),
    trueRates: take(joints),
    measuredRates: take(joints),
  };
  const first = robot.sensors.map((sensor) => Math.min(sensor.size, sensor.columns.length || FIRST));
  const [trueFirst, measuredFirst] = [0, 1].map(() => first.map(take));
  const [trueLeast, measuredLeast] = [0, 1].map(() => robot.sensors.map((sensor) => take(Math.min(sensor.size, 1))));
  const sensors = robot.sensors.map((sensor, s) =>
    isRange(sensor)
      ? { true: trueLeast[s], measured: measuredLeast[s] }
      : { true: trueFirst[s], measured: measuredFirst[s] },
  );
  return { ...kept, sensors };
}

/** @param {ArrayLike<number>} truth
 * @param {ArrayLike<number>} estimated
 * @param {import("../shared/scene.js").Robot} robot
 * @param {number} time
 * @returns {import("./quantities.js").Moment} */
function bare(truth, estimated, robot, time) {
  const none = [NaN, NaN, NaN];
  return {
    time,
    truePoses: truth,
    estimatedPoses: estimated,
    covariances: [...none, ...none],
    trueTwist: none,
    estimatedTwist: none,
    trueRates: robot.joints.map(() => NaN),
    measuredRates: robot.joints.map(() => NaN),
    sensors: [],
  };
}
