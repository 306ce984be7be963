// What is drawn of bodies and of what robots believe, in metres, on a context that the camera has set.

import { trace } from "./footprint.js";
import { DASHES } from "./theme.js";
import { px } from "./world_marks.js";

/** What a body is filled with: its own colour, if it has one; where it is estimated to be, paler. */
export const fillOf = (/** @type {{colour?: string}} */ body, /** @type {string} */ kind, /** @type {import("./theme.js").Theme} */ theme, otherwise = theme[`${kind}-fill`]) =>
  body.colour ? `${body.colour}${kind === "true" ? "b0" : "60"}` : otherwise;

/** Things in lists of those that have a key in common.
 * @param {number[]} things
 * @param {(thing: number) => string | undefined} key */
export function alikeBy(things, key) {
  const lists = new Map();
  for (const thing of things) {
    const of = key(thing);
    if (lists.has(of)) lists.get(of).push(thing);
    else lists.set(of, [thing]);
  }
  return [...lists.values()];
}

/** The selected robot: its footprint, wheels, and an arrow ahead.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./world_marks.js").Scaled} camera
 * @param {import("./scene.js").Robot} robot
 * @param {ArrayLike<number>} poses
 * @param {number} i
 * @param {string} kind
 * @param {import("./theme.js").Theme} theme
 * @param {boolean} alarm */
export function drawRobot(context, camera, robot, poses, i, kind, theme, alarm) {
  const [x, y, heading] = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
  if (!Number.isFinite(x) || !Number.isFinite(y)) return;
  context.beginPath();
  trace(context, robot.footprint, x, y, heading);
  context.fillStyle = fillOf(robot, kind, theme);
  context.fill();
  context.strokeStyle = alarm ? theme.danger : theme[kind];
  context.lineWidth = px(camera, alarm ? 2.5 : 2);
  context.setLineDash(DASHES[kind].map((d) => px(camera, d / 2)));
  context.stroke();
  context.setLineDash([]);
  context.save();
  context.translate(x, y);
  context.rotate(heading);
  context.fillStyle = theme[kind];
  for (const wheel of robot.wheels ?? []) {
    context.save();
    context.translate(wheel.x, wheel.y);
    context.rotate(wheel.heading ?? 0);
    context.fillRect(-wheel.radius, -wheel.width / 2, 2 * wheel.radius, wheel.width);
    context.restore();
  }
  const size = Math.max(0.7 * robot.waist, px(camera, 5));
  context.beginPath();
  context.moveTo(size, 0);
  context.lineTo(-0.35 * size, 0.5 * size);
  context.lineTo(-0.35 * size, -0.5 * size);
  context.closePath();
  context.fill();
  context.restore();
}

/** Obstacles and the parts of robots, where they truly are.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./world_marks.js").Scaled} camera
 * @param {import("../simulator/messages.d.ts").ObstacleShape[]} obstacles
 * @param {ArrayLike<number>} poses
 * @param {import("./theme.js").Theme} theme */
export function drawObstacles(context, camera, obstacles, poses, theme) {
  const places = obstacles.map((_, i) => i);
  for (const alike of alikeBy(places, (i) => `${obstacles[i].colour} ${Boolean(obstacles[i].part_of)}`)) {
    const first = obstacles[alike[0]];
    context.beginPath();
    for (const i of alike) trace(context, obstacles[i].footprint, poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]);
    context.fillStyle = fillOf(first, "true", theme, first.part_of ? theme["true-fill"] : theme.obstacle);
    context.fill();
    context.strokeStyle = first.part_of ? theme.true : theme.wall;
    context.lineWidth = px(camera, 1.5);
    context.stroke();
  }
}

/** The parts of the selected robot where it believes them to be; `poses` has three numbers for each.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./world_marks.js").Scaled} camera
 * @param {import("../simulator/messages.d.ts").ObstacleShape[]} parts
 * @param {ArrayLike<number>} poses
 * @param {import("./theme.js").Theme} theme */
export function drawBelievedParts(context, camera, parts, poses, theme) {
  context.beginPath();
  parts.forEach((part, i) => {
    const [x, y, heading] = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    if (Number.isFinite(x + y + heading)) trace(context, part.footprint, x, y, heading);
  });
  context.fillStyle = fillOf(parts[0] ?? {}, "estimated", theme);
  context.fill();
  context.strokeStyle = theme.estimated;
  context.lineWidth = px(camera, 1.5);
  context.setLineDash(DASHES.estimated.map((d) => px(camera, d / 2)));
  context.stroke();
  context.setLineDash([]);
}

/** The ellipse that holds the pose with 95 % (two degrees of freedom: 5.991), and the 95 % wedge of the heading.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./world_marks.js").Scaled} camera
 * @param {import("../simulator/mounts.js").Pose} pose
 * @param {import("../simulator/mounts.js").Pose} covariance
 * @param {import("./theme.js").Theme} theme */
export function drawEllipse(context, camera, pose, covariance, theme) {
  const [xx, xy, , yy, , hh] = covariance;
  if (!covariance.every(Number.isFinite) || !(xx >= 0 && yy >= 0)) return;
  const middle = (xx + yy) / 2;
  const apart = Math.hypot((xx - yy) / 2, xy);
  const long = Math.sqrt(5.991 * Math.max(middle + apart, 0));
  const short = Math.sqrt(5.991 * Math.max(middle - apart, 0));
  context.lineWidth = px(camera, 1.5);
  context.strokeStyle = theme.estimated;
  if (long * camera.scale > 1.5) {
    context.beginPath();
    context.ellipse(pose[0], pose[1], long, short, Math.atan2(2 * xy, xx - yy) / 2, 0, 2 * Math.PI);
    context.fillStyle = theme["estimated-fill"];
    context.fill();
    context.stroke();
  }
  const wedge = Math.min(1.96 * Math.sqrt(Math.max(hh, 0)), Math.PI);
  if (wedge > 0.01) {
    const far = Math.max(long, px(camera, 34));
    context.beginPath();
    context.moveTo(pose[0], pose[1]);
    context.arc(pose[0], pose[1], far, pose[2] - wedge, pose[2] + wedge);
    context.closePath();
    context.setLineDash([px(camera, 2), px(camera, 2)]);
    context.stroke();
    context.setLineDash([]);
  }
}

/** A path driven so far, from a ring of points (x0, y0, x1, y1, …); NaN lifts the pen.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./world_marks.js").Scaled} camera
 * @param {import("../simulator/trail.js").Trail} trail
 * @param {string} kind
 * @param {import("./theme.js").Theme} theme */
export function drawTrail(context, camera, trail, kind, theme) {
  if (trail.count < 2) return;
  context.beginPath();
  let down = false;
  trail.each((x, y) => {
    if (!Number.isFinite(x)) down = false;
    else if (down) context.lineTo(x, y);
    else {
      context.moveTo(x, y);
      down = true;
    }
  });
  context.strokeStyle = theme[kind];
  context.lineWidth = px(camera, 1.5);
  context.setLineDash(DASHES[kind].map((d) => px(camera, d)));
  context.stroke();
  context.setLineDash([]);
}
