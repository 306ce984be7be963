// What is drawn of the world itself: maps, the grid, the floor and what stands on it, in metres, on a context that the camera has set.

import { context2d, there } from "./dom.js";
import { trace } from "./footprint.js";

/** As much of a camera as is drawn with: its pixels a metre. @typedef {{scale: number}} Scaled */
/** @typedef {HTMLImageElement | HTMLCanvasElement} Picture */

/** A line width of so many CSS pixels, in metres. */
export const px = (/** @type {Scaled} */ camera, /** @type {number} */ pixels) => pixels / camera.scale;

/** Walls as one path, made once a scene.
 * @param {import("../simulator/messages.d.ts").MapShape | null | undefined} map */
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
 * @param {import("../simulator/messages.d.ts").MapShape | null | undefined} map
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

/** Markings and drops of the floor, and its zones: what lies under the walls.
 * @param {CanvasRenderingContext2D} context
 * @param {Scaled} camera
 * @param {import("../simulator/messages.d.ts").Floor} floor
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
 * @param {import("../simulator/messages.d.ts").Floor} floor
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
