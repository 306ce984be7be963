// Previews next to forms: what a robot's errors do on a square, and how a sensor's readings scatter.

import { tell } from "../shared/dialogs.js";
import { context2d, fixed, h, say } from "../shared/dom.js";
import { shown } from "../shared/field.js";

const WIDE = 560;
const HIGH = 440;

/** A canvas with a pen, for a plot of its own.
 * @param {number} wide
 * @param {number} high
 * @param {string} label */
function plotting(wide, high, label) {
  const ratio = devicePixelRatio || 1;
  const canvas = h("canvas", { width: String(wide * ratio), height: String(high * ratio), role: "img", "aria-label": label, class: "preview" });
  canvas.style.width = `${wide}px`;
  canvas.style.height = `${high}px`;
  const context = context2d(canvas);
  context.scale(ratio, ratio);
  return { canvas, context };
}

/** Twenty replicas of a square of 10 m.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} robot */
export async function previewErrors(page, robot) {
  const words = h("p", { class: "note", role: "status" }, "simulating …");
  const holder = h("div", {}, words);
  tell(`${robot} on a square of 10 m`, holder);
  const said = await page.connection.ask({ do: "preview", robot });
  if (!said.ok) {
    say(words, said.error);
    return;
  }
  const { canvas, context } = plotting(WIDE, HIGH, "the square as estimated, and the true paths of twenty replicas");
  const { theme } = page.stage;
  const points = [...said.true.flat(), ...said.estimated.flat()];
  const [xs, ys] = [0, 1].map((k) => points.map((point) => point[k]));
  const [x0, x1, y0, y1] = [Math.min(...xs) - 0.5, Math.max(...xs) + 0.5, Math.min(...ys) - 0.5, Math.max(...ys) + 0.5];
  const scale = Math.min(WIDE / (x1 - x0), HIGH / (y1 - y0));
  const at = (/** @type {number[]} */ [x, y]) => [(x - x0) * scale, HIGH - (y - y0) * scale];
  const draw = (/** @type {number[][][]} */ paths, /** @type {string} */ colour, /** @type {number[]} */ dash) => {
    context.strokeStyle = colour;
    context.setLineDash(dash);
    for (const path of paths) {
      context.beginPath();
      for (const point of path) context.lineTo(.../** @type {[number, number]} */ (at(point)));
      context.stroke();
    }
  };
  context.globalAlpha = 0.7;
  draw(said.true, theme.true, []);
  draw(said.estimated, theme.estimated, [5, 4]);
  context.globalAlpha = 1;
  context.fillStyle = theme.danger;
  for (const path of said.true) {
    const [left, top] = at(path[path.length - 1]);
    context.fillRect(left - 2, top - 2, 4, 4);
  }
  holder.replaceChildren(
    canvas,
    h("p", { class: "note" }, `Green: the robot's true paths in ${said.true.length} replicas. Blue, dashed: its estimates. At the end, its estimate is off by ${fixed(said.mean, 2)} m on average and by ${fixed(said.most, 2)} m at most.`),
  );
}

/** The histogram of a sensor's errors, in an element that is filled when it is known.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} robot
 * @param {string} sensor
 * @param {HTMLElement} holder */
export async function histogram(page, robot, sensor, holder) {
  holder.replaceChildren(h("p", { class: "note", role: "status" }, "simulating …"));
  const said = await page.connection.ask({ do: "histogram", robot, sensor });
  if (!said.ok) {
    holder.replaceChildren(h("p", { class: "note", role: "status" }, said.error));
    return;
  }
  const [unit, factor] = shown(said.unit);
  const number = (/** @type {number} */ value) => String(Number((value * factor).toPrecision(3))).replace("-", "−");
  const [wide, high] = [280, 84];
  const words = `mean ${number(said.mean)} ${unit}, standard deviation ${number(said.std)} ${unit}, ${said.of} values`;
  const { canvas, context } = plotting(wide, high, `histogram of measured minus true of ${sensor}: ${words}`);
  const most = Math.max(...said.counts);
  const bar = wide / said.counts.length;
  context.fillStyle = page.stage.theme.measured;
  said.counts.forEach((/** @type {number} */ count, /** @type {number} */ n) => context.fillRect(n * bar, high - 14 - (count / most) * (high - 16), bar - 1, (count / most) * (high - 16)));
  context.fillStyle = page.stage.theme.soft ?? page.stage.theme.ink;
  context.font = "11px system-ui, sans-serif";
  context.fillText(`${number(said.edges[0])} ${unit}`, 0, high - 2);
  context.textAlign = "right";
  context.fillText(`${number(said.edges[said.edges.length - 1])} ${unit}`, wide, high - 2);
  holder.replaceChildren(canvas, h("p", { class: "note" }, `measured minus true at the robot's start: ${words}`));
}
