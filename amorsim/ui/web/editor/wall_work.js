// What can be made of walls that are there: cut, split, joined, trimmed, moved aside. Pure functions on [x0, y0, x1, y1] in metres.

import { crossing, footOn, round } from "./geometry.js";

const LEAST = 0.001; // [m], the shortest wall that is kept
const SAME = 1e-6; // [m]

/** @param {number[]} wall */
export const lengthOf = ([a, b, c, d]) => Math.hypot(c - a, d - b);

/** The point of a wall at a distance [m] from its beginning.
 * @param {number[]} wall
 * @param {number} along */
export function pointAt(wall, along) {
  const part = along / lengthOf(wall);
  return [round(wall[0] + part * (wall[2] - wall[0])), round(wall[1] + part * (wall[3] - wall[1]))];
}

/** How far along a wall [m] the foot of a point is.
 * @param {number[]} wall
 * @param {number} x
 * @param {number} y */
export function alongOf(wall, x, y) {
  const [u, v] = footOn(wall, x, y);
  return Math.hypot(u - wall[0], v - wall[1]);
}

/** A wall's piece between two distances [m] from its beginning.
 * @param {number[]} wall */
const piece = (wall, /** @type {number} */ from, /** @type {number} */ to) => [
  ...(from <= SAME ? wall.slice(0, 2) : pointAt(wall, from)),
  ...(to >= lengthOf(wall) - SAME ? wall.slice(2) : pointAt(wall, to)),
];

/** What is left of a wall without the part between two distances.
 * @param {number[]} wall
 * @param {number} from
 * @param {number} to */
export function cut(wall, from, to) {
  const length = lengthOf(wall);
  return [[0, from], [to, length]].filter(([a, b]) => b - a > LEAST).map(([a, b]) => piece(wall, a, b));
}

/** Where others cross or touch a wall, as distances along it, in order; its ends are left out.
 * @param {number[]} wall
 * @param {number[][]} others */
export function crossings(wall, others) {
  const length = lengthOf(wall);
  const found = others.flatMap((other) => {
    const points = /** @type {(number[] | null)[]} */ ([crossing(wall, other)]);
    for (const [x, y] of [other.slice(0, 2), other.slice(2)]) {
      const [u, v] = footOn(wall, x, y);
      if (Math.hypot(u - x, v - y) < SAME) points.push([x, y]);
    }
    return points.flatMap((point) => (point ? [alongOf(wall, point[0], point[1])] : []));
  });
  return [...new Set(found.map((value) => Math.round(value * 1e6) / 1e6))].filter((value) => value > LEAST && value < length - LEAST).sort((a, b) => a - b);
}

/** The pieces of a wall between the places where others cross it, or its halves.
 * @param {number[]} wall
 * @param {number[][]} others */
export function split(wall, others) {
  const at = crossings(wall, others);
  const ends = [0, ...(at.length ? at : [lengthOf(wall) / 2]), lengthOf(wall)];
  return ends.slice(1).map((to, n) => piece(wall, ends[n], to));
}

/** The stretch of a wall between the crossings about a place, as distances along it.
 * @param {number[]} wall
 * @param {number[][]} others
 * @param {number} along */
export function stretch(wall, others, along) {
  const at = [0, ...crossings(wall, others), lengthOf(wall)];
  const n = Math.max(1, at.findIndex((value) => value > along));
  return [at[n - 1], at[n]];
}

/** Where the lines through two walls meet, or null where they run alike.
 * @param {number[]} one
 * @param {number[]} other */
function meeting([a, b, c, d], [e, f, g, h]) {
  const det = (c - a) * (h - f) - (d - b) * (g - e);
  if (Math.abs(det) < 1e-9 * Math.hypot(c - a, d - b) * Math.hypot(g - e, h - f)) return null;
  const s = ((e - a) * (h - f) - (f - b) * (g - e)) / det;
  return [round(a + s * (c - a)), round(b + s * (d - b))];
}

/** A wall whose end nearer to a point lies there.
 * @param {number[]} wall
 * @param {number[]} point */
function ending(wall, [x, y]) {
  const isFirst = Math.hypot(wall[0] - x, wall[1] - y) < Math.hypot(wall[2] - x, wall[3] - y);
  return isFirst ? [x, y, wall[2], wall[3]] : [wall[0], wall[1], x, y];
}

/** Two walls as one where they lie on one line; else both so that they end where they meet. Null where they are parallel.
 * @param {number[]} one
 * @param {number[]} other
 * @returns {number[][] | null} */
export function joined(one, other) {
  const length = lengthOf(one);
  const beside = (/** @type {number} */ x, /** @type {number} */ y) => Math.abs((x - one[0]) * (one[3] - one[1]) - (y - one[1]) * (one[2] - one[0])) / length;
  if (beside(other[0], other[1]) < LEAST && beside(other[2], other[3]) < LEAST) {
    /** @param {number[]} point */
    const along = ([x, y]) => ((x - one[0]) * (one[2] - one[0]) + (y - one[1]) * (one[3] - one[1])) / length;
    const ends = [one.slice(0, 2), one.slice(2), other.slice(0, 2), other.slice(2)].sort((a, b) => along(a) - along(b));
    return [[...ends[0], ...ends[3]]];
  }
  const point = meeting(one, other);
  return point && [ending(one, point), ending(other, point)];
}

/** Walls at a distance [m] to the left of walls, seen from where each begins; corners stay corners.
 * @param {number[][]} walls
 * @param {number} distance */
export function offset(walls, distance) {
  const moved = walls.map((wall) => {
    const [a, b, c, d] = wall;
    const length = lengthOf(wall);
    const [dx, dy] = [(-distance * (d - b)) / length, (distance * (c - a)) / length];
    return [a + dx, b + dy, c + dx, d + dy];
  });
  const found = moved.map((wall) => [...wall]);
  walls.forEach((one, i) => walls.forEach((other, k) => {
    if (i === k || Math.hypot(one[2] - other[0], one[3] - other[1]) > SAME) return;
    const corner = meeting(moved[i], moved[k]);
    if (!corner) return;
    found[i].splice(2, 2, ...corner);
    found[k].splice(0, 2, ...corner);
  }));
  return found.map((wall) => wall.map(round));
}

/** The walls of a room with an opening of a width [m] about a point of its outline, or without one.
 * @param {number[][]} sides
 * @param {{x: number, y: number} | null} at
 * @param {number} width */
export function withOpening(sides, at, width) {
  if (!at) return sides;
  const gap = (/** @type {number[]} */ wall) => {
    const [u, v] = footOn(wall, at.x, at.y);
    return Math.hypot(u - at.x, v - at.y);
  };
  const nearest = sides.reduce((best, wall) => (gap(wall) < gap(best) ? wall : best));
  return sides.flatMap((wall) => {
    if (wall !== nearest) return [wall];
    const [from, to] = opening(wall, alongOf(wall, at.x, at.y), width);
    return cut(wall, from, to);
  });
}

/** The part of a wall that an opening of a width takes about a place, kept within the wall.
 * @param {number[]} wall
 * @param {number} along
 * @param {number} width
 * @returns {[number, number]} */
export function opening(wall, along, width) {
  const length = lengthOf(wall);
  const wide = Math.min(width, length);
  const middle = Math.min(Math.max(along, wide / 2), length - wide / 2);
  const from = Math.round((middle - wide / 2) * 100) / 100; // in whole centimetres from the wall's beginning
  return [Math.max(0, Math.min(from, length - wide)), Math.min(length, Math.max(0, Math.min(from, length - wide)) + wide)];
}
