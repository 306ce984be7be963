// The Editor's canvas: what can be drawn of the document, what is selected, and what a tool is about to do.

import { there } from "../shared/dom.js";
import { mapOf } from "../shared/scene.js";
import { StillStage, stillFrame } from "../shared/still.js";
import { Walls, isIn } from "./geometry.js";
import { startsOf } from "./ghosts.js";
import { gripsOf } from "./grips.js";
import { thingAt } from "./picking.js";
import { WIDE } from "./rulers.js";
import { EditSight } from "./sight.js";
import { arrangeLayers } from "./stage_layers.js";
import { UnderlayLayer } from "./underlay.js";

/** @typedef {import("../shared/tool.js").Place} Place */

/**
 * A thing of the document, as `Thing` in amorsim/ui/editor/inspectors/things.py.
 * @typedef {{path: string, kind: string, name: string, note: string, footprint: import("../simulator/messages.d.ts").Outline | null, pose: number[] | null,
 *   shape: string, moves: boolean, turns: boolean, robots: number[], obstacles: number[], places: import("./grips.js").PlaceOf[],
 *   mounts: {sensor: string, pose: number[], range_max: number | null, opening: number | null, key: string}[], faults: number}} Thing
 */

/**
 * What is selected: a thing by its path, or a wall by its number.
 * @typedef {import("../shared/pick.js").Found & {path?: string, wall?: number}} Chosen
 */

const NOWHERE = [NaN, NaN, NaN];

/**
 * The canvas of the Editor. What stands still is drawn into a bitmap; what is dragged, or plays, is drawn above it, frame by frame.
 */
export class EditStage extends StillStage {
  /** @param {HTMLElement} root */
  constructor(root) {
    super(root, { id: "pane", label: "The scenario", picked: () => {} });
    /** @type {Thing[]} */
    this.things = [];
    /** @type {Map<string, Thing>} */
    this.byPath = new Map();
    this.walls = new Walls([], [0, 0, 1, 1]);
    this.sight = new EditSight(this);
    /** What a tool is about to do. @type {any} */
    this.preview = null;
    /** Where things are while they are dragged, by path. @type {Map<string, number[]>} */
    this.moved = new Map();
    /** Points of paths while one of them is dragged, by the path of the list. @type {Map<string, number[][]>} */
    this.bent = new Map();
    /** Mounts while they are dragged, by robot and sensor. @type {Map<string, number[]>} */
    this.mounted = new Map();
    /** Where bodies are that are dragged, or play; all others are nowhere. @type {ReturnType<typeof stillFrame> | null} */
    this.carried = null;
    /** What was painted and is not part of the map's picture yet. @type {{cells: any, isKept: boolean, isRead: boolean}[]} */
    this.strokes = [];
    /** Where those start that are placed at random, by name. @type {Map<string, number[]>} */
    this.ghosts = new Map();
    this.sensor = ""; // whose mount can be dragged
    /** By how much the view of a sensor is stretched while it is dragged: its range and its angle. @type {{sensor: string, range: number, angle: number} | null} */
    this.stretched = null;
    /** Asks for the numbers of a grip. @param {import("./ask_numbers.js").Asks} _asks */
    this.ask = (_asks) => {};
    this.hidden = new Set(); // kinds of things that are hidden
    this.locked = new Set(); // and those that cannot be picked
    this.pane.edge = WIDE;
    this.underlay = new UnderlayLayer();
    arrangeLayers(this);
  }

  /** Show what was read of the document; what is selected stays so, by its path.
   * @param {{still: import("../simulator/messages.d.ts").Still | null, things: Thing[]}} drawn
   * @param {(name: string) => Promise<string | null>} pictureOf */
  update({ still, things }, pictureOf) {
    const chosen = this.selection.things;
    this.things = things;
    this.byPath = new Map(things.map((thing) => [thing.path, thing]));
    this.drop();
    const listeners = this.selection.listeners;
    this.selection.listeners = []; // so that no listener hears of the empty selection meanwhile
    this.show(still, pictureOf);
    this.selection.listeners = listeners;
    /** The scene with all that is in it, where some is hidden. @type {any} */
    this.whole = undefined;
    if (this.hidden.size) this.hide();
    this.walls = new Walls(mapOf(still?.scene)?.segments ?? [], still?.extent ?? [0, 0, 1, 1]);
    this.selection.set(chosen.flatMap((one) => this.again(/** @type {Chosen} */ (one))));
  }

