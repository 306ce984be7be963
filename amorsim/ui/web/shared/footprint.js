// Footprints of bodies: a circle or a polygon.

import { there } from "./dom.js";

/** Add a footprint at a pose to the current path.
 * @param {CanvasRenderingContext2D} context
 * @param {import("../simulator/messages.d.ts").Outline} footprint
 * @param {number} x
 * @param {number} y
 * @param {number} heading */
export function trace(context, footprint, x, y, heading) {
  if (footprint.circle) {
    context.moveTo(x + footprint.circle, y);
    context.arc(x, y, footprint.circle, 0, 2 * Math.PI);
    return;
  }
  const c = Math.cos(heading);
  const s = Math.sin(heading);
  let first = true;
  for (const [u, v] of there(footprint.polygon)) {
    const px_ = x + u * c - v * s;
    const py_ = y + u * s + v * c;
    if (first) context.moveTo(px_, py_);
    else context.lineTo(px_, py_);
    first = false;
  }
  context.closePath();
}

/** Half of how wide a footprint is. */
export const waist = (/** @type {import("../simulator/messages.d.ts").Outline} */ footprint) => footprint.circle ?? Math.max(...there(footprint.polygon).map(([, v]) => Math.abs(v)));

/** How far a footprint goes from its base point. */
export const reach = (/** @type {import("../simulator/messages.d.ts").Outline | null} */ footprint) =>
  there(footprint).circle ?? Math.max(...there(there(footprint).polygon).map(([u, v]) => Math.hypot(u, v)));
