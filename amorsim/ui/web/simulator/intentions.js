// How intentions are drawn: paths, searched places, arcs, sectors, free ways and velocities. The context is in metres.

/** @typedef {import("./messages.d.ts").IntendedArc} Arc */
/** @typedef {import("./messages.d.ts").IntendedVelocities} Velocities */
/** @typedef {{scale: number}} Camera */
/** @typedef {import("../shared/theme.js").Theme} Theme */

const DOT = 3; // pixels
const SHADES = 5; // of what was searched
const RING = [26, 9]; // pixels: the least inner radius of the sectors' ring, and its width
const TOP_SPEED = 64; // pixels that stand for a robot's top speed

/** Places that were searched, from pale to dark.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {number[][]} places */
export function drawSearched(context, camera, theme, places) {
  const size = DOT / camera.scale;
  context.fillStyle = theme.estimated;
  places.forEach(([x, y], k) => {
    context.globalAlpha = 0.12 + (0.3 * Math.floor((SHADES * k) / places.length)) / SHADES;
    context.fillRect(x - size / 2, y - size / 2, size, size);
  });
  context.globalAlpha = 1;
}

/** A path, with a ring at its end.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {number[][]} path */
export function drawPath(context, camera, theme, path) {
  if (!path.length) return;
  context.strokeStyle = theme.estimated;
  context.lineWidth = 2 / camera.scale;
  line(context, path);
  const [x, y] = path[path.length - 1];
  context.beginPath();
  context.arc(x, y, 5 / camera.scale, 0, 2 * Math.PI);
  context.stroke();
}

/** Arcs: the better, the darker; refused ones red, and the one taken in full.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {Arc[]} arcs */
export function drawArcs(context, camera, theme, arcs) {
  for (const { points, worth, taken } of arcs) {
    context.strokeStyle = taken ? theme.ink : worth < 0 ? theme.danger : theme.estimated;
    context.globalAlpha = taken ? 1 : worth < 0 ? 0.35 : 0.12 + 0.5 * worth * worth;
    context.lineWidth = (taken ? 2.5 : 1) / camera.scale;
    line(context, points);
  }
  context.globalAlpha = 1;
}

/** Sectors as a ring around the robot, the blocked ones red, and the direction taken.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {number[]} pose
 * @param {number} reach of the robot [m]
 * @param {boolean[]} blocked
 * @param {number[]} bearing */
export function drawSectors(context, camera, theme, [x, y, heading], reach, blocked, bearing) {
  const inner = Math.max(1.25 * reach, RING[0] / camera.scale);
  const outer = inner + RING[1] / camera.scale;
  const each = (2 * Math.PI) / blocked.length;
  for (const [kind, colour, alpha] of /** @type {[boolean, string, number][]} */ ([
    [false, theme.estimated, 0.15],
    [true, theme.danger, 0.55],
  ])) {
    context.fillStyle = colour;
    context.globalAlpha = alpha;
    context.beginPath();
    for (let k = 0; k < blocked.length; ) {
      if (blocked[k] !== kind) {
        k += 1;
        continue;
      }
      let end = k;
      while (end < blocked.length && blocked[end] === kind) end += 1;
      const [from, to] = [heading - Math.PI + k * each, heading - Math.PI + end * each];
      context.moveTo(x + inner * Math.cos(from), y + inner * Math.sin(from));
      context.arc(x, y, outer, from, to);
      context.arc(x, y, inner, to, from, true);
      context.closePath();
      k = end;
    }
    context.fill();
  }
  context.globalAlpha = 1;
  if (!bearing.length) return;
  const far = outer + 6 / camera.scale;
  context.strokeStyle = theme.ink;
  context.lineWidth = 2 / camera.scale;
  line(context, [
    [x, y],
    [x + far * Math.cos(heading + bearing[0]), y + far * Math.sin(heading + bearing[0])],
  ]);
}

