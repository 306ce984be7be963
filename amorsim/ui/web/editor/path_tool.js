// Draws the points of a list that lies in the world: waypoints, goals, a line on the floor.

import { DrawTool } from "./draw_tools.js";

export class PathTool extends DrawTool {
  /** @param {import("./editor.js").EditorPage} page
   * @param {string} label
   * @param {(points: number[][]) => void} done */
  constructor(page, label, done) {
    super(page);
    this.label = label;
    this.done = done;
  }

  get says() {
    return this.points.length ? "Click the next point; Escape ends." : `Click the first of the ${this.label}.`;
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    const ends = [...this.points, [mark.x, mark.y]];
    return { walls: ends.slice(1).map((end, n) => [...ends[n], ...end]), words: `${ends.length}`, at: [mark.x, mark.y] };
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  point({ x, y }) {
    const last = this.points.at(-1);
    if (last && last[0] === x && last[1] === y) return;
    this.points.push([x, y]);
    this.page.showTool(this);
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} middle */
  key(event, middle) {
    if (event.key !== "Escape") return super.key(event, middle);
    const found = this.points;
    this.cancel();
    this.page.take("select");
    if (found.length) this.done(found);
    return true;
  }
}
