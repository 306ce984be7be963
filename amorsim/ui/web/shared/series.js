// Samples over time, kept for plots.

const MOST = 9000;

/** Samples of several curves over time, in bounded memory: when it is full, every other of the older half goes. */
export class Series {
  /** @type {number[]} */
  times = [];
  /** @type {number[][]} */
  values = [];

  /** @param {string[]} curves */
  constructor(curves) {
    this.curves = curves; // names of kinds: "true", "measured", "estimated", "difference"
    this.clear();
  }

  clear() {
    this.times = [];
    this.values = this.curves.map(() => []);
  }

  /** Add a sample; one earlier than the last cuts off what came after it.
   * @param {number} time
   * @param {ArrayLike<number | undefined>} values */
  add(time, values) {
    while (this.times.length && this.times[this.times.length - 1] > time - 1e-9) {
      this.times.pop();
      for (const column of this.values) column.pop();
    }
    this.times.push(time);
    this.values.forEach((column, c) => column.push(values[c] ?? NaN));
    if (this.times.length <= MOST) return;
    const keep = (/** @type {unknown} */ _, /** @type {number} */ i) => i > MOST / 2 || i % 2 === 0;
    this.times = this.times.filter(keep);
    this.values = this.values.map((column) => column.filter(keep));
  }
}

/** The place of the time that is nearest; -1 where there are none.
 * @param {number[]} times in order
 * @param {number} time */
export function nearest(times, time) {
  let [low, high] = [0, times.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1;
    else high = middle;
  }
  if (low === times.length || (low > 0 && time - times[low - 1] < times[low] - time)) low -= 1;
  return low;
}
