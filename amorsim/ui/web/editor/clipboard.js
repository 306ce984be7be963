// Copies of things and walls, and the changes of the document that paste them.

import { round } from "./geometry.js";
import { reach } from "../shared/footprint.js";
import { startsOf } from "./ghosts.js";
import { freeName } from "./things.js";

const KEPT = "amorsim-copied";

/** What is selected, as the file says it; null where nothing is.
 * @param {import("./editor.js").EditorPage} page */
export async function copyOf(page) {
  const { stage } = page;
  const walls = stage.chosenWalls.map((n) => [...stage.walls.walls[n]]);
  const paths = stage.selection.things.flatMap((one) => /** @type {import("./stage.js").Chosen} */ (one).path ?? []).filter((path) => path.includes("."));
  const said = paths.length ? await page.connection.ask({ do: "tables", paths }) : { ok: true, tables: [], folder: "" };
  if (!said.ok) {
    page.hint(said.error);
    return null;
  }
  const things = said.tables.map((/** @type {any} */ table, /** @type {number} */ n) => ({ list: paths[n].split(".")[0], table, thing: stage.things.find(({ path }) => path === paths[n]) }));
  const count = walls.length + things.length;
  return count ? { walls, things, count, folder: said.folder } : null;
}

/** Keep a copy for other scenarios, and other windows.
 * @param {NonNullable<Awaited<ReturnType<typeof copyOf>>>} clip */
export function keep(clip) {
  try {
    localStorage.setItem(KEPT, JSON.stringify(clip));
  } catch {
    localStorage.removeItem(KEPT);
  }
}

/** What was copied last, here or in another window; null where nothing was.
 * @returns {Awaited<ReturnType<typeof copyOf>>} */
export function lastCopy() {
  try {
    return JSON.parse(localStorage.getItem(KEPT) ?? "null");
  } catch {
    return null;
  }
}

/** Shift the points of a table that lie at a path: where many start, or the way that a thing moves.
 * @param {any} table
 * @param {string[]} path
 * @param {number} dx
 * @param {number} dy */
function shift(table, path, dx, dy) {
  const holder = path.slice(0, -1).reduce((inner, key) => inner?.[key], table);
  const key = path[path.length - 1];
  const found = holder?.[key];
  const moved = (/** @type {number[]} */ [x, y]) => [round(x + dx), round(y + dy)];
  if (!found) return;
  if (!Array.isArray(found)) Object.assign(found, { x: round(found.x + dx), y: round(found.y + dy) });
  else if (Array.isArray(found[0])) holder[key] = found.map(moved);
  else holder[key] = [...moved(found), ...(found.length === 4 ? moved(found.slice(2)) : [])];
}

/** The changes that put copies, shifted by so much [m]; `names` are the things there are, to which the copies come.
 * @param {any[]} names
 * @param {NonNullable<Awaited<ReturnType<typeof copyOf>>>} clip
 * @param {number[]} shift */
export function pasted(names, clip, [dx, dy]) {
  const changes = [];
  for (const { list, table, thing } of clip.things) {
    const copy = structuredClone(table);
    if (typeof copy.name === "string") {
      copy.name = freeName(copy.name.replace(/\d+$/, ""), names);
      names.push({ ...thing, name: copy.name });
    }
    if (list === "landmarks") {
      copy.id = Math.max(0, ...names.filter(({ kind }) => kind === "landmark").map(({ name }) => Number(name.split(" ")[1]) || 0)) + 1;
      names.push({ ...thing, kind: "landmark", name: `landmark ${copy.id}` });
    }
    if (list === "landmarks" || list === "lights") [copy.x, copy.y] = [round((copy.x ?? 0) + dx), round((copy.y ?? 0) + dy)];
    else if (thing?.pose && !copy.start) {
      copy.pose = { ...copy.pose, x: round(thing.pose[0] + dx), y: round(thing.pose[1] + dy) };
    }
    for (const place of thing?.places ?? []) {
      const at = place.path.slice(thing.path.length + 1);
      if (at.startsWith("start.") || at.startsWith("motion.")) shift(copy, at.split("."), dx, dy);
    }
    changes.push({ op: "add", path: list, value: copy, ...(clip.folder ? { folder: clip.folder } : {}) });
  }
  if (clip.walls.length) changes.push({ op: "walls", add: clip.walls.map(([a, b, c, d]) => [a + dx, b + dy, c + dx, d + dy].map(round)) });
  return changes;
}

/** How far just aside is [m]. */
const aside = (/** @type {import("./editor.js").EditorPage} */ page) => {
  const step = 2 * (page.grid || 0.1);
  return [step, -step];
};

const TRIES = 12; // distances that are tried in each direction

/** By how much copies are shifted [m] so that they touch nothing; just aside, where no such place is near.
 * @param {import("./editor.js").EditorPage} page
 * @param {NonNullable<Awaited<ReturnType<typeof copyOf>>>} clip
 * @param {number[][]} points of what is copied */
