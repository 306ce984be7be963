// Walls: what a pointer snaps to, and what is made of walls that are there.

import assert from "node:assert/strict";
import { boxOf, crossing, footOn, holds, isIn, Walls, wordsOf } from "../../../../amorsim/ui/web/editor/geometry.js";
import { crossings, cut, joined, lengthOf, offset, opening, split, stretch, withOpening } from "../../../../amorsim/ui/web/editor/wall_work.js";
import { SpatialIndex, gapToLine } from "../../../../amorsim/ui/web/shared/spatial.js";
import { areNear, drawn } from "./near.js";

const ROOM = [[0, 0, 4, 0], [4, 0, 4, 3], [4, 3, 0, 3], [0, 3, 0, 0]];
const total = (walls) => walls.reduce((sum, wall) => sum + lengthOf(wall), 0);

Deno.test("a part that is cut out is missing, and nothing else", () => {
  areNear(cut([0, 0, 4, 0], 1, 1.9).flat(), [0, 0, 1, 0, 1.9, 0, 4, 0]);
  areNear(cut([0, 0, 4, 0], 0, 1).flat(), [1, 0, 4, 0]);
  assert.deepEqual(cut([0, 0, 4, 0], 0, 4), []);
});

Deno.test("a wall is split where others cross it, or in half", () => {
  const others = [[1, -1, 1, 1], [3, 0, 3, 5], [0, 1, 4, 1]];
  areNear(crossings([0, 0, 4, 0], others), [1, 3]);
  areNear(split([0, 0, 4, 0], others).flat(), [0, 0, 1, 0, 1, 0, 3, 0, 3, 0, 4, 0]);
  areNear(split([0, 0, 4, 0], []).flat(), [0, 0, 2, 0, 2, 0, 4, 0]);
  areNear(stretch([0, 0, 4, 0], others, 2.2), [1, 3]);
  areNear(stretch([0, 0, 4, 0], others, 3.2), [3, 4]);
});

Deno.test("walls on one line become one, others meet, and parallel ones do not", () => {
  areNear(joined([0, 0, 1, 0], [3, 0, 2, 0])?.flat() ?? [], [0, 0, 3, 0]);
  areNear(joined([0, 0, 1, 0], [2, 1, 2, 3])?.flat() ?? [], [0, 0, 2, 0, 2, 0, 2, 3]);
  assert.equal(joined([0, 0, 1, 0], [0, 1, 1, 1]), null);
});

Deno.test("walls that are moved aside keep their corners", () => {
  const inner = offset(ROOM, 0.5); // to the left of each, which is inside
  areNear(inner.flat(), [0.5, 0.5, 3.5, 0.5, 3.5, 0.5, 3.5, 2.5, 3.5, 2.5, 0.5, 2.5, 0.5, 2.5, 0.5, 0.5]);
  areNear(offset(inner, -0.5).flat(), ROOM.flat());
});

Deno.test("an opening is as wide as it is to be, and within its wall", () => {
  const door = withOpening(ROOM, { x: 1.7, y: 0.1 }, 0.9);
  assert.equal(door.length, 5);
  areNear([total(door)], [total(ROOM) - 0.9]);
  assert.equal(withOpening(ROOM, null, 0.9), ROOM);
  areNear(opening([0, 0, 4, 0], 0.1, 0.9), [0, 0.9]);
  areNear(opening([0, 0, 4, 0], 3.9, 0.9), [3.1, 4]);
  areNear(opening([0, 0, 0.5, 0], 0.2, 0.9), [0, 0.5]);
});

Deno.test("a pointer snaps to ends before walls, and to the grid where nothing is near", () => {
  const walls = new Walls(ROOM, [0, 0, 4, 3]);
  const at = (x, y, more = {}) => {
    const { x: u, y: v, kind } = walls.snap({ x, y }, { scale: 100, grid: 0.5, ...more });
    return [u, v, kind];
  };
  assert.deepEqual(at(3.96, 0.05), [4, 0, "end"]);
  assert.deepEqual(at(2.04, 0.03), [2, 0, "middle"]);
  assert.deepEqual(at(1.27, 0.03), [1.27, 0, "wall"]);
  assert.deepEqual(at(1.27, 1.3), [1.5, 1.5, "grid"]);
  assert.deepEqual(at(1.27, 1.3, { grid: 0 }), [1.27, 1.3, ""]);
  assert.deepEqual(at(3.96, 0.05, { isFree: true }), [3.96, 0.05, ""]);
  assert.deepEqual(at(1.9, 1.1, { from: [1, 1], isTurned: true }), [2, 1, "angle"]);
  assert.deepEqual(at(1.02, 2.98, { from: [1, 1], grid: 0 }), [1, 3, "perpendicular"]);
});

Deno.test("the nearest wall is found as if all were asked", () => {
  const next = drawn(1);
  const lines = Array.from({ length: 60 }, () => Array.from({ length: 4 }, () => 10 * next()));
  const walls = new Walls(lines, [0, 0, 10, 10]);
  for (let n = 0; n < 300; n++) {
    const [x, y, reach] = [12 * next() - 1, 12 * next() - 1, 2 * next()];
    const gaps = lines.map(([a, b, c, d]) => gapToLine(x, y, a, b, c, d));
    const least = Math.min(...gaps);
    assert.equal(walls.nearest(x, y, reach), least <= reach ? gaps.indexOf(least) : -1);
    areNear([walls.clearance(x, y)], [least]);
  }
});

Deno.test("a spatial index misses nothing", () => {
  const next = drawn(2);
  const index = new SpatialIndex(0.7);
  const discs = Array.from({ length: 200 }, () => [20 * next() - 10, 20 * next() - 10, 2 * next()]);
  discs.forEach(([x, y, reach], n) => index.addDisc(n, x, y, reach));
  index.addDisc(-1, NaN, 0, 1);
  for (let k = 0; k < 200; k++) {
    const [x, y, far] = [24 * next() - 12, 24 * next() - 12, next() < 0.1 ? 40 : next()];
    const found = index.near(x, y, far);
    discs.forEach(([u, v, reach], n) => assert(Math.hypot(u - x, v - y) > reach + far || found.has(n)));
    assert(!found.has(-1));
  }
});

Deno.test("footprints hold what is within them, and fit in their boxes", () => {
  const polygon = { polygon: [[-1, -0.5], [1, -0.5], [1, 0.5], [-1, 0.5]] };
  const pose = [2, 3, Math.PI / 2];
  areNear(boxOf(polygon, pose), [1.5, 2, 2.5, 4]);
  areNear(boxOf({ circle: 0.5 }, pose), [1.5, 2.5, 2.5, 3.5]);
  assert(holds(polygon, pose, 2.4, 3.9) && !holds(polygon, pose, 2.9, 3.4));
  assert(holds({ circle: 0.5 }, pose, 2.3, 3.3) && !holds({ circle: 0.5 }, pose, 2.4, 3.4));
});

Deno.test("a wall is told by its length and its direction, and is in a box wholly or not", () => {
  assert.equal(wordsOf([0, 0, 3, -4]), "5.00 m, −53.1°");
  assert(isIn([1, 1, 2, 2], [0, 0, 3, 3]) && !isIn([1, 1, 4, 2], [0, 0, 3, 3]));
  areNear(crossing([0, 0, 2, 2], [0, 2, 2, 0]) ?? [], [1, 1]);
  assert.equal(crossing([0, 0, 1, 1], [0, 2, 0, 3]), null);
  areNear(footOn([0, 0, 2, 0], 5, 1), [2, 0]);
});
