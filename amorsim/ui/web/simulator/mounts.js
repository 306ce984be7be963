// Where sensors sit on a robot, and where their tables have what.

/** A point of the robot's frame in the world of a robot at `pose`. */
export function toWorld(pose, u, v) {
  const [c, s] = [Math.cos(pose[2]), Math.sin(pose[2])];
  return [pose[0] + u * c - v * s, pose[1] + u * s + v * c];
}

/** World poses of a sensor's mounts on a robot at `pose`, one a value (a ring) or one for all (a scan). */
export function mountPoses(sensor, pose) {
  return sensor.mounts.map(([u, v, heading]) => [...toWorld(pose, u, v), pose[2] + heading]);
}

/** Which column of a sensor's table has a name; -1 for none. */
export const columnOf = (sensor, name) => sensor.columns.findIndex(([column]) => column === name);

/** How far the point (x, y) is from the line from (x0, y0) to (x1, y1). */
export function gapToLine(x, y, x0, y0, x1, y1) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = dx * dx + dy * dy;
  const part = length > 0 ? Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / length)) : 0;
  return Math.hypot(x0 + part * dx - x, y0 + part * dy - y);
}
