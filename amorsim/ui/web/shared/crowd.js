// All robots but the selected one, where they truly are. Small ones are stamped from pictures drawn once for each of some headings: a thousand
// outlines a frame would take longer than a frame has.

import { context2d, there } from "./dom.js";
import { trace } from "./footprint.js";
import { alikeBy, fillOf } from "./marks.js";

const HEADINGS = 90;
const SMALL = 26; // pixels of a robot's radius, up to which it is stamped

/** Draw robots at their true `poses`, those in sight but `skip`.
 * @param {CanvasRenderingContext2D} context
 * @param {import("./camera.js").Camera} camera
 * @param {number} ratio
 * @param {import("./scene.js").Robot[]} robots
 * @param {Float32Array} poses
 * @param {number} skip the one that is not drawn
 * @param {import("./theme.js").Theme} theme */
export function drawCrowd(context, camera, ratio, robots, poses, skip, theme) {
  if (robots.length < 2) return;
  const [x0, y0, x1, y1] = camera.bounds();
  /** @type {number[]} */
  const large = [];
  context.save();
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.imageSmoothingEnabled = false;
  for (let i = 0; i < robots.length; i++) {
    const [x, y, size] = [poses[3 * i], poses[3 * i + 1], robots[i].reach];
    if (i === skip || !(x > x0 - size && x < x1 + size && y > y0 - size && y < y1 + size)) continue;
    if (size * camera.scale > SMALL) {
      large.push(i);
      continue;
    }
    const sheet = stamps(robots[i], camera.scale * ratio, ratio, theme);
    const turn = Math.round((poses[3 * i + 2] / (2 * Math.PI)) * HEADINGS);
    const at = (((turn % HEADINGS) + HEADINGS) % HEADINGS) * sheet.side;
    const [left, top] = camera.toScreen(x, y);
    const half = sheet.side / 2;
    context.drawImage(
      sheet.canvas, at, 0, sheet.side, sheet.side,
      Math.round(left * ratio - half), Math.round(top * ratio - half), sheet.side, sheet.side,
    );
  }
  context.restore();
  // Those of one colour as one path.
  for (const alike of alikeBy(large, (i) => robots[i].colour)) {
    outline(context, camera.scale, alike.map((/** @type {number} */ i) => [robots[i], poses.subarray(3 * i, 3 * i + 3)]), theme);
  }
}

/** @param {CanvasRenderingContext2D} context
 * @param {number} scale
 * @param {[Drawn, import("../simulator/mounts.js").Pose][]} robots
 * @param {import("./theme.js").Theme} theme */
function outline(context, scale, robots, theme) {
  context.beginPath();
  for (const [{ footprint, reach }, [x, y, heading]] of robots) {
    trace(context, footprint, x, y, heading);
    context.moveTo(x, y);
    context.lineTo(x + 0.8 * reach * Math.cos(heading), y + 0.8 * reach * Math.sin(heading));
  }
  context.fillStyle = fillOf(robots[0][0], "true", theme);
  context.fill();
  context.strokeStyle = theme.true;
  context.lineWidth = 1 / scale;
  context.stroke();
}

/** As much of a robot as is drawn of it. @typedef {Pick<import("./scene.js").Robot, "footprint" | "reach" | "colour">} Drawn */
/** @typedef {{canvas: HTMLCanvasElement, side: number, scale: number, ink: string}} Sheet */

/** By footprint, and by colour. @type {Map<import("../simulator/messages.d.ts").Outline, Record<string, Sheet>>} */
const sheets = new Map();

/** Pictures of a footprint at all headings, side by side; `scale` in device pixels a metre.
 * @param {Drawn} robot
 * @param {number} scale
 * @param {number} ratio
 * @param {import("./theme.js").Theme} theme */
function stamps({ footprint, reach, colour }, scale, ratio, theme) {
  const kept = sheets.get(footprint)?.[colour ?? ""];
  if (kept && kept.scale === scale && kept.ink === theme.true) return kept;
  const side = 2 * Math.ceil(Math.max(reach * scale, 1.5 * ratio) + 1);
  const canvas = document.createElement("canvas");
  canvas.width = side * HEADINGS;
  canvas.height = side;
  const context = context2d(canvas);
  for (let n = 0; n < HEADINGS; n++) {
    if (reach * scale < 3 * ratio) {
      context.fillStyle = colour ?? theme.true;
      context.fillRect(n * side + side / 2 - 1, side / 2 - 1, 2, 2);
      continue;
    }
    context.setTransform(scale, 0, 0, -scale, n * side + side / 2, side / 2);
    outline(context, scale / ratio, [[{ footprint, reach, colour }, [0, 0, (2 * Math.PI * n) / HEADINGS]]], theme);
  }
  const sheet = { canvas, side, scale, ink: theme.true };
  sheets.set(footprint, { ...sheets.get(footprint), [colour ?? ""]: sheet });
  if (sheets.size > 64) sheets.delete(there(sheets.keys().next().value));
  return sheet;
}