/** How far the way is free in each direction.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {number[]} pose
 * @param {number[][]} ways */
export function drawWays(context, camera, theme, [x, y, heading], ways) {
  if (!ways.length) return;
  const sorted = [...ways].sort(([a], [b]) => a - b);
  const ends = sorted.map(([bend, way]) => [x + way * Math.cos(heading + bend), y + way * Math.sin(heading + bend)]);
  context.strokeStyle = theme.estimated;
  context.lineWidth = 1 / camera.scale;
  context.fillStyle = theme["estimated-fill"];
  line(context, [[x, y], ...ends, [x, y]]);
  context.fill();
}

/** The others, as far as the robot knows them; and around it the velocities up to its top speed, what it may not do red.
 * @param {CanvasRenderingContext2D} context
 * @param {Camera} camera
 * @param {Theme} theme
 * @param {number[]} pose
 * @param {Velocities} velocities */
export function drawVelocities(context, camera, theme, [x, y, heading], { speed, twist, others, borders, cones }) {
  if (!twist.length) return;
  context.save();
  context.translate(x, y);
  context.rotate(heading);
  context.strokeStyle = theme.measured;
  context.lineWidth = 1.5 / camera.scale;
  for (const [ox, oy, vx, vy, radius] of others) {
    context.beginPath();
    context.arc(ox, oy, radius, 0, 2 * Math.PI);
    context.moveTo(ox, oy);
    context.lineTo(ox + vx, oy + vy); // where it is in a second
    context.stroke();
  }
  if (borders.length || cones.length) {
    const scale = TOP_SPEED / (camera.scale * speed); // metres of the picture for one of a second
    context.scale(scale, scale);
    const pixel = 1 / (camera.scale * scale);
    const whole = new Path2D();
    whole.arc(0, 0, speed, 0, 2 * Math.PI);
    context.save();
    context.clip(whole);
    context.fillStyle = theme.danger;
    context.globalAlpha = 0.14;
    const far = 8 * speed;
    for (const [px, py, dx, dy] of borders) halfPlane(context, px, py, dx, dy, far);
    for (const [ax, ay, rx, ry, lx, ly] of cones) {
      const reach = far + Math.hypot(ax, ay);
      context.beginPath();
      context.moveTo(ax, ay);
      context.lineTo(ax + reach * rx, ay + reach * ry);
      context.lineTo(ax + reach * (rx + lx), ay + reach * (ry + ly));
      context.lineTo(ax + reach * lx, ay + reach * ly);
      context.fill();
    }
    context.restore();
    context.strokeStyle = theme.soft;
    context.lineWidth = pixel;
    context.stroke(whole);
    context.strokeStyle = theme.ink;
    context.lineWidth = 2.5 * pixel;
    line(context, [
      [0, 0],
      [twist[0], 0],
    ]);
  }
  context.restore();
}

/** Fill what lies to the right of a line, as far as `far`.
 * @param {CanvasRenderingContext2D} context
 * @param {number} px
 * @param {number} py
 * @param {number} dx
 * @param {number} dy
 * @param {number} far */
function halfPlane(context, px, py, dx, dy, far) {
  // From the foot of the origin, so that the rectangle covers the circle of the top speed wherever the point lies.
  const along = -(px * dx + py * dy);
  const [fx, fy] = [px + along * dx, py + along * dy];
  const deep = far + Math.hypot(fx, fy);
  context.beginPath();
  context.moveTo(fx - far * dx, fy - far * dy);
  context.lineTo(fx + far * dx, fy + far * dy);
  context.lineTo(fx + far * dx + deep * dy, fy + far * dy - deep * dx);
  context.lineTo(fx - far * dx + deep * dy, fy - far * dy - deep * dx);
  context.fill();
}

/** @param {CanvasRenderingContext2D} context
 * @param {number[][]} points */
function line(context, points) {
  context.beginPath();
  points.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
}
