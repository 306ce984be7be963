// Grips of shapes: the corners of a rectangle, the vertices of a polygon, the rim of a circle; and of what a sensor sees.

import { there } from "../shared/dom.js";
import { poseChange } from "./poses.js";
import { round } from "./geometry.js";

const LEAST = 0.01; // [m] of a side
const DEGREE = Math.PI / 180;
const CENTIMETRE = 0.01;

/** @typedef {import("./grips.js").Grip} Grip */
/** @typedef {import("./stage.js").EditStage} EditStage */
/** @typedef {import("./stage.js").Thing} Thing */

/** A point of a thing's own frame in the world.
 * @param {number[]} pose
 * @param {number} u
 * @param {number} v */
const outside = ([x, y, heading], u, v) => [x + u * Math.cos(heading) - v * Math.sin(heading), y + u * Math.sin(heading) + v * Math.cos(heading)];

/** A point of the world in a thing's own frame.
 * @param {number[]} pose
 * @param {{x: number, y: number}} point */
function inside([x, y, heading], point) {
  const [dx, dy] = [point.x - x, point.y - y];
  return [dx * Math.cos(heading) + dy * Math.sin(heading), dy * Math.cos(heading) - dx * Math.sin(heading)];
}

/** The grips of a thing's shape, where the file gives it one.
 * @param {EditStage} stage
 * @param {Thing} thing
 * @returns {Grip[]} */
export function shapeGrips(stage, thing) {
  if (!thing.shape || !thing.pose || !thing.footprint || !thing.moves || stage.moved.has(thing.path)) return [];
  if (thing.shape === "circle") return [rimGrip(stage, thing)];
  return thing.shape === "rectangle" ? cornerGrips(stage, thing) : vertexGrips(stage, thing);
}

/** What a new shape is in the document: the shape, and where it moves its thing that pose.
 * @param {Thing} thing
 * @param {any} shape
 * @param {number[]} [pose] */
const change = (thing, shape, pose) => ({
  label: `reshape ${thing.name}`,
  changes: [{ op: "set", path: `${thing.path}.shape`, value: shape }, ...(pose ? [poseChange(thing, pose)] : [])],
});

/** @param {EditStage} stage
 * @param {Thing} thing
 * @returns {Grip} */
function rimGrip(stage, thing) {
  const pose = there(thing.pose);
  const before = there(thing.footprint?.circle);
  let radius = before;
  const [x, y] = [pose[0], pose[1] - before]; // below, where the handle that turns is not
  const drag = (/** @type {{x: number, y: number}} */ point) => {
    radius = Math.max(LEAST, round(Math.hypot(point.x - pose[0], point.y - pose[1])));
    stage.preview = { bodies: [{ footprint: { circle: radius }, pose }], words: `radius ${radius} m`, at: [point.x, point.y] };
    stage.redraw();
  };
  const asks = { title: `Size of ${thing.name}`, fields: [["radius", "m", before]], change: (/** @type {number[]} */ [typed]) => change(thing, { circle: typed }), isRight: (/** @type {number[]} */ [typed]) => typed > 0 };
  return { x, y, shape: "round", thing, snaps: true, drag, drop: () => change(thing, { circle: radius }), asks };
}

/** @param {EditStage} stage
 * @param {Thing} thing
 * @returns {Grip[]} */
function cornerGrips(stage, thing) {
  const pose = there(thing.pose);
  const points = there(thing.footprint?.polygon);
  const [long, wide] = [0, 1].map((k) => Math.max(...points.map((point) => point[k])) - Math.min(...points.map((point) => point[k])));
  const asks = {
    title: `Size of ${thing.name}`,
    fields: [["length", "m", round(long)], ["width", "m", round(wide)]],
    change: (/** @type {number[]} */ typed) => change(thing, { rectangle: typed }),
    isRight: (/** @type {number[]} */ typed) => typed.every((side) => side > 0),
  };
  // A corner has both signs, the middle of a side one.
  const signs = [[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 0], [-1, 0], [0, 1], [0, -1]];
  return signs.map(([ahead, left]) => {
    /** @type {any} */
    let to = null;
    const drag = (/** @type {{x: number, y: number}} */ point, /** @type {boolean} */ _isFree, /** @type {PointerEvent} */ event) => {
      const [u, v] = inside(pose, point);
      const isCentred = event?.ctrlKey;
      const grown = (/** @type {number} */ before, /** @type {number} */ sign, /** @type {number} */ at) => (!sign ? before : Math.max(LEAST, isCentred ? 2 * sign * at : sign * at + before / 2));
      let sides = [grown(long, ahead, u), grown(wide, left, v)];
      if (event?.shiftKey && ahead && left) {
        const factor = Math.max(sides[0] / long, sides[1] / wide);
        sides = [long * factor, wide * factor];
      }
      sides = sides.map(round);
      const middle = isCentred ? [0, 0] : [(ahead * (sides[0] - long)) / 2, (left * (sides[1] - wide)) / 2];
      to = { sides, pose: [...outside(pose, middle[0], middle[1]).map(round), pose[2]] };
      const [a, b] = [sides[0] / 2, sides[1] / 2];
      const footprint = { polygon: [[-a, -b], [a, -b], [a, b], [-a, b]] };
      stage.preview = { bodies: [{ footprint, pose: to.pose }], words: `${sides[0]} × ${sides[1]} m`, at: [point.x, point.y] };
      stage.redraw();
    };
    const drop = () => to && change(thing, { rectangle: to.sides }, to.pose);
    const [x, y] = outside(pose, (ahead * long) / 2, (left * wide) / 2);
    return /** @type {Grip} */ ({ x, y, shape: ahead && left ? "round" : "small", thing, snaps: true, drag, drop, asks });
  });
}

