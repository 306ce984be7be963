// Tools for rooms, doors and openings, and for trimming walls at their crossings.

import { there } from "../shared/dom.js";
import { RectangleTool, DrawTool } from "./draw_tools.js";
import { freeName } from "./things.js";
import { alongOf, cut, lengthOf, opening, pointAt, stretch, withOpening } from "./wall_work.js";

const REACH = 22; // pixels

/** Two corners, and where the opening is: Escape leaves the room closed. */
export class RoomTool extends RectangleTool {
  /** @param {number} across
   * @param {number} up */
  typedMark(across, up) {
    return this.corner ? null : super.typedMark(across, up);
  }

  get says() {
    return this.corner ? "Click where the opening is; Escape: none." : "Click one corner of the room, and the opposite one.";
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  sidesNow(mark) {
    const [from] = this.points;
    return this.sides(from, this.corner ?? mark);
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    if (!this.points.length) return {};
    if (!this.corner) return super.about(mark);
    const walls = withOpening(this.sidesNow(mark), mark, this.page.width);
    return { walls, words: `opening ${this.page.width} m`, at: [mark.x, mark.y] };
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {import("./draw_tools.js").Held} event */
  snapped(place, event) {
    return this.corner ? { x: place.x, y: place.y, kind: "" } : super.snapped(place, event);
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  point(mark) {
    if (!this.points.length) {
      this.points = [[mark.x, mark.y]];
      return;
    }
    if (!this.corner) {
      const [[x, y]] = this.points;
      if (x === mark.x || y === mark.y) return;
      this.corner = mark;
      this.page.showTool(this);
      return;
    }
    this.finish(mark);
  }

  /** @param {import("./draw_tools.js").Mark | null} mark */
  finish(mark) {
    const walls = withOpening(this.sidesNow(there(this.corner)), mark, this.page.width);
    this.cancel();
    this.page.showTool(this);
    this.page.edit("draw a room", [{ op: "walls", add: walls }]);
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} place */
  key(event, place) {
    if (event.key !== "Escape" || !this.corner) return super.key(event, place);
    this.finish(null);
    return true;
  }

  cancel() {
    this.corner = null;
    super.cancel();
  }
}

/** An opening in a wall, with a door in it or none: the wall is cut. */
export class DoorTool extends DrawTool {
  get says() {
    return this.page.door === "opening" ? "Click on a wall: it gets an opening there." : "Click on a wall: it gets an opening there, with a door in it.";
  }

  /** The wall under the pointer, and the part that the opening takes.
   * @param {import("./draw_tools.js").Mark} mark */
  snapped({ x, y }) {
    const { walls } = this.stage;
    const n = walls.nearest(x, y, REACH / this.stage.camera.scale);
    if (n < 0) return { x, y, kind: "", n };
    const [from, to] = opening(walls.walls[n], alongOf(walls.walls[n], x, y), this.page.width);
    const [u, v] = pointAt(walls.walls[n], (from + to) / 2);
    return { x: u, y: v, kind: "wall", n, from, to };
  }

  /** @param {any} part */
  about({ n, from, to, x, y }) {
    if (n < 0 || from === undefined) return {};
    const wall = this.stage.walls.walls[n];
    return { walls: [[...pointAt(wall, from), ...pointAt(wall, to)]], words: `${(to - from).toFixed(2)} m, ${from.toFixed(2)} m from its end`, at: [x, y] };
  }

  /** @param {any} part */
  point({ n, from, to }) {
    const wall = this.stage.walls.walls[n];
    if (!wall) {
      this.page.hint("click on a wall");
      return;
    }
    if (this.page.door !== "opening" && to - from < 0.3) {
      this.page.hint("this wall is too short for a door");
      return;
    }
    const [first, ...rest] = cut(wall, from, to);
    const changes = /** @type {any[]} */ ([first ? { op: "walls", change: [[n, first]], add: rest } : { op: "walls", remove: [n] }]);
    if (this.page.door !== "opening") changes.unshift({ op: "add", path: "obstacles", value: doorIn(wall, from, to, this.page.door, this.stage.things) });
    this.page.edit(`put ${this.page.door === "opening" ? "an opening" : "a door"} into a wall`, changes).then((said) => {
      if (said.ok && said.added.length) this.page.choose(said.added);
    });
  }
}

/** The obstacle that is a door in an opening of a wall.
 * @param {number[]} wall
 * @param {number} from
 * @param {number} to
 * @param {string} kind
 * @param {import("./stage.js").Thing[]} things */
function doorIn(wall, from, to, kind, things) {
  const wide = to - from;
  const angle = Math.round(((Math.atan2(wall[3] - wall[1], wall[2] - wall[0]) * 180) / Math.PI) * 1e4) / 1e4;
  const name = freeName("door", things);
  const exact = (/** @type {number} */ value) => Math.round(value * 1e4) / 1e4;
  if (kind === "sliding") { // along the wall, next to it
    const [x, y] = pointAt(wall, (from + to) / 2);
    const [u, v] = [-(wall[3] - wall[1]) / lengthOf(wall), (wall[2] - wall[0]) / lengthOf(wall)];
    const pose = { x: exact(x + 0.06 * u), y: exact(y + 0.06 * v), heading_deg: angle };
    return { name, shape: { rectangle: [exact(wide + 0.1), 0.04] }, pose, motion: { use: "sliding_door", timetable: [[5, 15]], period: 20, way: [exact(wide + 0.1), 0] } };
  }
  const leaf = exact(wide - 0.1);
  const [x, y] = pointAt(wall, from + 0.03);
  return { name, shape: { rectangle: [leaf, 0.04], x: exact(leaf / 2 + 0.02) }, pose: { x, y, heading_deg: angle }, motion: { use: "swing_door", timetable: [[5, 15]], period: 20, blocked: "skip" } };
}

/** Takes away the part of a wall between two crossings. */
export class TrimTool extends DrawTool {
  get says() {
    return "Click a part of a wall to remove it, up to the walls that cross it.";
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  snapped({ x, y }) {
    const { walls } = this.stage;
    const n = walls.nearest(x, y, REACH / this.stage.camera.scale);
    if (n < 0) return { x, y, kind: "", n };
    const wall = walls.walls[n];
    const others = walls.walls.filter((_, k) => k !== n);
    const [from, to] = stretch(wall, others, alongOf(wall, x, y));
    return { x, y, kind: "", n, from, to };
  }

  /** @param {any} part */
  about({ n, from, to, x, y }) {
    if (n < 0 || from === undefined) return {};
    const wall = this.stage.walls.walls[n];
    return { walls: [[...pointAt(wall, from), ...pointAt(wall, to)]], words: `less ${(to - from).toFixed(2)} m`, at: [x, y] };
  }

  /** @param {any} part */
  point({ n, from, to }) {
    const wall = this.stage.walls.walls[n];
    if (!wall) return;
    const [first, ...rest] = cut(wall, from, to);
    this.page.edit("trim a wall", [first ? { op: "walls", change: [[n, first]], add: rest } : { op: "walls", remove: [n] }]);
  }
}

/** A box that is drawn with two clicks, or by dragging; `done` gets its corners. */
export class BoxTool extends DrawTool {
  /** @param {import("./editor.js").EditorPage} page
   * @param {string} says
   * @param {(box: number[]) => void} done */
  constructor(page, says, done) {
    super(page);
    this.words = says;
    this.done = done;
  }

  get says() {
    return this.words;
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  boxTo({ x, y }) {
    const [[a, b]] = this.points;
    return [Math.min(a, x), Math.min(b, y), Math.max(a, x), Math.max(b, y)];
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    if (!this.points.length) return {};
    const box = this.boxTo(mark);
    return { box, words: `${(box[2] - box[0]).toFixed(2)} × ${(box[3] - box[1]).toFixed(2)} m`, at: [mark.x, mark.y] };
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {import("./draw_tools.js").Held} event */
  snapped(place, event) {
    return this.stage.walls.snap(place, { ...this.page.snapping(event, null), isTurned: false });
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  point(mark) {
    if (!this.points.length) this.points = [[mark.x, mark.y]];
    else this.finish(mark);
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event */
  up(place, event) {
    const [from] = this.points;
    const mark = from && this.snapped(place, event);
    if (from && Math.hypot(mark.x - from[0], mark.y - from[1]) * this.stage.camera.scale > 8) this.finish(mark);
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  finish(mark) {
    const box = this.boxTo(mark);
    this.cancel();
    if (box[2] > box[0] && box[3] > box[1]) this.done(box);
  }
}
