// A spatial index: things by the square cells of the plane that they touch, so that a click looks at a few of many.

const HALF = 1 << 20;

/** How far the point (x, y) is from the line from (x0, y0) to (x1, y1).
 * @param {number} x
 * @param {number} y
 * @param {number} x0
 * @param {number} y0
 * @param {number} x1
 * @param {number} y1 */
export function gapToLine(x, y, x0, y0, x1, y1) {
  const [dx, dy] = [x1 - x0, y1 - y0];
  const length = dx * dx + dy * dy;
  const part = length > 0 ? Math.min(1, Math.max(0, ((x - x0) * dx + (y - y0) * dy) / length)) : 0;
  return Math.hypot(x0 + part * dx - x, y0 + part * dy - y);
}

/** @template T */
export class SpatialIndex {
  /** @param {number} cell side of a cell [m] */
  constructor(cell) {
    this.cell = cell;
    /** @type {Map<number, T[]>} */
    this.cells = new Map();
  }

  /** @param {number} value [m] */
  placeOf(value) {
    return Math.max(-HALF, Math.min(HALF - 1, Math.floor(value / this.cell)));
  }

  /** @param {T} thing
   * @param {number} column
   * @param {number} row */
  put(thing, column, row) {
    const key = (column + HALF) * 2 * HALF + row + HALF;
    const there = this.cells.get(key);
    if (there) there.push(thing);
    else this.cells.set(key, [thing]);
  }

  /** Add what lies within a distance of a point.
   * @param {T} thing
   * @param {number} x
   * @param {number} y
   * @param {number} reach [m] */
  addDisc(thing, x, y, reach) {
    if (!Number.isFinite(x + y + reach)) return;
    for (let i = this.placeOf(x - reach); i <= this.placeOf(x + reach); i++) {
      for (let j = this.placeOf(y - reach); j <= this.placeOf(y + reach); j++) this.put(thing, i, j);
    }
  }

  /** Add a line: to the cells along it alone.
   * @param {T} thing
   * @param {number} x0
   * @param {number} y0
   * @param {number} x1
   * @param {number} y1 */
  addLine(thing, x0, y0, x1, y1) {
    if (!Number.isFinite(x0 + y0 + x1 + y1)) return;
    const [[left, a], [right, b]] = x0 <= x1 ? [[x0, y0], [x1, y1]] : [[x1, y1], [x0, y0]];
    const heightAt = (/** @type {number} */ x) => (right > left ? a + ((b - a) * (x - left)) / (right - left) : a);
    for (let i = this.placeOf(left); i <= this.placeOf(right); i++) {
      const enters = heightAt(Math.max(left, i * this.cell));
      const leaves = right > left ? heightAt(Math.min(right, (i + 1) * this.cell)) : b;
      // A hair more: what rounding puts into the next cell is found there, too.
      const air = this.cell * 1e-9;
      for (let j = this.placeOf(Math.min(enters, leaves) - air); j <= this.placeOf(Math.max(enters, leaves) + air); j++) this.put(thing, i, j);
    }
  }

  /** The things that may lie within `reach` of a point: all that do, and some that do not. Each once.
   * @param {number} x
   * @param {number} y
   * @param {number} reach [m]
   * @returns {Set<T>} */
  near(x, y, reach) {
    /** @type {Set<T>} */
    const found = new Set();
    const [i0, i1, j0, j1] = [x - reach, x + reach, y - reach, y + reach].map((value) => this.placeOf(value));
    // Seen from far away, the cells in reach are more than there are.
    if ((i1 - i0 + 1) * (j1 - j0 + 1) > this.cells.size) {
      for (const things of this.cells.values()) for (const thing of things) found.add(thing);
      return found;
    }
    for (let i = i0; i <= i1; i++) {
      for (let j = j0; j <= j1; j++) {
        for (const thing of this.cells.get((i + HALF) * 2 * HALF + j + HALF) ?? []) found.add(thing);
      }
    }
    return found;
  }
}
