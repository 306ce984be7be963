// Copies in rows, and mirror images, of what is selected.

import { open } from "../shared/dialogs.js";
import { h, say } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";
import { copyOf, pasted } from "./clipboard.js";
import { round } from "./geometry.js";
import { poseChange } from "./poses.js";

const MOST = 500; // copies

/** Ask for the rows, and make the copies as one step.
 * @param {import("./editor.js").EditorPage} page */
export function askArray(page) {
  const number = (/** @type {string} */ label, /** @type {number} */ value, unit = "") => {
    const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: String(value) });
    return { input, row: h("label", { class: "asked" }, h("span", {}, label), input, h("span", { class: "unit" }, unit)) };
  };
  const asked = [number("columns", 3), number("to the right", 1, "m"), number("rows", 1), number("up", 1, "m")];
  const problem = h("p", { class: "error", role: "alert" });
  const make = async () => {
    const [columns, right, rows, up] = asked.map(({ input }) => numberIn(input.value));
    if (!(columns >= 1 && rows >= 1 && columns * rows <= MOST && Number.isInteger(columns) && Number.isInteger(rows))) {
      say(problem, `Expected whole numbers of columns and rows, at most ${MOST} in all.`);
      return;
    }
    if (!Number.isFinite(right) || !Number.isFinite(up)) {
      say(problem, "Expected distances in metres.");
      return;
    }
    const said = await array(page, columns, right, rows, up);
    if (said.ok) dialog.close();
    else say(problem, said.error);
  };
  const dialog = open("Copies in rows", h("div", {}, asked.map(({ row }) => row), problem), [
    h("button", { onclick: () => dialog.close() }, "cancel"),
    h("button", { class: "main", onclick: make }, "make"),
  ]);
}

/** Copies of what is selected, in columns and rows with distances [m].
 * @param {import("./editor.js").EditorPage} page
 * @param {number} columns
 * @param {number} right
 * @param {number} rows
 * @param {number} up */
export async function array(page, columns, right, rows, up) {
  const clip = await copyOf(page);
  if (!clip) return { ok: false, error: "Nothing is selected." };
  const names = [...page.stage.things];
  const changes = [];
  for (let row = 0; row < rows; row++) {
    for (let column = 0; column < columns; column++) {
      if (row || column) changes.push(...pasted(names, clip, [column * right, row * up]));
    }
  }
  const walls = changes.filter(({ op }) => op === "walls").flatMap(({ add }) => add);
  const others = changes.filter(({ op }) => op !== "walls");
  const all = walls.length ? [...others, { op: "walls", add: walls }] : others;
  return all.length ? await page.edit(`${columns} × ${rows} copies`, all) : { ok: true };
}

/** Mirror what is selected about the vertical line through its middle.
 * @param {import("./editor.js").EditorPage} page */
export async function mirror(page) {
  const { stage } = page;
  const things = stage.standing.filter(({ moves }) => moves);
  const walls = page.wallsFixed ? [] : stage.chosenWalls;
  const xs = [...things.map(({ pose }) => pose[0]), ...walls.flatMap((n) => [stage.walls.walls[n][0], stage.walls.walls[n][2]])];
  if (!xs.length) return;
  const twice = Math.min(...xs) + Math.max(...xs);
  const changes = /** @type {any[]} */ (things.map((thing) => poseChange(thing, [round(twice - thing.pose[0]), thing.pose[1], thing.turns ? Math.PI - thing.pose[2] : thing.pose[2]])));
  if (walls.length) {
    changes.push({ op: "walls", change: walls.map((n) => [n, stage.walls.walls[n].map((value, k) => (k % 2 ? value : round(twice - value)))]) });
  }
  await page.edit("mirror what was selected", changes);
}
