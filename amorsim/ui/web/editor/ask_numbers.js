// A dialog for the numbers of a grip: what a drag would set, typed.

import { open } from "../shared/dialogs.js";
import { h, say } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";

/**
 * @typedef {{
 *   title: string,
 *   fields: [string, string, number][],
 *   change: (values: number[]) => {label: string, changes: any[]},
 *   isRight?: (values: number[]) => boolean,
 * }} Asks what is asked: each number with its name, unit and present value; and the change that new ones are
 */

/** @param {import("./editor.js").EditorPage} page
 * @param {Asks} asks */
export function askNumbers(page, { title, fields, change, isRight = () => true }) {
  const problem = h("p", { class: "error", role: "alert" });
  const inputs = fields.map(([, , value]) => h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: String(value) }));
  const set = async () => {
    const values = inputs.map((input) => numberIn(input.value));
    if (!values.every(Number.isFinite) || !isRight(values)) {
      say(problem, values.every(Number.isFinite) ? "Expected a size above zero." : "Expected a number.");
      return;
    }
    const { label, changes } = change(values);
    const said = await page.edit(label, changes);
    if (said.ok) dialog.close();
    else say(problem, said.error);
  };
  const rows = fields.map(([name, unit], n) => h("label", { class: "asked" }, h("span", {}, name), inputs[n], h("span", { class: "unit" }, unit)));
  for (const input of inputs) input.addEventListener("keydown", (event) => event.key === "Enter" && set());
  const dialog = open(title, h("div", {}, rows, problem), [h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: set }, "set")]);
  inputs[0].select();
}