  pictureCame() {
    this.strokes = this.strokes.filter(({ isRead }) => !isRead);
    super.pictureCame();
  }

  /** @param {Chosen} one
   * @returns {Chosen[]} */
  again(one) {
    if (one.path !== undefined) {
      const thing = this.byPath.get(one.path);
      return thing ? [this.chosenOf(thing)] : [];
    }
    return one.wall !== undefined && one.wall < this.walls.walls.length ? [this.chosenWall(one.wall)] : [];
  }

  /** @param {Thing} thing
   * @returns {Chosen} */
  chosenOf(thing) {
    return { kind: thing.kind, key: thing.path, path: thing.path, title: thing.name, lines: [thing.note] };
  }

  /** @param {number} n
   * @returns {Chosen} */
  chosenWall(n) {
    return { kind: "wall", key: `wall ${n}`, wall: n, title: "wall", lines: [], view: "true", line: this.walls.walls[n] };
  }

  /** The things that are selected. */
  get chosenThings() {
    return this.chosenOnes.filter(({ footprint }) => footprint);
  }

  /** Those of them that stand somewhere. */
  get standing() {
    return this.chosenThings.flatMap(({ pose, ...thing }) => (pose ? [{ ...thing, pose }] : []));
  }

  /** The same, with those that have no place of their own. */
  get chosenOnes() {
    return this.selection.things.flatMap((one) => this.byPath.get(/** @type {Chosen} */ (one).path ?? "") ?? []);
  }

  /** The points of a thing in the world, as they are or are being dragged.
   * @param {Thing} thing */
  placesOf(thing) {
    return this.bent.size ? thing.places.map((place) => ({ ...place, points: this.bent.get(place.path) ?? place.points })) : thing.places;
  }

  /** Where a sensor sits on a robot, or is being dragged to: x, y [m] and heading [rad].
   * @param {Thing} thing
   * @param {string} sensor */
  mountOf(thing, sensor) {
    return this.mounted.get(`${thing.path} ${sensor}`) ?? thing.mounts.find((one) => one.sensor === sensor)?.pose;
  }

  /** What can be taken hold of. */
  grips() {
    return gripsOf(this);
  }

  /** The numbers of the walls that are selected. */
  get chosenWalls() {
    return this.selection.things.flatMap((one) => /** @type {Chosen} */ (one).wall ?? []);
  }

  /** Where a thing is, or is being dragged to.
   * @param {Thing} thing */
  poseOf(thing) {
    return this.moved.get(thing.path) ?? thing.pose;
  }

  /** Draw a thing elsewhere, before the document says so.
   * @param {Thing} thing
   * @param {number[]} pose */
  place(thing, pose) {
    if (!this.moved.has(thing.path)) this.touch();
    this.moved.set(thing.path, pose);
    if (thing.robots.length === 1) this.carry("truePoses", thing.robots[0], pose);
    if (thing.obstacles.length === 1) this.carry("obstacles", thing.obstacles[0], pose);
    this.redraw();
  }

  /** Draw a body at a pose above what stands still, until all is put back or read again.
   * @param {"truePoses" | "obstacles"} which
   * @param {number} n
   * @param {ArrayLike<number>} pose */
  carry(which, n, pose) {
    if (!this.frame) return;
    if (!this.carried) {
      this.carried = stillFrame(there(this.still));
      this.carried.truePoses.fill(NaN);
      this.carried.obstacles.fill(NaN);
    }
    this.carried[which].set(pose, 3 * n);
    if (Number.isNaN(this.frame[which][3 * n])) return;
    this.frame[which].set(NOWHERE, 3 * n);
    this.touch();
  }

