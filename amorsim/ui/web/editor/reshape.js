// What can be done with several selected things and walls: split, join, offset, align and share out.

import { open } from "../shared/dialogs.js";
import { h, say, there } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";
import { round } from "./geometry.js";
import { poseChange } from "./poses.js";
import { joined, offset, split } from "./wall_work.js";

/** The buttons for what is selected: a line for walls, a line for where things stand.
 * @param {import("./editor.js").EditorPage} page */
export function reshaping(page) {
  if (page.watching) return [];
  const { stage } = page;
  const button = (/** @type {string} */ label, /** @type {string} */ title, /** @type {(page: import("./editor.js").EditorPage) => void} */ does) => h("button", { class: "tool", title, onclick: () => does(page) }, label);
  const parts = [];
  const count = stage.chosenWalls.length;
  if (count && !page.wallsFixed) {
    const buttons = [button("split", "into pieces where other walls cross, or else in the middle", splitWalls)];
    if (count === 2) buttons.push(button("join", "into one wall, or into a corner", joinWalls));
    buttons.push(button("offset…", "copies to one side", askOffset));
    parts.push(h("div", { class: "row", role: "group", "aria-label": "walls" }, buttons));
  }
  if (stage.selection.things.length > 1 || count) parts.push(h("div", { class: "row" }, button("turn…", "about the middle of all, by an angle", askTurn)));
  if (stage.selection.things.length > 1) {
    const places = [["left", 0, 0], ["middle", 0, 1], ["right", 0, 2], ["bottom", 1, 0], ["centre", 1, 1], ["top", 1, 2]];
    parts.push(h("div", { class: "row wraps", role: "group", "aria-label": "align" }, h("span", { class: "note" }, "align"),
      places.map(([label, axis, part]) => button(String(label), `align: ${label}`, () => align(page, Number(axis), Number(part))))));
    if (stage.chosenThings.length > 2) {
      parts.push(h("div", { class: "row wraps", role: "group", "aria-label": "share out" }, h("span", { class: "note" }, "equal gaps"),
        button("across", "the same distance from one to the next, left to right", () => shareOut(page, 0)), button("up", "the same distance from one to the next, bottom to top", () => shareOut(page, 1))));
    }
  }
  return parts;
}

/** @param {import("./editor.js").EditorPage} page */
export function splitWalls(page) {
  const { walls } = page.stage.walls;
  const chosen = page.stage.chosenWalls;
  const change = [];
  const add = [];
  for (const n of chosen) {
    const [first, ...rest] = split(walls[n], walls.filter((_, k) => k !== n));
    change.push([n, first]);
    add.push(...rest);
  }
  return page.edit("split walls", [{ op: "walls", change, add }]);
}

/** @param {import("./editor.js").EditorPage} page */
function joinWalls(page) {
  const [one, other] = page.stage.chosenWalls;
  const { walls } = page.stage.walls;
  const found = joined(walls[one], walls[other]);
  if (!found) {
    page.hint("these walls are parallel and never meet");
    return null;
  }
  const [first, second] = found;
  page.stage.selection.clear();
  return page.edit("join walls", [{ op: "walls", change: second ? [[one, first], [other, second]] : [[one, first]], remove: second ? [] : [other] }]);
}

/** @param {import("./editor.js").EditorPage} page */
export function askOffset(page) {
  const problem = h("p", { class: "error", role: "alert" });
  const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: "0.1" });
  const make = async () => {
    const distance = numberIn(input.value);
    if (!(Math.abs(distance) >= 0.001)) {
      say(problem, "Expected a distance in metres; a negative one is to the right.");
      return;
    }
    const walls = page.stage.chosenWalls.map((n) => page.stage.walls.walls[n]);
    const said = await page.edit("offset walls", [{ op: "walls", add: offset(walls, distance) }]);
    if (said.ok) dialog.close();
    else say(problem, said.error);
  };
  const row = h("label", { class: "asked" }, h("span", {}, "distance, to the left of where they lead"), input, h("span", { class: "unit" }, "m"));
  const dialog = open("Copies to one side", h("div", {}, row, problem), [h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: make }, "make")]);
}

