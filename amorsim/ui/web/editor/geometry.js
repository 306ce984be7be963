// Plane geometry for drawing: where a pointer snaps to, and what lies in a box. Pure functions.

import { there } from "../shared/dom.js";
import { SpatialIndex } from "../shared/spatial.js";

/** @typedef {{x: number, y: number, kind: string}} Snapped a point, and what it snapped to: "end", "middle", "wall", "grid" or "" */

const REACH = 10; // pixels
const TURN = Math.PI / 12; // 15°

/** A length [m] in whole tenths of a millimetre, so that files say round numbers. */
export const round = (/** @type {number} */ value) => Math.round(value * 1e4) / 1e4 + 0;

/** The foot of the perpendicular from a point on a wall, kept between the wall's ends.
 * @param {number[]} wall
 * @param {number} x
 * @param {number} y */
export function footOn([x0, y0, x1, y1], x, y) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = dx * dx + dy * dy;
  const part = length > 0 ? Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / length)) : 0;
  return [x0 + part * dx, y0 + part * dy];
}

/** Where two walls cross, or null.
 * @param {number[]} one
 * @param {number[]} other */
export function crossing([a, b, c, d], [e, f, g, h]) {
  const det = (c - a) * (h - f) - (d - b) * (g - e);
  if (Math.abs(det) < 1e-12) return null;
  const s = ((e - a) * (h - f) - (f - b) * (g - e)) / det;
  const t = ((e - a) * (d - b) - (f - b) * (c - a)) / det;
  return s >= 0 && s <= 1 && t >= 0 && t <= 1 ? [a + s * (c - a), b + s * (d - b)] : null;
}

/** Finds walls, and what a pointer snaps to. */
export class Walls {
  /** @param {number[][]} walls
   * @param {number[]} extent */
  constructor(walls, [x0, y0, x1, y1]) {
    this.walls = walls;
    /** @type {SpatialIndex<number>} */
    this.index = new SpatialIndex(Math.max(x1 - x0, y1 - y0, 1e-3) / 64);
    walls.forEach(([a, b, c, d], n) => this.index.addLine(n, a, b, c, d));
  }

  /** The nearest wall within a reach [m], or -1.
   * @param {number} x
   * @param {number} y
   * @param {number} reach */
  nearest(x, y, reach) {
    let [best, least] = [-1, reach];
    for (const n of this.index.near(x, y, reach)) {
      const [u, v] = footOn(this.walls[n], x, y);
      const gap = Math.hypot(u - x, v - y);
      if (gap <= least) [best, least] = [n, gap];
    }
    return best;
  }

  /** How far the nearest wall is [m]; infinity where there is none.
   * @param {number} x
   * @param {number} y */
  clearance(x, y) {
    let least = Infinity;
    for (const wall of this.walls) {
      const [u, v] = footOn(wall, x, y);
      least = Math.min(least, Math.hypot(u - x, v - y));
    }
    return least;
  }

  /**
   * Where a point snaps to: an end, a crossing, a middle, a wall, or the grid.
   * @param {{x: number, y: number}} point
   * @param {{scale: number, grid: number, from?: number[] | null, isTurned?: boolean, isFree?: boolean}} how `grid` 0 for none; `from` is where the
   *   line began, whose angle snaps to 15° where `isTurned`; `isFree` snaps to nothing
   * @returns {Snapped}
   */
  snap({ x, y }, { scale, grid, from = null, isTurned = false, isFree = false }) {
    if (isFree) return { x: round(x), y: round(y), kind: "" };
    if (isTurned && from) {
      const angle = Math.round(Math.atan2(y - from[1], x - from[0]) / TURN) * TURN;
      const length = Math.hypot(x - from[0], y - from[1]);
      const whole = grid ? Math.round(length / grid) * grid : length;
      return { x: round(from[0] + whole * Math.cos(angle)), y: round(from[1] + whole * Math.sin(angle)), kind: "angle" };
    }
    const reach = REACH / scale;
    const near = [...this.index.near(x, y, reach)].slice(0, 60).map((n) => this.walls[n]);
    const points = near.flatMap(([a, b, c, d]) => [[a, b, "end"], [c, d, "end"], [(a + c) / 2, (b + d) / 2, "middle"]]);
    near.forEach((one, n) => near.slice(n + 1).forEach((other) => {
      const point = crossing(one, other);
      if (point) points.push([point[0], point[1], "crossing"]);
    }));
    if (from) {
      for (const wall of near) {
        const [u, v] = footOn(wall, from[0], from[1]);
        points.push([u, v, "perpendicular"]);
      }
    }
    let best = null;
    let least = reach;
    for (const [u, v, kind] of points) {
      const gap = Math.hypot(Number(u) - x, Number(v) - y);
      const rank = gap * (kind === "end" ? 0.7 : 1);
      if (gap <= reach && rank <= least) [best, least] = [{ x: round(Number(u)), y: round(Number(v)), kind: String(kind) }, rank];
    }
    if (best) return best;
    const onGrid = grid ? { x: round(Math.round(x / grid) * grid), y: round(Math.round(y / grid) * grid), kind: "grid" } : { x: round(x), y: round(y), kind: "" };
    const n = this.nearest(x, y, 0.6 * reach);
    if (n < 0 || Math.hypot(onGrid.x - x, onGrid.y - y) * scale < 4) return onGrid;
    const [u, v] = footOn(this.walls[n], x, y);
    return { x: round(u), y: round(v), kind: "wall" };
  }
}

/** Whether a wall lies in a box wholly.
 * @param {number[]} wall
 * @param {number[]} box x0, y0, x1, y1 */
export const isIn = ([a, b, c, d], [x0, y0, x1, y1]) =>
  Math.min(a, c) >= x0 && Math.max(a, c) <= x1 && Math.min(b, d) >= y0 && Math.max(b, d) <= y1;

/** The box about a footprint at a pose: x0, y0, x1, y1.
 * @param {import("../simulator/messages.d.ts").Outline} footprint
 * @param {number[]} pose */
export function boxOf(footprint, [x, y, heading]) {
  if (footprint.circle) return [x - footprint.circle, y - footprint.circle, x + footprint.circle, y + footprint.circle];
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const polygon = there(footprint.polygon);
  const [xs, ys] = [polygon.map(([u, v]) => x + u * c - v * s), polygon.map(([u, v]) => y + u * s + v * c)];
  return [Math.min(...xs), Math.min(...ys), Math.max(...xs), Math.max(...ys)];
}

/** Whether a point is within a footprint at a pose.
 * @param {import("../simulator/messages.d.ts").Outline} footprint
 * @param {number[]} pose
 * @param {number} x
 * @param {number} y */
export function holds(footprint, [px, py, heading], x, y) {
  const [dx, dy] = [x - px, y - py];
  if (footprint.circle) return Math.hypot(dx, dy) <= footprint.circle;
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  const [u, v] = [dx * c + dy * s, dy * c - dx * s];
  let isInside = false;
  const points = there(footprint.polygon);
  points.forEach(([xi, yi], i) => {
    const [xj, yj] = points[(i + points.length - 1) % points.length];
    if (yi > v !== yj > v && u < ((xj - xi) * (v - yi)) / (yj - yi) + xi) isInside = !isInside;
  });
  return isInside;
}

/** A wall's length and direction in words.
 * @param {number[]} wall */
export function wordsOf([a, b, c, d]) {
  const angle = (Math.atan2(d - b, c - a) * 180) / Math.PI;
  return `${Math.hypot(c - a, d - b).toFixed(3).replace(/0$/, "")} m, ${angle.toFixed(1).replace(/\.0$/, "").replace("-", "−")}°`;
}
