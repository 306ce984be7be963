// Dialogs: the browser's own `<dialog>`, which keeps the keyboard inside and gives it back.

import { h, there } from "./dom.js";
import { startTour } from "./tour.js";

/** A dialog with buttons; it is open, and gone once it is closed.
 * @param {string} title
 * @param {HTMLElement} body
 * @param {any[]} buttons */
export function open(title, body, buttons) {
  const dialog = h("dialog", { "aria-label": title }, h("h2", {}, title), body, h("div", { class: "buttons" }, buttons));
  dialog.addEventListener("close", () => dialog.remove());
  there(document.querySelector(".amorsim")).append(dialog);
  dialog.showModal();
  return dialog;
}

/** @param {string} title
 * @param {any[]} body */
export function tell(title, ...body) {
  const close = h("button", { onclick: () => dialog.close() }, "close");
  const dialog = open(title, h("div", {}, body), [close]);
}

/** Tell the keys of a page, and offer a tour of it.
 * @param {string[][]} keys each with what it does
 * @param {import("./tour.js").Step[]} tour */
export function tellKeys(keys, tour) {
  const rows = keys.map(([key, does]) => h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, key)), h("td", {}, does)));
  const go = h("button", { class: "main", onclick: () => {
    dialog.close();
    startTour(/** @type {HTMLElement} */ (document.querySelector(".amorsim")), tour);
  } }, "a tour of this page");
  const close = h("button", { onclick: () => dialog.close() }, "close");
  const dialog = open("Keys", h("div", {}, h("table", { class: "keys" }, h("tbody", {}, rows))), [close, go]);
}

/** Ask for a name; `save(name)` gives `{ok, error}`, and the dialog stays until it is ok.
 * @param {string} title
 * @param {string} label
 * @param {string} name
 * @param {string} note
 * @param {(name: string) => Promise<any>} save */
export function askName(title, label, name, note, save) {
  const problem = h("p", { class: "error", role: "alert" });
  const input = h("input", { type: "text", value: name, id: "asked-name", autocomplete: "off", spellcheck: "false" });
  const go = async () => {
    saves.disabled = true;
    saves.textContent = "saving …";
    const said = await save(input.value.trim());
    saves.disabled = false;
    saves.textContent = "save";
    if (said.ok) return dialog.close();
    problem.textContent = said.error;
    input.focus(); // which the disabled button had lost
  };
  input.addEventListener("keydown", (event) => event.key === "Enter" && go());
  const saves = h("button", { class: "main", onclick: go }, "save");
  const dialog = open(
    title,
    h("div", {}, h("label", { for: "asked-name" }, label), input, h("p", { class: "help" }, note), problem),
    [h("button", { onclick: () => dialog.close() }, "cancel"), saves],
  );
  input.select();
}
