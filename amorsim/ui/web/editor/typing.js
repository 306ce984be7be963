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

/** Draw to where the typed numbers say.
 * @param {import("./editor.js").EditorPage} page */
export function typed(page) {
  const { length, angle } = page.parts;
  const tool = page.tools[page.toolName];
  if (!tool?.typed) return;
  if (tool.typed(numberIn(length.value), numberIn(angle.value))) length.value = angle.value = "";
  else page.hint(tool.points.length ? "type a length above zero" : "click where it begins first, then type");
}
