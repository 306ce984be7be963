// What is drawn in the world: each function draws one kind of thing, in metres, on a context that the camera has set.

import { context2d, there } from "./dom.js";
import { trace } from "./footprint.js";
import { DASHES } from "./theme.js";

/** As much of a camera as is drawn with: its pixels a metre. @typedef {{scale: number}} Scaled */
/** @typedef {HTMLImageElement | HTMLCanvasElement} Picture */

/** A line width of so many CSS pixels, in metres. */
const px = (/** @type {Scaled} */ camera, /** @type {number} */ pixels) => pixels / camera.scale;

/** Walls as one path, made once a scene.
 * @param {import("../simulator/wire.js").MapShape | null | undefined} map */
export function wallPath(map) {
  const path = new Path2D();
  for (const [x0, y0, x1, y1] of map?.segments ?? []) {
    path.moveTo(x0, y0);
    path.lineTo(x1, y1);
  }
  return path;
}

/** Draw a map: its lines, or its picture of cells, which has the wall's colour already.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {import("../simulator/wire.js").MapShape | null | undefined} map
 * @param {Path2D | undefined} path
 * @param {Picture[] | null | undefined} levels
 * @param {string} colour */
export function drawMap(context, camera, map, path, levels, colour) {
  if (!map) return;
  if (levels) {
    const [x0, y0, x1, y1] = there(map.image).extent;
    context.save();
    context.translate(map.origin[0], map.origin[1]);
    context.rotate(map.origin[2]);
    context.translate(x0, y1);
    context.scale(1, -1);
    const wide = camera.scale * (x1 - x0) * (window.devicePixelRatio || 1);
    const picture = levels.findLast((level) => level.width >= wide) ?? levels[0];
    context.imageSmoothingEnabled = wide < picture.width;
    context.drawImage(picture, 0, 0, x1 - x0, y1 - y0);
    context.restore();
    return;
  }
  context.strokeStyle = colour;
  context.lineWidth = Math.max(px(camera, 2), 0.001);
  context.lineCap = "square";
  context.setLineDash([]);
  context.stroke(there(path));
  context.lineCap = "butt";
}

/** A picture of occupied cells in a colour, and smaller ones of it: each half as wide, with walls as strong as before.
 * @param {Picture} picture
 * @param {string} colour */
export function tinted(picture, colour) {
  const levels = [coloured(picture, colour)];
  for (let last = levels[0]; last.width > 200; last = levels[levels.length - 1]) {
    const canvas = document.createElement("canvas");
    canvas.width = Math.ceil(last.width / 2);
    canvas.height = Math.ceil(last.height / 2);
    const context = context2d(canvas);
    // Half of a thin wall is clear after halving; drawn again and again it is nearly full.
    for (let n = 0; n < 3; n++) context.drawImage(last, 0, 0, last.width / 2, last.height / 2);
    levels.push(canvas);
  }
  return levels;
}

/** A picture with all that is opaque in a colour.
 * @param {Picture} picture
 * @param {string} colour */
export function coloured(picture, colour) {
  const canvas = document.createElement("canvas");
  canvas.width = "naturalWidth" in picture ? picture.naturalWidth : picture.width;
  canvas.height = "naturalHeight" in picture ? picture.naturalHeight : picture.height;
  const context = context2d(canvas);
  context.drawImage(picture, 0, 0);
  context.globalCompositeOperation = "source-in";
  context.fillStyle = colour;
  context.fillRect(0, 0, canvas.width, canvas.height);
  return canvas;
}

/** @param {CanvasRenderingContext2D} context
 * @param {import("./camera.js").Camera} camera
 * @param {number} step
 * @param {string} colour */
export function drawGrid(context, camera, step, colour) {
  const [x0, y0, x1, y1] = camera.bounds();
  context.beginPath();
  for (let x = Math.ceil(x0 / step) * step; x <= x1; x += step) {
    context.moveTo(x, y0);
    context.lineTo(x, y1);
  }
  for (let y = Math.ceil(y0 / step) * step; y <= y1; y += step) {
    context.moveTo(x0, y);
    context.lineTo(x1, y);
  }
  context.strokeStyle = colour;
  context.lineWidth = px(camera, 1);
  context.setLineDash([]);
  context.stroke();
}

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
 * @param {Scaled} camera
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

/** Markings and drops of the floor, and its zones: what lies under the walls.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {import("../simulator/wire.js").Floor} floor
 * @param {import("./theme.js").Theme} theme */
export function drawFloor(context, camera, floor, theme) {
  for (const { points, width, colour } of floor.patches ?? []) {
    context.beginPath();
    for (const [x, y] of points) context.lineTo(x, y);
    context.fillStyle = context.strokeStyle = colour;
    context.lineWidth = Math.max(width, px(camera, 1));
    context.lineCap = context.lineJoin = "round";
    if (width > 0) context.stroke();
    else context.fill();
  }
  context.lineCap = "butt";
  context.lineJoin = "miter";
  for (const zone of floor.zones) {
    context.beginPath();
    trace(context, { polygon: zone }, 0, 0, 0);
    context.fillStyle = theme.grid;
    context.fill();
    context.strokeStyle = theme.line;
    context.lineWidth = px(camera, 1);
    context.stroke();
  }
}

/** Lamps and landmarks, as they truly are.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {import("../simulator/wire.js").Floor} floor
 * @param {import("./theme.js").Theme} theme */
export function drawStanding(context, camera, floor, theme) {
  for (const [x, y] of floor.lights) {
    const size = px(camera, 7);
    context.beginPath();
    for (let n = 0; n < 8; n++) {
      const [c, s] = [Math.cos((n * Math.PI) / 4), Math.sin((n * Math.PI) / 4)];
      context.moveTo(x + 0.4 * size * c, y + 0.4 * size * s);
      context.lineTo(x + size * c, y + size * s);
    }
    context.strokeStyle = theme.soft;
    context.lineWidth = px(camera, 1.5);
    context.stroke();
  }
  drawMarks(context, camera, floor.landmarks, theme.wall);
}

/** Landmarks as diamonds: of the world, or those that a robot knows.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {number[][]} marks
 * @param {string} colour */
export function drawMarks(context, camera, marks, colour) {
  context.beginPath();
  for (const [x, y, radius] of marks) {
    const size = Math.max(radius ?? 0, px(camera, 5));
    context.moveTo(x + size, y);
    context.lineTo(x, y + size);
    context.lineTo(x - size, y);
    context.lineTo(x, y - size);
    context.closePath();
  }
  context.strokeStyle = colour;
  context.lineWidth = px(camera, 1.5);
  context.stroke();
}

/** Obstacles and the parts of robots, where they truly are.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {import("../simulator/wire.js").ObstacleShape[]} obstacles
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
 * @param {Scaled} camera
 * @param {import("../simulator/wire.js").ObstacleShape[]} parts
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
 * @param {Scaled} camera
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
 * @param {Scaled} camera
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
