// Grips: what can be taken hold of on the canvas besides bodies and walls. Points of paths, corners of boxes, mounts of sensors.

import { reach } from "../shared/footprint.js";
import { round } from "./geometry.js";
import { shapeGrips, viewGrips } from "./shape_grips.js";

const DEGREE = Math.PI / 180;
const HANDLE = 26; // pixels from a body's edge to the handle that turns it
const ARM = 44; // pixels from a sensor's mount to the grip that turns it

/**
 * Points of a thing that lie in the world, as `Place` in amorsim/ui/editor/inspectors/points.py.
 * @typedef {{path: string, kind: "path" | "point" | "box", points: number[][], closed: boolean}} PlaceOf
 */

/**
 * A grip at a point [m]. `drag` shows what it would do, `drop` is the change of the document and what it is called.
 * One that `isWhole` moves its thing as any other place of the thing does. One that `snaps` goes to the grid and to walls.
 * A double click on it `asks` for numbers; with Ctrl it is removed, where it can be.
 * @typedef {{x: number, y: number, shape: "round" | "small" | "square", thing: import("./stage.js").Thing, place?: PlaceOf, number?: number, isWhole?: boolean,
 *   drag: (to: {x: number, y: number}, isFree: boolean, event?: PointerEvent) => void, drop: () => {label: string, change?: any, changes?: any[]} | null,
 *   snaps?: boolean, asks?: import("./ask_numbers.js").Asks, remove?: () => {label: string, changes: any[]}}} Grip
 */

/** The legs of a path: pairs of points one after another, with the number of the second.
 * @param {PlaceOf} place */
export function legs({ kind, points, closed }) {
  if (kind === "box") {
    const [[x0, y0], [x1, y1]] = points;
    return [[[x0, y0], [x1, y0]], [[x1, y0], [x1, y1]], [[x1, y1], [x0, y1]], [[x0, y1], [x0, y0]]].map(([a, b]) => ({ a, b, number: -1 }));
  }
  const found = points.slice(1).map((b, n) => ({ a: points[n], b, number: n + 1 }));
  if (closed && points.length > 2) found.push({ a: points[points.length - 1], b: points[0], number: points.length });
  return found;
}

/** The grips of what is selected.
 * @param {import("./stage.js").EditStage} stage
 * @returns {Grip[]} */
export function gripsOf(stage) {
  const found = [];
  for (const thing of stage.chosenOnes) {
    for (const place of stage.placesOf(thing)) found.push(...pointGrips(stage, thing, place));
  }
  const [thing, ...others] = stage.chosenThings;
  if (thing && !others.length && !stage.chosenWalls.length) {
    if (stage.sensor) found.push(...mountGrips(stage, thing, stage.sensor), ...viewGrips(stage, thing, stage.sensor));
    else found.push(...shapeGrips(stage, thing));
  }
  return found;
}

/** @param {import("./stage.js").EditStage} stage
 * @param {import("./stage.js").Thing} thing
 * @param {PlaceOf} place
 * @returns {Grip[]} */
function pointGrips(stage, thing, place) {
  /** @param {number} number
   * @param {number[]} at
   * @param {boolean} isNew */
  const grip = (number, at, isNew) => {
    const [x, y] = at;
    /** @type {any} */
    /** @type {any} */
  let to = null;
    const drag = (/** @type {{x: number, y: number}} */ point) => {
      to = [round(point.x), round(point.y)];
      stage.bend(place.path, isNew ? [...place.points.slice(0, number), to, ...place.points.slice(number)] : place.points.map((one, n) => (n === number ? to : one)));
      stage.preview = { words: `${to[0]}, ${to[1]} m`, at: to };
    };
    const drop = () => to && { label: `${isNew ? "add" : "move"} a point of ${thing.name}`, change: { op: "point", path: place.path, number, value: to, ...(isNew ? { insert: true } : {}) } };
    const asks = {
      title: `A point of ${thing.name}`,
      fields: [["x", "m", x], ["y", "m", y]],
      change: (/** @type {number[]} */ values) => ({ label: `move a point of ${thing.name}`, changes: [{ op: "point", path: place.path, number, value: values, ...(isNew ? { insert: true } : {}) }] }),
    };
    return /** @type {Grip} */ ({ x, y, shape: isNew ? "small" : "round", thing, place, number, drag, drop, snaps: true, asks });
  };
  if (place.kind === "box") return boxGrips(stage, thing, place);
  const points = place.points.map((point, n) => grip(n, point, false));
  if (place.kind !== "path") return points;
  return [...points, ...legs(place).map(({ a, b, number }) => grip(number, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2], true))];
}

/** The corners of a box, and its middle, which moves all of it.
 * @param {import("./stage.js").EditStage} stage
 * @param {import("./stage.js").Thing} thing
 * @param {PlaceOf} place
 * @returns {Grip[]} */
