// Tools that put bodies where the user clicks, and turn or size them by dragging.

import { DrawTool, FREE } from "./draw_tools.js";
import { round } from "./geometry.js";
import { footprintOf } from "./things.js";

const LEAST_SIZE = 0.02; // [m] of a side that is dragged out

/** Puts a thing where the user clicks; dragging on turns it. */
export class PlaceTool extends DrawTool {
  /**
   * @param {import("./editor.js").EditorPage} page
   * @param {{label: string, footprint: any}} what
   * @param {(pose: number[]) => void} done gets x, y [m] and heading [°]
   */
  constructor(page, what, done) {
    super(page);
    this.what = what;
    this.done = done;
  }

  get says() {
    return `Click where ${this.what.label} is to stand; drag to turn it. Escape: none.`;
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    const [at] = this.points;
    const heading = at ? Math.atan2(mark.y - at[1], mark.x - at[0]) : 0;
    const isTurned = at && Math.hypot(mark.x - at[0], mark.y - at[1]) > 0.02;
    const pose = at ? [at[0], at[1], isTurned ? heading : 0] : [mark.x, mark.y, 0];
    return { bodies: [{ footprint: this.what.footprint, pose }] };
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {import("./draw_tools.js").Held} event */
  snapped(place, event) {
    return this.stage.walls.snap(place, { ...this.page.snapping(event, null), isTurned: false, isFree: this.points.length > 0 || event.altKey });
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  point({ x, y }) {
    this.points = [[x, y]];
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event */
  up(place, event) {
    if (this.points.length) this.finish(this.snapped(place, event));
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  finish(mark) {
    const [x, y] = this.points[0];
    const isTurned = Math.hypot(mark.x - x, mark.y - y) * this.stage.camera.scale > 12;
    const heading = isTurned ? Math.round((Math.atan2(mark.y - y, mark.x - x) * 36) / Math.PI) * 5 : 0;
    this.cancel();
    this.done([x, y, heading]);
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} place */
  key(event, place) {
    if (event.key === "Escape") {
      this.cancel();
      this.page.take("select");
      return true;
    }
    if (event.key !== "Enter") return false;
    const mark = this.snapped(place, FREE);
    this.point(mark);
    this.finish(mark);
    return true;
  }
}

/** Puts a thing where the user clicks, in its usual size, or as large as it is dragged out. */
export class SizeTool extends PlaceTool {
  /**
   * @param {import("./editor.js").EditorPage} page
   * @param {{label: string, footprint: any, sized: "rectangle" | "circle"}} what
   * @param {(pose: number[], size?: any) => void} done gets x, y [m] and heading [°], and a shape if one was dragged out
   */
  constructor(page, what, done) {
    super(page, what, done);
    this.sized = what.sized;
    this.finished = done;
  }

  get says() {
    const how = this.sized === "circle" ? "from its middle to its rim" : "from corner to corner";
    return `Drag out ${this.what.label} ${how}, or click for its usual size. Escape: none.`;
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {import("./draw_tools.js").Held} event */
  snapped(place, event) {
    return this.stage.walls.snap(place, { ...this.page.snapping(event, null), isTurned: false });
  }

  /** The shape between where the pointer went down and where it is, and the middle of it; null for a click.
   * @param {import("./draw_tools.js").Mark} mark */
  shapeTo(mark) {
    const [at] = this.points;
    if (!at) return null;
    const [dx, dy] = [mark.x - at[0], mark.y - at[1]];
    if (this.sized === "circle") {
      const radius = round(Math.hypot(dx, dy));
      return radius < LEAST_SIZE ? null : { shape: { circle: radius }, middle: at, words: `radius ${radius} m` };
    }
    const sides = [round(Math.abs(dx)), round(Math.abs(dy))];
    if (Math.min(...sides) < LEAST_SIZE) return null;
    return { shape: { rectangle: sides }, middle: [round(at[0] + dx / 2), round(at[1] + dy / 2)], words: `${sides[0]} × ${sides[1]} m` };
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    const dragged = this.shapeTo(mark);
    if (!dragged) return super.about(mark);
    return { bodies: [{ footprint: footprintOf(dragged.shape), pose: [...dragged.middle, 0] }], words: dragged.words, at: [mark.x, mark.y] };
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  finish(mark) {
    const dragged = this.shapeTo(mark);
    const [x, y] = dragged?.middle ?? this.points[0];
    this.cancel();
    this.finished([x, y, 0], dragged?.shape);
  }
}