/** @param {EditStage} stage
 * @param {Thing} thing
 * @returns {Grip[]} */
function vertexGrips(stage, thing) {
  const pose = there(thing.pose);
  const points = there(thing.footprint?.polygon);
  /** @param {number} number
   * @param {number[]} at
   * @param {boolean} isNew */
  const grip = (number, at, isNew) => {
    const [u, v] = at;
    /** @type {number[][] | null} */
    let polygon = null;
    const put = (/** @type {number[]} */ point) => (isNew ? [...points.slice(0, number), point, ...points.slice(number)] : points.map((one, n) => (n === number ? point : one)));
    const drag = (/** @type {{x: number, y: number}} */ point) => {
      polygon = put(inside(pose, point).map(round));
      stage.preview = { bodies: [{ footprint: { polygon }, pose }], words: `${round(point.x)}, ${round(point.y)} m`, at: [point.x, point.y] };
      stage.redraw();
    };
    const [x, y] = outside(pose, u, v);
    const asks = {
      title: `Vertex of ${thing.name}`,
      fields: [["x", "m", round(x)], ["y", "m", round(y)]],
      change: (/** @type {number[]} */ [a, b]) => change(thing, { polygon: put(inside(pose, { x: a, y: b }).map(round)) }),
    };
    const remove = isNew || points.length < 4 ? undefined : () => change(thing, { polygon: points.filter((_, n) => n !== number) });
    return /** @type {Grip} */ ({ x, y, shape: isNew ? "small" : "round", thing, snaps: true, drag, drop: () => polygon && change(thing, { polygon }), asks, remove });
  };
  const middles = points.map((point, n) => {
    const next = points[(n + 1) % points.length];
    return grip(n + 1, [(point[0] + next[0]) / 2, (point[1] + next[1]) / 2], true);
  });
  return [...points.map((point, n) => grip(n, point, false)), ...middles];
}

/** The grips of what a sensor sees: how far, and how wide.
 * @param {EditStage} stage
 * @param {Thing} thing
 * @param {string} sensor
 * @returns {Grip[]} */
export function viewGrips(stage, thing, sensor) {
  const body = stage.poseOf(thing);
  const mount = thing.mounts.find((one) => one.sensor === sensor);
  if (!body || !mount?.range_max || stage.mounted.size) return [];
  const { range_max: far, opening, key } = mount;
  const path = `${thing.path}.sensors.${sensor}`;
  const [x, y] = outside(body, mount.pose[0], mount.pose[1]);
  const heading = body[2] + mount.pose[2];
  const label = (/** @type {string} */ what) => `${what} of ${sensor} of ${thing.name}`;
  const setRange = (/** @type {number} */ value) => ({ label: label("range"), changes: [{ op: "set", path: `${path}.range_max`, value }] });
  const angleOf = (/** @type {number} */ value) => Math.round((value / DEGREE) * (key === "fov_deg" ? 1 : 0.5) * 100) / 100;
  const setOpening = (/** @type {number} */ value) => ({ label: label("opening"), changes: [{ op: "set", path: `${path}.${key}`, value: angleOf(value) }] });
  let [range, angle] = [far, opening];
  const show = (/** @type {string} */ words, /** @type {{x: number, y: number}} */ point) => {
    stage.stretch(sensor, range / far, opening ? (angle ?? opening) / opening : 1);
    stage.preview = { words, at: [point.x, point.y] };
  };
  const grips = [
    {
      x: x + far * Math.cos(heading), y: y + far * Math.sin(heading), shape: "round", thing,
      drag: (/** @type {{x: number, y: number}} */ point, /** @type {boolean} */ isFree) => {
        const along = (point.x - x) * Math.cos(heading) + (point.y - y) * Math.sin(heading);
        const step = isFree ? 1e-4 : CENTIMETRE;
        range = Math.max(step, round(Math.round(along / step) * step));
        show(`sees ${range} m`, point);
      },
      drop: () => setRange(range),
      asks: { title: label("Range"), fields: [["range", "m", far]], change: (/** @type {number[]} */ [typed]) => setRange(typed), isRight: (/** @type {number[]} */ [typed]) => typed > 0 },
    },
  ];
  if (!opening || !key) return /** @type {Grip[]} */ (grips);
  for (const side of [-1, 1]) {
    const edge = heading + (side * opening) / 2;
    grips.push({
      x: x + 0.6 * far * Math.cos(edge), y: y + 0.6 * far * Math.sin(edge), shape: "round", thing,
      drag: (point, isFree) => {
        const step = (isFree ? 0.1 : 1) * DEGREE;
        const off = Math.atan2(point.y - y, point.x - x) - heading;
        const half = Math.abs(Math.atan2(Math.sin(off), Math.cos(off)));
        angle = Math.min(2 * Math.PI, Math.max(step, Math.round((2 * half) / step) * step));
        show(`opens ${Math.round(angle / (0.1 * DEGREE)) / 10}°`, point);
      },
      drop: () => setOpening(there(angle)),
      asks: {
        title: label("Opening"), fields: [["angle from edge to edge", "°", Math.round((opening / DEGREE) * 100) / 100]],
        change: ([typed]) => setOpening(typed * DEGREE), isRight: ([typed]) => typed > 0 && typed <= 360,
      },
    });
  }
  return /** @type {Grip[]} */ (grips);
}
