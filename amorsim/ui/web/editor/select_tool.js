// The tool that selects, moves and turns things: by click, box, drag and arrow keys.

import { there } from "../shared/dom.js";
import { Tool } from "../shared/tool.js";
import { round, wordsOf } from "./geometry.js";
import { placeChange, shifted, startsOf } from "./ghosts.js";
import { turnHandle, wallHandles } from "./grips.js";
import { poseChange } from "./poses.js";
import { turn } from "./reshape.js";

const STILL = 4; // pixels that a click may move
const DEGREE = Math.PI / 180;

export class SelectTool extends Tool {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    super();
    this.page = page;
    this.stage = page.stage;
    /** What the pointer does: "press", "move", "turn", "end", "grip" or "box". */
    this.doing = "";
    this.from = { x: 0, y: 0, left: 0, top: 0 }; // where the pointer went down
  }

  get cursor() {
    return this.doing === "move" ? "grabbing" : this.doing === "turn" ? "crosshair" : "default";
  }

  get says() {
    if (this.stage.chosenOnes.some(({ places }) => places.some(({ kind }) => kind === "path"))) return "Drag a point of the path; drag a small one to add a point; Ctrl and a click removes one.";
    if (this.stage.chosenThings.length === 1 && this.stage.chosenThings[0].shape) return "Drag a corner to resize (Shift: in proportion, Ctrl: about the middle); a double click on it asks for numbers. Drag the dot to turn.";
    return "Click selects, Shift adds. Drag moves; drag the dot to turn. Drag over nothing: a box. Alt: no snapping.";
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event */
  down(place, event) {
    const { stage } = this;
    this.from = place;
    this.isMoved = false;
    this.doing = "press";
    const near = 9 / stage.camera.scale;
    const handle = turnHandle(stage);
    const end = wallHandles(stage).findIndex(([x, y]) => Math.hypot(x - place.x, y - place.y) <= near);
    if (this.page.isHolder && handle && Math.hypot(handle.x - place.x, handle.y - place.y) <= near) {
      this.doing = "turn";
      return;
    }
    if (this.page.isHolder && end >= 0 && !this.page.wallsFixed) {
      this.doing = "end";
      this.end = end;
      return;
    }
    if (this.page.isHolder && this.takeGrip(place, event, near)) return;
    this.found = stage.at(place);
    const isChosen = this.found && stage.selection.has(this.found.kind, this.found.key);
    if (this.found && !isChosen) stage.selection.set(event.shiftKey ? [...stage.selection.things, this.found] : [this.found]);
    else if (isChosen && event.shiftKey) stage.selection.set(stage.selection.things.filter(({ key }) => key !== this.found?.key));
  }

  /** Take hold of a grip that lies under the pointer; with Ctrl, a point of a path is removed.
   * @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event
   * @param {number} near */
  takeGrip(place, event, near) {
    const under = (/** @type {import("./grips.js").Grip} */ one) => Math.hypot(one.x - place.x, one.y - place.y) <= near;
    this.grip = this.stage.grips().find(under);
    const [thing] = this.stage.chosenThings;
    // Of a body that stands on a point of its own path, the body is meant.
    if (!this.grip || (this.grip.place && thing?.pose && Math.hypot(thing.pose[0] - this.grip.x, thing.pose[1] - this.grip.y) < near / 2)) return false;
    const { place: list, number, shape } = this.grip;
    if (this.grip.isWhole) {
      this.found = this.stage.chosenOf(this.grip.thing);
      return true;
    }
    if (event.ctrlKey && this.grip.remove) {
      this.doing = "";
      const { label, changes } = this.grip.remove();
      this.page.edit(label, changes);
      return true;
    }
    if (event.ctrlKey && list?.kind === "path" && shape === "round") {
      this.doing = "";
      if (list.points.length > 1) this.page.edit(`remove a point of ${this.grip.thing.name}`, [{ op: "remove", path: `${list.path}.${number}` }]);
      return true;
    }
    this.doing = "grip";
    return true;
  }

  /** @param {import("../shared/tool.js").Place} place
   * @param {PointerEvent} event */
  move(place, event) {
    if (!this.doing) return;
    const { stage } = this;
    this.isMoved ||= Math.abs(place.left - this.from.left) + Math.abs(place.top - this.from.top) > STILL;
    if (!this.isMoved) return;
    if (this.doing === "press") this.doing = this.found ? "move" : "box";
    if (this.doing === "move" && !this.page.isHolder) return;
    if (this.doing === "grip") {
      const grip = there(this.grip);
      const to = grip.snaps ? stage.walls.snap(place, { ...this.page.snapping(event, null), isTurned: false }) : place;
      grip.drag(to, event.altKey, event);
      return;
    }
    if (this.doing === "box") {
      const [a, b, c, d] = [this.from.x, this.from.y, place.x, place.y];
      stage.preview = { box: [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)] };
      stage.redraw();
    } else if (this.doing === "move") this.shift(place.x - this.from.x, place.y - this.from.y, event.altKey);
    else if (this.doing === "turn") {
      const [thing] = stage.chosenThings;
      const [x, y] = there(thing.pose);
      const angle = Math.atan2(place.y - y, place.x - x);
      const step = event.altKey ? 0.1 * DEGREE : 5 * DEGREE;
      const heading = Math.round(angle / step) * step;
      stage.place(thing, [x, y, heading]);
      stage.preview = { words: `${Math.round(heading / (0.1 * DEGREE)) / 10}°`, at: [place.x, place.y] };
    } else if (this.doing === "end") {
      const wall = [...stage.walls.walls[stage.chosenWalls[0]]];
      const other = this.end ? [wall[0], wall[1]] : [wall[2], wall[3]];
      const mark = stage.walls.snap(place, this.page.snapping(event, other));
      wall.splice(2 * (this.end ?? 0), 2, mark.x, mark.y);
      stage.preview = { walls: [wall], mark, words: wordsOf(wall), at: [mark.x, mark.y], wall };
      stage.redraw();
    }
  }

  /** Draw what is selected shifted by so much, on the grid by what was pressed.
   * @param {number} dx
   * @param {number} dy
   * @param {boolean} isFree */
  shift(dx, dy, isFree) {
    const { stage } = this;
    const things = stage.standing.filter(({ moves }) => moves);
    const walls = this.page.wallsFixed ? [] : stage.chosenWalls;
    const starts = stage.chosenOnes.flatMap((thing) => startsOf(thing));
    const base = things[0]?.pose ?? stage.walls.walls[walls[0]] ?? starts[0]?.points[0];
    if (!base) return;
    const grid = isFree ? 0 : this.page.grid;
    // What is moved along one axis keeps its place along the other, be it on the grid or not.
    const onto = (/** @type {number} */ value, /** @type {number} */ shift) => (!grid ? shift : Math.abs(shift) < grid / 2 ? 0 : Math.round((value + shift) / grid) * grid - value);
    const [right, up] = [round(onto(base[0], dx)), round(onto(base[1], dy))];
    for (const thing of things) stage.place(thing, [round(thing.pose[0] + right), round(thing.pose[1] + up), thing.pose[2]]);
    for (const place of starts) stage.bend(place.path, shifted(place, right, up));
    const lines = walls.map((n) => stage.walls.walls[n].map((value, k) => round(value + (k % 2 ? up : right))));
    stage.preview = { walls: lines, numbers: walls, words: `${round(right)}, ${round(up)} m`, at: [base[0] + right, base[1] + up] };
    stage.redraw();
  }

  /** @param {import("../shared/tool.js").Place} _place
   * @param {PointerEvent} event */
  up(_place, event) {
    const { stage } = this;
    const { doing, isMoved } = this;
    this.doing = "";
    if (!isMoved) {
      if (doing === "press" && !this.found && !event.shiftKey) stage.selection.clear();
      return;
    }
    if (doing === "grip") {
      const dropped = there(this.grip).drop();
      if (dropped) this.page.edit(dropped.label, dropped.changes ?? [dropped.change]);
      else stage.putBack();
      return;
    }
    if (doing === "box") {
      const found = stage.within(stage.preview.box);
      stage.preview = null;
      const kept = event.shiftKey ? stage.selection.things.filter(({ key }) => !found.some((one) => one.key === key)) : [];
      stage.selection.set([...kept, ...found]);
      stage.redraw();
      return;
    }
    this.commit(doing);
  }

  /** Change the document to what is drawn.
   * @param {any} doing */
  commit(doing) {
    const { stage } = this;
    const changes = [];
    for (const thing of stage.chosenThings) {
      const pose = stage.moved.get(thing.path);
      if (pose) changes.push(poseChange(thing, pose));
    }
    for (const place of stage.chosenOnes.flatMap((thing) => startsOf(thing))) {
      const points = stage.bent.get(place.path);
      if (points) changes.push(placeChange(place, points));
    }
    const { preview } = stage;
    if (doing === "end" && preview?.wall) changes.push({ op: "walls", change: [[stage.chosenWalls[0], preview.wall]] });
    else if (preview?.numbers?.length) changes.push({ op: "walls", change: preview.numbers.map((/** @type {number} */ n, /** @type {number} */ k) => [n, preview.walls[k]]) });
    const [thing, ...others] = stage.chosenOnes;
    const what = thing && !others.length && !preview?.numbers?.length ? thing.name : !thing && stage.chosenWalls.length === 1 ? "a wall" : "what was selected";
    if (changes.length) this.page.edit(`${doing === "turn" ? "turn" : "move"} ${what}`, changes);
    else stage.putBack();
  }

  cancel() {
    this.doing = "";
    this.stage.putBack();
  }

  /** @param {KeyboardEvent} event
   * @param {import("../shared/tool.js").Place} place */
  key(event, place) {
    const { stage, page } = this;
    const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (event.ctrlKey || event.metaKey) return false;
    if (steps && !event.shiftKey && stage.selection.things.length && page.isHolder) {
      const step = event.altKey ? 0.01 : page.grid || 0.1;
      this.shift(steps[0] * step, steps[1] * step, true);
      this.commit("move");
      return true;
    }
    if ((event.key === "[" || event.key === "]") && page.isHolder) {
      const angle = (event.key === "[" ? 5 : -5) * DEGREE;
      if (stage.chosenWalls.length) {
        turn(page, angle);
        return true;
      }
      for (const thing of stage.standing.filter(({ turns }) => turns)) {
        stage.place(thing, [thing.pose[0], thing.pose[1], thing.pose[2] + angle]);
      }
      this.commit("turn");
      return true;
    }
    if (event.key === "Enter") {
      const found = stage.at(place);
      stage.selection.set(found ? [found] : []);
      return true;
    }
    return false;
  }
}
