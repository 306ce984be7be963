// The manual of a component: what it is, and its fields, in a dialog.

import { tell } from "./dialogs.js";
import { h } from "./dom.js";

/** @typedef {(command: object) => Promise<any>} Ask */

/** A button that opens the manual of a component.
 * @param {Ask} ask
 * @param {string} kind such as "controller"
 * @param {string} name such as "wander"
 * @param {string} shown on the button */
export function manualButton(ask, kind, name, shown = "?") {
  const words = `what ${name} is, and what its fields are`;
  return h("button", { class: "tool", "aria-label": `${shown === "?" ? "" : `${shown}: `}${words}`, title: words, onclick: () => showManual(ask, kind, name) }, shown);
}

/** @param {Ask} ask
 * @param {string} kind
 * @param {string} name */
async function showManual(ask, kind, name) {
  const said = await ask({ do: "manual", kind, name });
  const title = `${kind.replaceAll("_", " ")} ${name}`;
  if (!said.ok) return tell(title, h("p", {}, said.error));
  /** @type {{text: string, fields: string[][]}} */
  const { text, fields } = said.manual;
  const head = ["field", "value", "default", "meaning"];
  const table = h(
    "table",
    { class: "manual" },
    h("thead", {}, h("tr", {}, head.map((word) => h("th", { scope: "col" }, word)))),
    h("tbody", {}, fields.map(([field, ...cells]) => h("tr", {}, h("th", { scope: "row" }, h("code", {}, field)), cells.map((cell) => h("td", {}, cell))))),
  );
  const paragraphs = text.split("\n\n").map((one) => h("p", { class: "manual" }, ...inCode(one)));
  tell(title, ...paragraphs, fields.length ? table : h("p", {}, "It has no fields."));
}

/** A paragraph whose words between backquotes are code. @param {string} text */
function inCode(text) {
  return text.replaceAll("\n", " ").split(/``?/).map((piece, n) => (n % 2 ? h("code", {}, piece) : piece));
}