function free(page, clip, points) {
  const { stage } = page;
  const step = page.grid || 0.1;
  /** @type {{at: number[], far: number}[]} */
  const bodies = clip.things.flatMap((/** @type {{thing: import("./stage.js").Thing | undefined}} */ { thing }) => (thing?.pose && thing.footprint ? [{ at: thing.pose, far: reach(thing.footprint) }] : []));
  const others = stage.things.flatMap((thing) => (thing.pose && thing.footprint ? [{ at: thing.pose, far: reach(thing.footprint) }] : []));
  /** @param {number[]} by */
  const isFree = ([dx, dy]) => bodies.every(({ at: [x, y], far }) => {
    const [u, v] = [x + dx, y + dy];
    const [x0, y0, x1, y1] = stage.still?.extent ?? [-Infinity, -Infinity, Infinity, Infinity];
    return u > x0 && u < x1 && v > y0 && v < y1 && stage.walls.clearance(u, v) > far && others.every(({ at, far: other }) => Math.hypot(at[0] - u, at[1] - v) > far + other);
  });
  if (!bodies.length) return aside(page);
  const [wide, high] = [0, 1].map((k) => Math.max(...points.map((point) => point[k])) - Math.min(...points.map((point) => point[k])));
  const widest = 2 * Math.max(...bodies.map(({ far }) => far));
  for (let n = 0; n < TRIES; n++) {
    const [right, up] = [wide, high].map((size) => round(Math.ceil((size + widest) / step + 2 * n + 1) * step));
    const found = [[right, 0], [0, -up], [-right, 0], [0, up]].find(isFree);
    if (found) return found;
  }
  return aside(page);
}

/** The points of what was copied: ends of walls, places of things. */
const pointsOf = (/** @type {any} */ clip) => [
  ...clip.walls.flatMap((/** @type {number[]} */ [a, b, c, d]) => [[a, b], [c, d]]),
  ...clip.things.flatMap((/** @type {{thing: import("./stage.js").Thing | undefined}} */ { thing }) => (thing?.pose ? [thing.pose] : thing ? startsOf(thing).flatMap(({ points: own }) => own) : [])),
];

/** The middle of some points. */
const middleOf = (/** @type {number[][]} */ points) => [0, 1].map((k) => (Math.min(...points.map((point) => point[k])) + Math.max(...points.map((point) => point[k]))) / 2);

/** By how much copies are shifted [m] so that their middle comes to a place, by steps of the grid.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} clip
 * @param {{x: number, y: number}} at */
function shiftTo(page, clip, at) {
  const points = pointsOf(clip);
  if (!points.length) return undefined;
  const grid = page.grid || 0.01;
  const middle = middleOf(points);
  return [at.x - middle[0], at.y - middle[1]].map((by) => round(Math.round(by / grid) * grid));
}

/** By how much copies are shifted [m] so that they are seen: beside what was copied, or else into the middle of what is seen.
 * @param {import("./editor.js").EditorPage} page
 * @param {NonNullable<Awaited<ReturnType<typeof copyOf>>>} clip */
function placeFor(page, clip) {
  const points = pointsOf(clip);
  const [dx, dy] = points.length ? free(page, clip, points) : aside(page);
  const [x, y] = middleOf(points);
  const { camera } = page.stage;
  const [x0, y0, x1, y1] = camera.bounds();
  if (!points.length || (x + dx > x0 && x + dx < x1 && y + dy > y0 && y + dy < y1)) return [dx, dy];
  const grid = page.grid || 0.1;
  return [camera.x - x, camera.y - y].map((by) => round(Math.round(by / grid) * grid));
}

/** Put copies as one step, and select them; shifted by so much [m], or to where they are seen.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} label
 * @param {NonNullable<Awaited<ReturnType<typeof copyOf>>>} clip
 * @param {number[]} [shift] */
export async function put(page, label, clip, shift) {
  const first = page.stage.walls.walls.length;
  const said = await page.edit(label, pasted([...page.stage.things], clip, shift ?? placeFor(page, clip)));
  if (said.ok) page.choose(said.added, { first, count: clip.walls.length });
}

/** Put copies of what was copied, here or in another window; with their middle at a place, or where they are seen.
 * @param {import("./editor.js").EditorPage} page
 * @param {{x: number, y: number}} [at] */
export async function paste(page, at) {
  const clip = lastCopy() ?? page.clip;
  if (clip) await put(page, "paste", clip, at && shiftTo(page, clip, at));
  else page.hint("nothing was copied yet");
}

/** Remove what is selected.
 * @param {import("./editor.js").EditorPage} page */
export async function remove(page) {
  const { stage } = page;
  const changes = [];
  const paths = stage.selection.things.flatMap((one) => /** @type {import("./stage.js").Chosen} */ (one).path ?? []).filter((path) => path.includes("."));
  // The last of a list first, for those after it move up.
  const last = (/** @type {string} */ path) => Number(path.split(".")[1]);
  for (const path of paths.sort((a, b) => last(b) - last(a))) changes.push({ op: "remove", path });
  if (stage.chosenWalls.length && page.wallsFixed) page.hint(page.wallsFixed);
  else if (stage.chosenWalls.length) changes.push({ op: "walls", remove: stage.chosenWalls });
  if (!changes.length) return;
  const title = stage.selection.only?.title ?? "what was selected";
  stage.selection.clear();
  await page.edit(`delete ${title}`, changes);
}
