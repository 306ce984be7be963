// Adding things: the menu of what there is, and where one is put with the next click.

import { h } from "../shared/dom.js";
import { PlaceTool } from "./draw_tools.js";
import { askFleet, fleetKinds } from "./fleets.js";
import { PathTool } from "./path_tool.js";
import { kindsOfThings } from "./things.js";
import { BoxTool } from "./wall_tools.js";

/** Fill the menu with what the server knows.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} menu */
export function showMenu(page, menu) {
  page.kinds = [...kindsOfThings(menu), ...fleetKinds(menu.robot)];
  const groups = [...new Set(page.kinds.map(({ group }) => group))];
  page.parts.add.replaceChildren(
    h("option", { value: "" }, "add …"),
    ...groups.map((group) => h("optgroup", { label: group }, page.kinds.filter((kind) => kind.group === group).map((kind) => h("option", { value: kind.label }, kind.label)))),
  );
}

/** Let the next click place a thing, or the next box a fleet.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} label */
export function startPlacing(page, label) {
  const kind = page.kinds.find((one) => one.label === label);
  page.parts.add.value = "";
  if (!kind) return;
  for (const button of page.parts.tools.values()) button.setAttribute("aria-pressed", "false");
  if (kind.isMany) {
    page.hold(new BoxTool(page, "Click two corners of the box in which they start, or drag it.", (box) => {
      page.take("select");
      askFleet(page, kind, box);
    }), "box");
  } else if (kind.isPath) page.hold(new PathTool(page, "line's points", (points) => addLine(page, kind, points)), "path");
  else page.hold(new PlaceTool(page, kind, (pose) => add(page, kind, pose)), "place");
  page.stage.pane.canvas.focus();
}

/** Add a line through points, and show what it is a part of.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} kind
 * @param {number[][]} points */
async function addLine(page, kind, points) {
  if (points.length < 2) {
    page.hint("a line needs two points at least");
    return;
  }
  const said = await page.edit(`add a ${kind.label}`, [{ op: "add", path: kind.path, value: { points } }]);
  if (said.ok) page.choose([kind.path.split(".")[0]]);
}

/** Add a thing of a kind at a pose, and select it.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} kind
 * @param {number[]} pose */
async function add(page, kind, pose) {
  const said = await page.edit(`add ${kind.label}`, [{ op: "add", path: kind.path, value: kind.make(pose, page.stage.things) }]);
  if (said.ok) page.choose(kind.path.includes(".") ? [kind.path.split(".")[0]] : said.added);
  page.take("select");
}
