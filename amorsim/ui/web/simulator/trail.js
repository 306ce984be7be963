// The path a robot drove, in bounded memory: when it is full, every other point of the older half goes.

const MOST = 6000;

export class Trail {
  from = -Infinity; // ticks that are drawn
  to = Infinity;
  /** Ticks and places. @type {number[][]} */
  points = [];
  last = -Infinity; // tick
  count = 0;

  constructor() {
    this.clear();
  }

  clear() {
    this.points = [];
    this.count = 0;
    this.last = -Infinity;
    /** @type {number[] | null} */
    this.end = null;
    [this.from, this.to] = [-Infinity, Infinity];
  }

  /** Add a point of a tick; what does not move is not added, and going back in time cuts the trail there.
   * @param {number} tick
   * @param {number} x
   * @param {number} y */
  add(tick, x, y) {
    if (tick < this.last) this.cut(tick);
    this.last = tick;
    const n = this.points.length;
    if (n && Math.hypot(this.points[n - 1][1] - x, this.points[n - 1][2] - y) < 1e-3) return;
    this.points.push([tick, x, y]);
    if (this.points.length > MOST) {
      const half = MOST / 2;
      this.points = this.points.filter((_, i) => i > half || i % 2 === 0);
    }
    this.count = this.points.length;
  }

  /** @param {number} tick */
  cut(tick) {
    while (this.points.length && this.points[this.points.length - 1][0] > tick) this.points.pop();
    this.count = this.points.length;
  }

  /** Take a recorded path instead: `ticks` and `poses` as rows of x, y, ….
   * @param {number[]} ticks
   * @param {ArrayLike<number>[]} poses */
  load(ticks, poses) {
    this.points = ticks.map((tick, i) => [tick, poses[i][0], poses[i][1]]);
    this.count = this.points.length;
    this.last = this.count ? ticks[ticks.length - 1] : -Infinity;
  }

  /** End it at a point of a tick, and keep the rest: the whole path of a recorded run is known.
   * @param {number} tick
   * @param {number} x
   * @param {number} y */
  showUntil(tick, x, y) {
    this.end = [tick, x, y];
  }

  /** @param {(x: number, y: number) => void} visit */
  each(visit) {
    const { from, to } = this;
    const until = this.end ? this.end[0] : Infinity;
    for (const [tick, x, y] of this.points) if (tick < until && tick >= from && tick <= to) visit(x, y);
    if (this.end && this.end[0] >= from && this.end[0] <= to) visit(this.end[1], this.end[2]);
  }
}
