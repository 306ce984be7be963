// Dialogs: the browser's own `<dialog>`, which keeps the keyboard inside and gives it back.

import { h } from "./dom.js";

/** A dialog with buttons; it is open, and gone once it is closed. */
export function open(title, body, buttons) {
  const dialog = h("dialog", { "aria-label": title }, h("h2", {}, title), body, h("div", { class: "buttons" }, buttons));
  dialog.addEventListener("close", () => dialog.remove());
  document.querySelector(".amorsim").append(dialog);
  dialog.showModal();
  return dialog;
}

export function tell(title, ...body) {
  const close = h("button", { onclick: () => dialog.close() }, "close");
  const dialog = open(title, h("div", {}, body), [close]);
}

/** Ask for a name; `save(name)` gives `{ok, error}`, and the dialog stays until it is ok. */
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

const KEYS = [
  ["Space", "run, pause"], [".", "one step"], ["Shift + R", "reset to the start"], ["M", "drive by hand, or give back"],
  ["arrows, W A S D", "drive, while a key is held"], ["Q, E", "slide, where the drive can"], ["X", "stop"],
  ["O", "overlay of the two panes"], ["F", "follow the robot"], ["T", "trails"], ["G", "grid"], ["0", "see all"],
  ["+, −", "zoom"], ["Shift + arrows", "pan"], ["Enter", "in a pane: what is in its middle"], ["N, P", "next, previous robot"], ["B", "list of robots"], ["Shift + drag", "list the robots in a box"], ["L", "light or dark"], ["C", "large, for a class"], ["?", "this"],
];

const LIVE = ["Shift + R", "M", "arrows, W A S D", "Q, E", "X"];
const RECORDED = [[",", "one step back"], ["Shift + R", "to the start"]];

/** The keys of the Simulator; of a recorded run, those that do something there. */
export function showKeys(isRecorded = false) {
  const keys = isRecorded ? [...RECORDED, ...KEYS.filter(([key]) => !LIVE.includes(key))] : KEYS;
  const rows = keys.map(([key, does]) => h("tr", {}, h("th", { scope: "row" }, h("kbd", {}, key)), h("td", {}, does)));
  tell("Keys", h("table", { class: "keys" }, h("tbody", {}, rows)));
}
