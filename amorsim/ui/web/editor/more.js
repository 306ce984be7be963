// What the inspector offers besides forms: drawing points, saving models, writing programs, previews.

import { h, there } from "../shared/dom.js";
import { newController, programOf, showCode } from "./code.js";
import { round } from "./geometry.js";
import { PathTool } from "./path_tool.js";
import { histogram, previewErrors } from "./previews.js";
import { askModel } from "./project.js";

const button = (/** @type {string} */ label, /** @type {() => void} */ does) => h("button", { class: "tool", onclick: does }, label);
const row = (/** @type {any[]} */ ...buttons) => h("div", { class: "row" }, buttons);

/** The button that draws the points of a list on the canvas.
 * @param {import("./editor.js").EditorPage} page
 * @param {{path: string, label: string}} field */
export function drawing(page, { path, label }) {
  return row(button(`draw the ${label}`, () => {
    page.hold(new PathTool(page, label, (points) => page.edit(`draw the ${label}`, [{ op: "set", path, value: points }])), "path");
    page.stage.pane.canvas.focus();
  }));
}

/** The button that draws an outline about a thing, which says it in its own frame.
 * @param {import("./editor.js").EditorPage} page
 * @param {import("./stage.js").Thing} thing */
function outlining(page, thing) {
  const [x, y, heading] = there(thing.pose);
  const [c, s] = [Math.cos(heading), Math.sin(heading)];
  return row(button("draw the outline", () => {
    page.hold(new PathTool(page, "outline's corners", (points) => {
      if (points.length < 3) {
        page.hint("an outline needs at least three corners");
        return;
      }
      const polygon = points.map(([u, v]) => [round((u - x) * c + (v - y) * s), round((v - y) * c - (u - x) * s)]);
      page.edit(`draw the outline of ${thing.name}`, [{ op: "set", path: `${thing.path}.shape`, value: { polygon } }]);
    }), "path");
    page.stage.pane.canvas.focus();
  }));
}

/** What else can be done with a table of a thing.
 * @param {import("./editor.js").EditorPage} page
 * @param {import("./inspector.js").Section} section */
export function more(page, { path, use, title }) {
  const body = page.stage.things.find((thing) => path === `${thing.path}.shape`);
  if (body?.pose && use?.value === "polygon" && !page.watching) return [outlining(page, body)];
  const robot = page.stage.things.find((thing) => thing.kind === "robot" && (path === thing.path || path.startsWith(`${thing.path}.`)));
  if (!robot) return [];
  const rest = path.slice(robot.path.length + 1);
  const [, sensor, noise] = rest.match(/^sensors\.([^.]+)(\.noise)?$/) ?? [];
  const found = [];
  if (!rest && title === "Robot" && !page.watching) found.push(row(button("save as a model…", () => askModel(page, robot.path))));
  if (rest === "errors") found.push(row(button("try on a square of 10 m", () => previewErrors(page, robot.name))));
  if (sensor && noise) {
    const holder = h("div", { class: "toml" });
    found.push(row(button("histogram", () => histogram(page, robot.name, sensor, holder))), holder);
  } else if (sensor && !page.watching) found.push(row(button("save as a device…", () => askModel(page, robot.path, sensor))));
  if (rest === "controller") {
    const program = programOf(use?.value ?? "");
    if (program) found.push(row(button(`edit ${program.file}`, () => showCode(page, program.file))));
    if (!page.watching) found.push(row(button("write one in Python…", () => newController(page, path))));
  }
  return found;
}

/** The buttons that move an element of a chain of noise.
 * @param {import("./editor.js").EditorPage} page
 * @param {import("./inspector.js").Section} section
 * @param {import("./inspector.js").Section[]} all */
export function reordering(page, { path, title }, all) {
  const [, chain, number] = path.match(/^(.+\.(?:noise|ground))\.(\d+)$/) ?? [];
  if (!chain) return [];
  const n = Number(number);
  const move = (/** @type {string} */ words, /** @type {number} */ index) => h("button", { class: "tool", "aria-label": `${title}: ${words}`, onclick: () => page.edit(`${title} ${words}`, [{ op: "move", path, index }]) }, words);
  const isLast = !all.some((section) => section.path === `${chain}.${n + 1}`);
  return [...(n ? [move("earlier", n - 1)] : []), ...(isLast ? [] : [move("later", n + 1)])];
}
