// Numbers that are typed while something is drawn: a length and an angle, a radius, or two sides.

import { numberIn } from "../shared/field.js";
import { say } from "../shared/dom.js";

/** Show the fields for what a tool takes, or none.
 * @param {any} parts
 * @param {{typing?: [string, string][]}} tool its numbers, each with its name and unit */
export function showTyping(parts, { typing = [] }) {
  parts.typing.hidden = !typing.length;
  ["length", "angle"].forEach((name, n) => {
    const [word, unit] = typing[n] ?? ["", ""];
    for (const part of [name, `${name}Word`, `${name}Unit`]) parts[part].hidden = !word;
    say(parts[`${name}Word`], word);
    say(parts[`${name}Unit`], unit);
    parts[name].setAttribute("aria-label", `${word} in ${unit === "m" ? "metres" : "degrees"}`);
  });
}

/** Let the first digit of a number that is typed while something is drawn begin the field of its length; whether it did.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} key */
export function beginTyping(page, key) {
  const tool = page.tools[page.toolName ?? ""];
  if (!/^[\d.,]$/.test(key) || !tool?.typing?.length || !tool.points.length || tool.corner) return false;
  page.parts.length.value = key;
  page.parts.length.focus();
  showTyped(page);
  return true;
}

/** Enter draws what was typed, Escape lets it go; both give the keyboard back to the drawing.
 * @param {import("./editor.js").EditorPage} page
 * @param {KeyboardEvent} event */
export function keyTyped(page, event) {
  const { length, angle } = page.parts;
  if (event.key === "Escape") {
    length.value = angle.value = "";
    showTyped(page);
  }
  else if (event.key !== "Enter" || !draw(page)) return;
  event.preventDefault();
  event.stopPropagation();
  page.stage.pane.canvas.focus();
}

/** Show what is drawn as far as it is typed, or else to where the pointer is.
 * @param {import("./editor.js").EditorPage} page */
export function showTyped(page) {
  const { length, angle } = page.parts;
  const tool = page.tools[page.toolName ?? ""];
  const mark = tool?.typedMark?.(numberIn(length.value), numberIn(angle.value)) ?? tool?.last;
  if (!mark || !tool.points?.length) return;
  page.stage.preview = { mark, ...tool.about(mark) };
  page.stage.redraw();
}

/** Draw to where the typed numbers say; whether they could be drawn.
 * @param {import("./editor.js").EditorPage} page */
function draw(page) {
  const { length, angle } = page.parts;
  const tool = page.tools[page.toolName ?? ""];
  const mark = tool?.typedMark?.(numberIn(length.value), numberIn(angle.value));
  if (mark) {
    tool.point(mark);
    length.value = angle.value = "";
    if (!tool.points.length) page.stage.preview = null;
  } else page.hint(tool.points.length ? "type a length above zero" : "click where it begins first, then type");
  return Boolean(mark);
}
