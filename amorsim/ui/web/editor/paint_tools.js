// Tools for bitmap worlds: brush, eraser, line, fill and crop, in cells of the map.

import { Tool } from "../shared/tool.js";
import { BoxTool } from "./wall_tools.js";

const MOST = 150_000; // spans of one stroke

/** The cells of the world's bitmap: where they lie, and which one is at a point.
 * @param {import("./editor.js").EditorPage} page */
export function cellsOf(page) {
  const map = page.stage.whole?.map ?? page.stage.scene?.map;
  const [rows, columns] = page.state?.cells ?? [0, 0];
  if (!map || !rows) return null;
  const [x, y, heading] = map.origin;
  const side = map.size[0] / columns;
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return {
    rows, columns, side, x, y, heading,
    /** Column and row, counted from the top, as numbers with fractions. */
    at: (/** @type {number} */ u, /** @type {number} */ v) => {
      const [dx, dy] = [u - x, v - y];
      return [(dx * c + dy * s) / side, rows - (dy * c - dx * s) / side];
    },
  };
}

/** The spans of cells within a radius of a line between two points, in cells.
 * @param {number[]} from column and row
 * @param {number[]} to
 * @param {number} radius in cells */
export function spansOf([c0, r0], [c1, r1], radius) {
  const [dc, dr] = [c1 - c0, r1 - r0];
  const length = dc * dc + dr * dr;
  const found = [];
  for (let row = Math.floor(Math.min(r0, r1) - radius); row <= Math.max(r0, r1) + radius; row++) {
    const y = row + 0.5; // the cells whose middle is near enough to the line
    let [low, high] = [Infinity, -Infinity];
    const take = (/** @type {number} */ left, /** @type {number} */ right) => [low, high] = [Math.min(low, left), Math.max(high, right)];
    for (const [c, r] of [[c0, r0], [c1, r1]]) {
      const rest = radius * radius - (y - r) * (y - r);
      if (rest >= 0) take(c - Math.sqrt(rest), c + Math.sqrt(rest));
    }
    if (length > 0) { // the rectangle between the two discs, which is convex: its edges on this row
      const [nc, nr] = [(-dr / Math.sqrt(length)) * radius, (dc / Math.sqrt(length)) * radius];
      const corners = [[c0 + nc, r0 + nr], [c1 + nc, r1 + nr], [c1 - nc, r1 - nr], [c0 - nc, r0 - nr]];
      corners.forEach(([a, b], n) => {
        const [e, f] = corners[(n + 1) % 4];
        if (b === f || y < Math.min(b, f) || y > Math.max(b, f)) return;
        const at = a + ((y - b) / (f - b)) * (e - a);
        take(at, at);
      });
    }
    const [first, end] = [Math.ceil(low - 0.5), Math.floor(high - 0.5) + 1];
    if (end > first) found.push([row, first, end]);
  }
  // The cell under the pointer is meant in any case.
  if (radius < 1) found.push([Math.floor(r1), Math.floor(c1), Math.floor(c1) + 1]);
  return found;
}

/** Paints cells occupied, or free. */
export class BrushTool extends Tool {
  /** @param {import("./editor.js").EditorPage} page
   * @param {{isOccupied: boolean, isLine?: boolean}} how */
  constructor(page, { isOccupied, isLine = false }) {
    super();
    this.page = page;
    this.stage = page.stage;
    this.isOccupied = isOccupied;
    this.isLine = isLine;
    /** @type {number[][]} */
    this.spans = [];
    /** @type {number[] | null} */
    this.from = null;
  }

  get cursor() {
    return "crosshair";
  }

  get says() {
    return this.isLine ? "Drag a line of occupied cells." : this.isOccupied ? "Drag to make cells occupied." : "Drag to make cells free.";
  }

