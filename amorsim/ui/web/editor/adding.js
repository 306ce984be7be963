// Adding things: a gallery of what there is, and where one is put with the next click.

import { PlaceTool, SizeTool } from "./place_tools.js";
import { askFleet, fleetKinds } from "./fleets.js";
import { showGallery } from "./gallery.js";
import { PathTool } from "./path_tool.js";
import { takeGenerated } from "./project.js";
import { kindsOfThings } from "./things.js";
import { BoxTool } from "./wall_tools.js";

/** Take what the server knows.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} menu */
export function readMenu(page, menu) {
  page.kinds = [...kindsOfThings(menu), ...fleetKinds(menu.robot)];
  page.generators = menu.world_generator;
}

/** Show all that can be added; what is chosen is put at a place, or where the next click says.
 * @param {import("./editor.js").EditorPage} page
 * @param {{x: number, y: number}} [at] */
export function showAdding(page, at) {
  const groups = [...new Set(page.kinds.map(({ group }) => group))].map((group) => ({
    title: group,
    entries: page.kinds.filter((kind) => kind.group === group).map((kind) => ({
      name: kind.label,
      sentence: kind.sentence,
      ...(group === "Robots" ? { of: /** @type {[string, string]} */ (["robot", kind.label]) } : { footprint: kind.footprint }),
      does: () => startPlacing(page, kind, at),
    })),
  }));
  const openings = page.state?.walls_fixed ? [] : [
    { name: "door", sentence: "A door that opens and closes, or an opening, in a wall: click the wall.", does: () => page.take("door") },
    { name: "room", sentence: "Four walls with an opening: click two corners.", does: () => page.take("room") },
  ];
  const worlds = page.generators.map((name) => ({ name, of: /** @type {[string, string]} */ (["world_generator", name]), does: () => takeGenerated(page, name, 1) }));
  showGallery(page, "Add", [
    ...groups.slice(0, 1),
    { title: "Doors and rooms", entries: openings },
    ...groups.slice(1),
    { title: "In place of this world: a generated one", entries: worlds },
  ]);
}

/** Put a thing at a place, or let the next click place it, or the next box a fleet.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} kind
 * @param {{x: number, y: number}} [at] */
function startPlacing(page, kind, at) {
  if (at && !kind.isMany && !kind.isPath) {
    const mark = page.stage.walls.snap(at, { ...page.snapping({ altKey: false, shiftKey: false }, null), isTurned: false });
    add(page, kind, [mark.x, mark.y, 0]);
    return;
  }
  for (const button of page.parts.tools.values()) button.setAttribute("aria-pressed", "false");
  if (kind.isMany) {
    page.hold(new BoxTool(page, "Click two corners of the box in which they start, or drag it.", (box) => {
      page.take("select");
      askFleet(page, kind, box);
    }), "box");
  } else if (kind.isPath) page.hold(new PathTool(page, "line's points", (points) => addLine(page, kind, points)), "path");
  else if (kind.sized) page.hold(new SizeTool(page, kind, (pose, size) => add(page, kind, pose, size)), "place");
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
 * @param {number[]} pose
 * @param {any} [size] the shape that was dragged out */
async function add(page, kind, pose, size) {
  const said = await page.edit(`add ${kind.label}`, [{ op: "add", path: kind.path, value: kind.make(pose, page.stage.things, size) }]);
  if (said.ok) page.choose(kind.path.includes(".") ? [kind.path.split(".")[0]] : said.added);
  page.take("select");
}
