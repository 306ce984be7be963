// What is kept of a robot over time: every quantity, as true, measured and estimated, for the plots.

import { there } from "../shared/dom.js";
import { Series } from "../shared/series.js";
import { momentsOf } from "./past.js";
import { KINDS, quantitiesOf } from "./quantities.js";

const SIGMA = "sigma";

export class Record {
  /** @param {any} robot the robot's entry in the scene, or nothing */
  constructor(robot) {
    this.robot = robot;
    this.quantities = robot ? quantitiesOf(robot) : [];
    this.series = new Map(this.quantities.map((one) => [one.key, new Series([...KINDS, SIGMA])]));
  }

  /** The series of one of its quantities.
   * @param {string} key */
  seriesOf(key) {
    return there(this.series.get(key));
  }

  /** @param {string} key */
  quantity(key) {
    return this.quantities.find((one) => one.key === key);
  }

  clear() {
    for (const series of this.series.values()) series.clear();
  }

  /** Take what was recorded, after a reload, a turn to another robot or a step back in time; what came since stays.
   * @param {import("./messages.d.ts").History | import("./messages.d.ts").Future} history
   * @param {number} dt seconds of a tick */
  load(history, dt) {
    const moments = momentsOf(history, this.robot, dt);
    const last = moments.at(-1)?.time ?? -1;
    for (const quantity of this.quantities) {
      const series = this.seriesOf(quantity.key);
      const later = series.times.flatMap((time, n) => (time > last + 1e-9 ? [{ time, values: series.values.map((column) => column[n]) }] : []));
      series.clear();
      for (const moment of moments) series.add(moment.time, sample(quantity, moment, 0));
      for (const { time, values } of later) series.add(time, values);
    }
  }

  /** Keep a frame's values; those of the past are kept already.
   * @param {import("./messages.d.ts").Frame} frame */
  add(frame) {
    for (const quantity of this.quantities) this.seriesOf(quantity.key).add(frame.time, sample(quantity, frame, frame.selected));
  }

  /**
   * The columns of a quantity, of these kinds or "sigma".
   * @param {string} key
   * @param {string[]} kinds
   */
  columns(key, kinds) {
    const series = this.seriesOf(key);
    return kinds.map((kind) => series.values[kind === SIGMA ? KINDS.length : KINDS.indexOf(kind)]);
  }
}

const sample = (/** @type {import("./quantities.js").Quantity} */ quantity, /** @type {import("./quantities.js").Moment} */ frame, /** @type {number} */ i) => [...quantity.of(frame, i), quantity.sigma ? quantity.sigma(frame, i) : NaN];