  /** Draw the points of a path, a box or the like elsewhere.
   * @param {string} path of the list
   * @param {number[][]} points */
  bend(path, points) {
    if (!this.bent.has(path)) this.touch();
    this.bent.set(path, points);
    this.redraw();
  }

  /** Draw a sensor mounted elsewhere.
   * @param {Thing} thing
   * @param {string} sensor
   * @param {number[]} pose */
  mount(thing, sensor, pose) {
    const key = `${thing.path} ${sensor}`;
    if (!this.mounted.has(key)) this.touch();
    this.mounted.set(key, pose);
    this.redraw();
  }

  /** Draw what a sensor sees larger or smaller.
   * @param {string} sensor
   * @param {number} range a factor
   * @param {number} angle a factor */
  stretch(sensor, range, angle) {
    this.stretched = { sensor, range, angle };
    this.touch();
  }

  /** A double click on a grip asks for its numbers; elsewhere it shows all.
   * @param {MouseEvent} event */
  doubleClicked(event) {
    const { x, y } = this.pane.placeOf(event);
    const grip = this.grips().find((one) => Math.hypot(one.x - x, one.y - y) <= 9 / this.camera.scale);
    if (grip?.asks) this.ask(grip.asks);
    else super.doubleClicked(event);
  }

  /** Hold nothing any more. */
  drop() {
    this.stretched = null;
    for (const drag of [this.moved, this.bent, this.mounted]) drag.clear();
    this.carried = null;
  }

  /** Draw everything where the document says. */
  putBack() {
    this.drop();
    this.preview = null;
    this.settle();
  }

  /** What lies at a point: the smallest body, or else a wall.
   * @param {{x: number, y: number}} point
   * @returns {Chosen | null} */
  at(point) {
    return thingAt(this, point);
  }

  /** Leave out what is hidden; walls and the floor are drawn again, too. */
  hide() {
    const { still } = this;
    if (!still || !this.frame) return;
    this.whole ??= this.scene;
    const floor = this.whole.floor;
    const kept = (/** @type {string} */ kind, /** @type {any} */ value) => (this.hidden.has(kind) ? [] : value);
    this.scene = {
      ...this.whole,
      map: this.hidden.has("wall") ? undefined : this.whole.map,
      floor: { ...floor, landmarks: kept("landmark", floor.landmarks), lights: kept("light", floor.lights), zones: kept("zone", floor.zones) },
    };
    this.pictures.version += 1;
    this.settle();
  }

  /** Put bodies where they stand, but for those that are hidden or carried. */
  settle() {
    const { still, frame, carried, hidden } = this;
    if (still && frame) {
      const put = (/** @type {"truePoses" | "obstacles"} */ which, /** @type {(number[] | null)[]} */ poses, /** @type {(i: number) => string} */ kindOf) => poses.forEach((pose, i) => {
        const isElsewhere = hidden.has(kindOf(i)) || (carried && !Number.isNaN(carried[which][3 * i]));
        frame[which].set(isElsewhere || !pose ? NOWHERE : pose, 3 * i);
      });
      put("truePoses", still.robots, () => "robot");
      put("obstacles", still.obstacles, (i) => (still.scene.obstacles[i].part_of ? "robot" : "obstacle"));
    }
    this.touch();
  }

  /** @param {string} kind */
  isFree(kind) {
    return !this.locked.has(kind) && !this.hidden.has(kind);
  }

  /** All that lies in a box.
   * @param {number[]} box
   * @returns {Chosen[]} */
  within(box) {
    const [x0, y0, x1, y1] = box;
    /** @param {number[]} point */
    const isInside = ([x, y]) => x >= x0 && x <= x1 && y >= y0 && y <= y1;
    const things = this.things.filter((thing) => {
      const points = thing.pose ? (thing.moves ? [thing.pose] : []) : startsOf(thing).flatMap((place) => place.points);
      return points.length && this.isFree(thing.kind) && points.every(isInside);
    });
    const walls = this.isFree("wall") ? this.walls.walls.flatMap((wall, n) => (isIn(wall, box) ? [this.chosenWall(n)] : [])) : [];
    return [...things.map((thing) => this.chosenOf(thing)), ...walls];
  }
}
