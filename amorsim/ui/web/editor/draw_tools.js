// Tools that draw walls, as lines, polylines, rectangles and circles; and a tape measure.

import { Tool } from "../shared/tool.js";
import { round, wordsOf } from "./geometry.js";

/** Of an event that is none: no key is held. */
export const FREE = { altKey: false, shiftKey: false };

/** A point that is given, and what it snapped to. @typedef {{x: number, y: number, kind?: string}} Mark */
/** The keys that are held while the pointer moves. @typedef {{altKey: boolean, shiftKey: boolean}} Held */

/** What all drawing tools do: show where the pointer snaps to. */
export class DrawTool extends Tool {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    super();
    this.page = page;
    this.stage = page.stage;
    /** @type {number[][]} */
    this.points = [];
  }

  get cursor() {
    return "crosshair";
  }

  get says() {
    return "";
  }

  /** @param {{x: number, y: number}} place
   * @param {Held} event */
  snapped(place, event) {
    return this.stage.walls.snap(place, this.page.snapping(event, this.points.at(-1) ?? null));
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {Held} event */
  move(place, event) {
    const mark = this.snapped(place, event);
    this.last = mark;
    this.stage.preview = { mark, ...this.about(mark) };
    this.stage.redraw();
  }

  /** What is drawn while the pointer is at a point.
   * @param {Mark} _mark */
  about(_mark) {
    return {};
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event */
  down(place, event) {
    if (event.button === 0) this.point(this.snapped(place, event));
  }

  /** A point is given, by a click, by Enter, or typed.
   * @param {Mark} _mark */
  point(_mark) {}

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} place */
  key(event, place) {
    if (event.key === "Enter") {
      this.point(this.snapped(place, FREE));
      this.move(place, FREE);
      return true;
    }
    if (event.key === "Escape" && this.points.length) {
      this.cancel();
      return true;
    }
    return false;
  }

  /** The end of a line of a typed length [m] and angle [degrees], in the direction of the pointer where none is typed; null
   * without a length.
   * @param {number} length
   * @param {number} degrees */
  typedMark(length, degrees) {
    const from = this.points.at(-1);
    if (!from || !(length > 0)) return null;
    const towards = this.last ?? { x: from[0] + 1, y: from[1] };
    const angle = Number.isFinite(degrees) ? (degrees * Math.PI) / 180 : Math.atan2(towards.y - from[1], towards.x - from[0]);
    return { x: round(from[0] + length * Math.cos(angle)), y: round(from[1] + length * Math.sin(angle)), kind: "" };
  }

  cancel() {
    this.points = [];
    this.stage.preview = null;
    this.stage.redraw();
  }
}

export class LineTool extends DrawTool {
  /** @type {[string, string][]} */
  typing = [["length", "m"], ["angle", "°"]];

  /** @param {import("./editor.js").EditorPage} page
   * @param {boolean} goesOn whether each wall begins where the one before ended */
  constructor(page, goesOn) {
    super(page);
    this.goesOn = goesOn;
  }

  get says() {
    const what = this.goesOn ? "Click one end after another, or type lengths. Escape ends." : "Click both ends, or type the length.";
    return `${what} Shift: 15°. Alt: no snapping.`;
  }

  /** @param {Mark} mark */
  about(mark) {
    const from = this.points.at(-1);
    if (!from) return {};
    const wall = [from[0], from[1], mark.x, mark.y];
    return { walls: [wall], words: wordsOf(wall), at: [mark.x, mark.y] };
  }

  /** @param {Mark} mark */
  point({ x, y }) {
    const from = this.points.at(-1);
    if (!from) {
      this.points = [[x, y]];
      return;
    }
    if (from[0] === x && from[1] === y) {
      this.cancel();
      return;
    }
    this.page.edit("draw a wall", [{ op: "walls", add: [[from[0], from[1], x, y]] }]);
    this.points = this.goesOn ? [[x, y]] : [];
  }
}

export class RectangleTool extends DrawTool {
  /** @type {[string, string][]} */
  typing = [["across", "m"], ["up", "m"]];

  get says() {
    return "Click one corner, and the opposite one: four walls. Or type the sides. Alt: no snapping.";
  }

  /** The corner at typed distances [m] from the first, on the side of the pointer; one alone is both.
   * @param {number} across
   * @param {number} up */
  typedMark(across, up) {
    const from = this.points[0];
    const [wide, high] = [across, Number.isFinite(up) ? up : across];
    if (!from || !(wide > 0) || !(high > 0)) return null;
    const [right, above] = [(this.last?.x ?? from[0]) < from[0] ? -1 : 1, (this.last?.y ?? from[1]) < from[1] ? -1 : 1];
    return { x: round(from[0] + right * wide), y: round(from[1] + above * high), kind: "" };
  }

