// Saving, running, and the whole file as text.

import { askName, tell } from "../shared/dialogs.js";
import { dress } from "./code.js";
import { h, say } from "../shared/dom.js";

/** Save it, or ask for a name where it has none.
 * @param {import("./editor.js").EditorPage} page */
export async function save(page) {
  if (page.state?.is_new) {
    saveAs(page);
    return;
  }
  const said = await page.connection.ask({ do: "save" });
  page.hint(said.ok ? `saved ${said.file}` : said.error);
  if (!said.ok && !said.changed) tell("Not saved", h("p", {}, said.error));
}

/** Ask for another name.
 * @param {import("./editor.js").EditorPage} page */
export function saveAs(page) {
  const { name, folder } = page.state;
  askName("Save as", "file", name, `in ${folder}; a map that is drawn here, and what a copy needs, is saved next to it`, async (given) => {
    const said = await page.connection.ask({ do: "save_as", name: given });
    if (said.ok) page.hint(`saved ${said.file}`);
    return said;
  });
}

/** Let the Simulator run what is drawn.
 * @param {import("./editor.js").EditorPage} page */
export async function run(page) {
  const button = page.parts.run;
  button.disabled = true;
  say(button, "starting …");
  const said = await page.connection.ask({ do: "run" });
  button.disabled = false;
  say(button, "▶ run");
  if (said.ok) location.assign(said.path);
  else tell("It cannot be run", h("pre", {}, said.error));
}

/** The whole file, to be read and changed.
 * @param {import("./editor.js").EditorPage} page */
export async function showText(page) {
  const said = await page.connection.ask({ do: "text" });
  if (!said.ok) return;
  const area = h("textarea", { "aria-label": "the scenario's file", spellcheck: "false" });
  area.value = said.text;
  area.readOnly = page.watching;
  const set = h("button", { class: "main holders-only", onclick: async () => {
    const done = await page.edit("change the text", [{ op: "text", text: area.value }]);
    if (done.ok) area.closest("dialog").close();
  } }, "set");
  tell(page.state.name, h("div", { class: "code" }, area), h("div", { class: "buttons" }, set));
  dress(area, "toml");
}