/** @param {import("./editor.js").EditorPage} page */
export function askTurn(page) {
  const problem = h("p", { class: "error", role: "alert" });
  const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: "90" });
  const make = async () => {
    const degrees = numberIn(input.value);
    if (!Number.isFinite(degrees)) {
      say(problem, "Expected an angle in degrees.");
      return;
    }
    const said = await turn(page, (degrees * Math.PI) / 180);
    if (!said || said.ok) dialog.close();
    else say(problem, said.error);
  };
  const row = h("label", { class: "asked" }, h("span", {}, "angle, anticlockwise"), input, h("span", { class: "unit" }, "°"));
  const dialog = open("Turn what is selected", h("div", {}, row, problem), [h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: make }, "turn")]);
  input.select();
}

/** Turn what is selected about its middle by an angle [rad].
 * @param {import("./editor.js").EditorPage} page
 * @param {number} angle */
export function turn(page, angle) {
  const { stage } = page;
  const all = boxes(page).map(({ box }) => box);
  if (!all.length) return null;
  const middle = [0, 1].map((k) => (Math.min(...all.map((box) => box[k])) + Math.max(...all.map((box) => box[k + 2]))) / 2);
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  const turned = (/** @type {number} */ x, /** @type {number} */ y) => [round(middle[0] + (x - middle[0]) * c - (y - middle[1]) * s), round(middle[1] + (x - middle[0]) * s + (y - middle[1]) * c)];
  const things = stage.standing.filter(({ moves }) => moves);
  const changes = things.map((thing) => poseChange(thing, [...turned(thing.pose[0], thing.pose[1]), thing.pose[2] + (thing.turns ? angle : 0)]));
  const walls = page.wallsFixed ? [] : stage.chosenWalls.map((n) => {
    const [a, b, e, f] = stage.walls.walls[n];
    return { op: "walls", change: [[n, [...turned(a, b), ...turned(e, f)]]] };
  });
  return edit(page, "turn what was selected", [...changes, ...walls]);
}

/** What is selected as boxes that can be moved: x0, y0, x1, y1, and how.
 * @param {import("./editor.js").EditorPage} page */
function boxes(page) {
  const { stage } = page;
  const things = stage.chosenThings.filter(({ pose, moves }) => pose && moves).map((thing) => {
    const [x, y, heading] = there(thing.pose);
    return {
      box: [x, y, x, y],
      moved: (/** @type {number} */ dx, /** @type {number} */ dy) => poseChange(thing, [round(x + dx), round(y + dy), heading]),
    };
  });
  const walls = page.wallsFixed ? [] : stage.chosenWalls.map((n) => {
    const [a, b, c, d] = stage.walls.walls[n];
    return {
      box: [Math.min(a, c), Math.min(b, d), Math.max(a, c), Math.max(b, d)],
      moved: (/** @type {number} */ dx, /** @type {number} */ dy) => ({ op: "walls", change: [[n, [a + dx, b + dy, c + dx, d + dy].map(round)]] }),
    };
  });
  return [...things, ...walls];
}

/** Align along an axis (0 for x, 1 for y) at the least, the middle or the most of what is selected.
 * @param {import("./editor.js").EditorPage} page
 * @param {number} axis
 * @param {number} part */
export function align(page, axis, part) {
  const all = boxes(page);
  const at = (/** @type {number[]} */ box) => [box[axis], (box[axis] + box[axis + 2]) / 2, box[axis + 2]][part];
  const [low, high] = [Math.min(...all.map(({ box }) => box[axis])), Math.max(...all.map(({ box }) => box[axis + 2]))];
  const goal = [low, (low + high) / 2, high][part];
  return edit(page, "align", all.map(({ box, moved }) => (axis ? moved(0, goal - at(box)) : moved(goal - at(box), 0))));
}

/** The same distance from one to the next; the first and the last stay.
 * @param {import("./editor.js").EditorPage} page
 * @param {number} axis */
function shareOut(page, axis) {
  const all = boxes(page).sort((one, other) => one.box[axis] - other.box[axis]);
  const middle = (/** @type {{box: number[]}} */ { box }) => (box[axis] + box[axis + 2]) / 2;
  const [first, last] = [middle(all[0]), middle(all[all.length - 1])];
  return edit(page, "share out", all.map((one, n) => {
    const by = first + (n * (last - first)) / (all.length - 1) - middle(one);
    return axis ? one.moved(0, by) : one.moved(by, 0);
  }));
}

/** @param {import("./editor.js").EditorPage} page
 * @param {string} label
 * @param {any[]} changes */
function edit(page, label, changes) {
  const walls = changes.filter(({ op }) => op === "walls").flatMap(({ change }) => change);
  const others = changes.filter(({ op }) => op !== "walls");
  const all = walls.length ? [...others, { op: "walls", change: walls }] : others;
  return all.length ? page.edit(label, all) : null;
}