  /** @param {number[]} from
   * @param {{x: number, y: number}} to */
  sides(from, { x, y }) {
    const [x0, y0] = from;
    return [[x0, y0, x, y0], [x, y0, x, y], [x, y, x0, y], [x0, y, x0, y0]];
  }

  /** @param {Mark} mark */
  about(mark) {
    const from = this.points[0];
    if (!from) return {};
    const words = `${round(Math.abs(mark.x - from[0]))} × ${round(Math.abs(mark.y - from[1]))} m`;
    return { walls: this.sides(from, mark), words, at: [mark.x, mark.y] };
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {Held} event */
  snapped(place, event) {
    return this.stage.walls.snap(place, { ...this.page.snapping(event, null), isTurned: false });
  }

  /** @param {Mark} mark */
  point(mark) {
    const from = this.points[0];
    if (!from) {
      this.points = [[mark.x, mark.y]];
      return;
    }
    this.points = [];
    if (from[0] === mark.x || from[1] === mark.y) return;
    this.page.edit("draw a rectangle", [{ op: "walls", add: this.sides(from, mark) }]);
  }
}

const ERROR = 0.005; // [m] by which chords may lie within a circle, at most
const FEWEST = 12;

/** How many sides a circle of a radius [m] gets. */
const sidesOf = (/** @type {number} */ radius) => Math.max(FEWEST, 4 * Math.ceil(Math.PI / Math.acos(Math.max(0, 1 - ERROR / radius)) / 4));

export class CircleTool extends DrawTool {
  /** @type {[string, string][]} */
  typing = [["radius", "m"]];

  get says() {
    return "Click the centre, then a point of the circle; or type the radius. It is made of straight walls.";
  }

  /** @param {number[]} middle
   * @param {number} radius */
  chords(middle, radius) {
    const [x, y] = middle;
    const count = sidesOf(radius);
    const point = (/** @type {number} */ n) => [round(x + radius * Math.cos((2 * Math.PI * n) / count)), round(y + radius * Math.sin((2 * Math.PI * n) / count))];
    return Array.from({ length: count }, (_, n) => [...point(n), ...point((n + 1) % count)]);
  }

  /** @param {Mark} mark */
  about(mark) {
    const from = this.points[0];
    const radius = from ? Math.hypot(mark.x - from[0], mark.y - from[1]) : 0;
    if (!(radius > 0.01)) return {};
    const count = sidesOf(radius);
    const error = 1000 * radius * (1 - Math.cos(Math.PI / count));
    return { walls: this.chords(from, radius), words: `radius ${radius.toFixed(2)} m, ${count} walls, within ${error.toFixed(1)} mm`, at: [mark.x, mark.y] };
  }

  /** @param {Mark} mark */
  point({ x, y }) {
    const from = this.points[0];
    if (!from) {
      this.points = [[x, y]];
      return;
    }
    this.points = [];
    const radius = Math.hypot(x - from[0], y - from[1]);
    if (radius > 0.01) this.page.edit("draw a circle", [{ op: "walls", add: this.chords(from, radius) }]);
  }
}

export class MeasureTool extends DrawTool {
  get says() {
    return "Click two points: distance and angle, and how far the nearest wall is.";
  }

  /** @param {Mark} mark */
  about(mark) {
    const [from, to] = this.points;
    const clear = this.stage.walls.clearance(mark.x, mark.y);
    const far = Number.isFinite(clear) ? `nearest wall ${clear.toFixed(3)} m` : "";
    if (!from) return far ? { words: far, at: [mark.x, mark.y] } : {};
    const end = to ?? [mark.x, mark.y];
    const wall = [from[0], from[1], end[0], end[1]];
    return { walls: [wall], words: to || !far ? wordsOf(wall) : `${wordsOf(wall)}, ${far}`, at: end };
  }

  /** @param {Mark} mark */
  point({ x, y }) {
    this.points = this.points.length === 1 ? [...this.points, [x, y]] : [[x, y]];
    if (!this.stage.walls.walls.length) this.ask(x, y);
  }

  /** Say how far the nearest cell of a bitmap is: the page has walls alone.
   * @param {number} x
   * @param {number} y */
  async ask(x, y) {
    const said = await this.page.connection.ask({ do: "clearance", x, y });
    if (said.ok) this.page.hint(`nearest wall ${said.gap.toFixed(3)} m`);
  }
}
