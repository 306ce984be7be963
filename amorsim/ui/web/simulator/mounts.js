// Where sensors sit on a robot, and where their tables have what.

/** A pose: x, y [m] and heading [rad]. @typedef {number[] | Float32Array | Float64Array} Pose */

/** A point of the robot's frame in the world of a robot at `pose`.
 * @param {Pose} pose
 * @param {number} u
 * @param {number} v */
export function toWorld(pose, u, v) {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  return [pose[0] + u * c - v * s, pose[1] + u * s + v * c];
}

/** World poses of a sensor's mounts on a robot at `pose`, one a value (a ring) or one for all (a scan).
 * @param {import("./messages.d.ts").SensorShape} sensor
 * @param {Pose} pose */
export function mountPoses(sensor, pose) {
  return sensor.mounts.map(([u, v, heading]) => [...toWorld(pose, u, v), pose[2] + heading]);
}

/** Which column of a sensor's table has a name; -1 for none. */
export const columnOf = (/** @type {import("./messages.d.ts").SensorShape} */ sensor, /** @type {string} */ name) => sensor.columns.findIndex(([column]) => column === name);