function boxGrips(stage, thing, place) {
  const [[x0, y0], [x1, y1]] = place.points;
  /** @type {any} */
  let to = null;
  const show = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ c, /** @type {number} */ d) => {
    to = [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)].map(round);
    stage.bend(place.path, [to.slice(0, 2), to.slice(2)]);
    stage.preview = { words: `${round(to[2] - to[0])} × ${round(to[3] - to[1])} m`, at: to.slice(2) };
  };
  const drop = () => to && { label: `move the box of ${thing.name}`, change: { op: "set", path: place.path, value: to } };
  const grip = (/** @type {number} */ x, /** @type {number} */ y, /** @type {string} */ shape, /** @type {(point: {x: number, y: number}) => void} */ drag) => /** @type {Grip} */ ({ x, y, shape, thing, place, number: 0, drag, drop, snaps: true });
  return [
    ...[[x0, y0, x1, y1], [x1, y0, x0, y1], [x1, y1, x0, y0], [x0, y1, x1, y0]].map(([x, y, u, v]) => grip(x, y, "round", (point) => show(point.x, point.y, u, v))),
    { ...grip((x0 + x1) / 2, (y0 + y1) / 2, "square", () => {}), isWhole: true },
  ];
}

/** @param {import("./stage.js").EditStage} stage
 * @param {import("./stage.js").Thing} thing
 * @param {string} sensor
 * @returns {Grip[]} */
function mountGrips(stage, thing, sensor) {
  const body = stage.poseOf(thing);
  const mount = stage.mountOf(thing, sensor);
  if (!body || !mount) return [];
  const [c, s] = [Math.cos(body[2]), Math.sin(body[2])];
  const [x, y] = [body[0] + mount[0] * c - mount[1] * s, body[1] + mount[0] * s + mount[1] * c];
  const heading = body[2] + mount[2];
  const far = ARM / stage.camera.scale;
  /** @type {any} */
  let to = null;
  const show = (/** @type {number[]} */ pose, /** @type {string} */ words, /** @type {number[]} */ at) => {
    to = pose;
    stage.preview = { words, at };
    stage.mount(thing, sensor, pose);
  };
  const path = `${thing.path}.sensors.${sensor}`;
  const drop = (/** @type {(pose: number[]) => (number | null)[]} */ value, /** @type {string} */ verb) => to && { label: `${verb} ${sensor} of ${thing.name}`, change: { op: "mount", path, value: value(to) } };
  return [
    {
      x, y, shape: "square", thing,
      drag: (point, isFree) => {
        const [dx, dy] = [point.x - body[0], point.y - body[1]];
        const step = isFree ? 1e-4 : 0.01; // on a robot, centimetres count
        const [u, v] = [dx * c + dy * s, dy * c - dx * s].map((value) => round(Math.round(value / step) * step));
        show([u, v, mount[2]], `${sensor}: ${u} m ahead, ${v} m to the left`, [point.x, point.y]);
      },
      drop: () => drop(([u, v]) => [u, v, null], "mount"),
    },
    {
      x: x + far * Math.cos(heading), y: y + far * Math.sin(heading), shape: "round", thing,
      drag: (point, isFree) => {
        const step = (isFree ? 0.1 : 5) * DEGREE;
        const turn = Math.round((Math.atan2(point.y - y, point.x - x) - body[2]) / step) * step;
        const angle = Math.atan2(Math.sin(turn), Math.cos(turn));
        show([mount[0], mount[1], angle], `${sensor}: ${Math.round(angle / (0.1 * DEGREE)) / 10}°`, [point.x, point.y]);
      },
      drop: () => drop(([, , angle]) => [null, null, Math.round((angle / DEGREE) * 1e4) / 1e4], "turn"),
    },
  ];
}

/** Where the handle is that turns the one thing that is selected, or null.
 * @param {import("./stage.js").EditStage} stage */
export function turnHandle(stage) {
  const [thing, ...others] = stage.chosenThings;
  if (!thing?.turns || others.length || stage.chosenWalls.length || stage.sensor) return null;
  const pose = stage.poseOf(thing);
  if (!pose) return null;
  const far = reach(thing.footprint) + HANDLE / stage.camera.scale;
  return { thing, from: pose, x: pose[0] + far * Math.cos(pose[2]), y: pose[1] + far * Math.sin(pose[2]) };
}

/** The ends of the one wall that is selected.
 * @param {import("./stage.js").EditStage} stage */
export function wallHandles(stage) {
  const walls = stage.chosenWalls;
  if (walls.length !== 1 || stage.selection.things.length !== 1 || stage.preview?.walls) return [];
  const [a, b, c, d] = stage.walls.walls[walls[0]];
  return [[a, b], [c, d]];
}