  get radius() {
    const cells = cellsOf(this.page);
    return cells ? Math.max(0.5, this.page.brush / 2 / cells.side) : 0.5;
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {{button: number, shiftKey?: boolean}} event */
  down(place, event) {
    const cells = cellsOf(this.page);
    if (!cells || event.button !== 0) return;
    this.from = cells.at(place.x, place.y);
    this.spans = spansOf(this.from, this.from, this.radius);
    this.show(cells);
  }

  /** @param {import("../shared/tool.js").Place} place */
  move(place) {
    const cells = cellsOf(this.page);
    if (!cells) return;
    const now = cells.at(place.x, place.y);
    if (!this.from) {
      this.stage.preview = { cells: { ...cells, spans: spansOf(now, now, this.radius), isOccupied: this.isOccupied, isFaint: true } };
      this.stage.redraw();
      return;
    }
    const fresh = spansOf(this.from, now, this.radius);
    if (this.isLine) this.spans = fresh;
    else {
      this.spans.push(...fresh);
      this.from = now;
    }
    this.show(cells);
    if (this.spans.length > MOST) this.up();
  }

  /** @param {any} cells */
  show(cells) {
    this.stage.preview = { cells: { ...cells, spans: this.spans, isOccupied: this.isOccupied } };
    this.stage.redraw();
  }

  async up() {
    if (!this.from) return;
    const { page, stage, isOccupied } = this;
    const spans = joined(this.spans);
    this.from = null;
    this.spans = [];
    stage.preview = null;
    const stroke = { cells: { ...cellsOf(page), spans, isOccupied }, isKept: false, isRead: false };
    stage.strokes.push(stroke);
    const said = await page.edit(this.isLine ? "draw a line of cells" : isOccupied ? "paint" : "erase", [{ op: "paint", spans, occupied: isOccupied }]);
    stroke.isKept = said.ok;
    if (!said.ok) stage.strokes = stage.strokes.filter((one) => one !== stroke);
    stage.redraw();
  }

  cancel() {
    this.from = null;
    this.spans = [];
    this.stage.preview = null;
    this.stage.redraw();
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} middle */
  key(event, middle) {
    if (event.key !== "Enter") return false;
    if (this.isLine && !this.from) this.down(middle, { button: 0 });
    else {
      if (!this.from) this.down(middle, { button: 0 });
      else this.move(middle);
      this.up();
    }
    return true;
  }
}

/** Spans of a row that touch, as one.
 * @param {number[][]} spans */
function joined(spans) {
  const rows = new Map();
  for (const [row, first, end] of spans) {
    if (!rows.has(row)) rows.set(row, []);
    rows.get(row).push([first, end]);
  }
  return [...rows].flatMap(([row, parts]) => {
    parts.sort((/** @type {number[]} */ [a], /** @type {number[]} */ [b]) => a - b);
    const found = [];
    for (const [first, end] of parts) {
      const last = found[found.length - 1];
      if (last && first <= last[2]) last[2] = Math.max(last[2], end);
      else found.push([row, first, end]);
    }
    return found;
  });
}

/** Fills the area about a cell: a free one becomes occupied; with Shift, an occupied one free. */
export class FillTool extends Tool {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    super();
    this.page = page;
  }

  get cursor() {
    return "crosshair";
  }

  get says() {
    return "Click a free area: it becomes occupied. Shift: an occupied one becomes free.";
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {{button: number, shiftKey?: boolean}} event */
  down(place, event) {
    const cells = cellsOf(this.page);
    if (!cells || event.button) return;
    const [column, row] = cells.at(place.x, place.y).map(Math.floor);
    if (row < 0 || column < 0 || row >= cells.rows || column >= cells.columns) return;
    this.page.edit("fill", [{ op: "fill", row, column, occupied: !event.shiftKey }]);
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} middle */
  key(event, middle) {
    if (event.key !== "Enter") return false;
    this.down(middle, { button: 0, shiftKey: event.shiftKey });
    return true;
  }
}

/** Keeps what lies in a box.
 * @param {import("./editor.js").EditorPage} page */
export const cropTool = (page) =>
  new BoxTool(page, "Click two corners, or drag: what lies in this box is kept.", ([x0, y0, x1, y1]) => {
    const cells = cellsOf(page);
    if (!cells) return;
    const corners = [[x0, y0], [x1, y1]].map(([x, y]) => cells.at(x, y));
    const [left, right] = [Math.min(...corners.map(([c]) => c)), Math.max(...corners.map(([c]) => c))];
    const [top, end] = [Math.min(...corners.map(([, r]) => r)), Math.max(...corners.map(([, r]) => r))];
    page.edit("crop the world", [{ op: "crop", box: [Math.floor(top), Math.floor(left), Math.ceil(end), Math.ceil(right)] }]);
    page.fitsNext = true;
    page.take("select");
  });
