// Saving, running, and the whole file as text.

import { askName, tell } from "../shared/dialogs.js";
import { openBeside } from "./beside.js";
import { atPauses, plain } from "./code.js";
import { dress } from "./code_editor.js";
import { choicesAt } from "./completion.js";
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

/** The whole file beside the drawing, to be read and changed: each pause in typing is a step, which the drawing follows, and
 * faults stand at their lines. A second call closes it.
 * @param {import("./editor.js").EditorPage} page */
export async function showText(page) {
  if (page.besideText) {
    page.closeBeside?.();
    return;
  }
  const said = await page.connection.ask({ do: "text" });
  if (!said.ok) return;
  const area = /** @type {HTMLTextAreaElement} */ (h("textarea", { "aria-label": "the scenario's file", spellcheck: "false" }));
  area.value = said.text;
  area.readOnly = page.watching;
  const close = h("button", { class: "main" }, "close");
  const panel = openBeside(page, page.state.name, h("div", { class: "code" }, area), [close]);
  page.besideText = true;
  page.parts.text.setAttribute("aria-pressed", "true");
  const editor = await dress(area, "toml", page.watching ? null : (...place) => choicesAt(page, ...place));
  let written = plain(said.text);
  const typed = atPauses(editor, async () => {
    const text = editor.value();
    if (page.watching || text === written) return;
    const done = await page.edit("change the text", [{ op: "text", text }]);
    if (done.ok) written = text;
  });
  const show = () => editor.mark(page.faults.filter(({ file, line }) => line && file === page.state.name));
  page.showCodeFaults = async () => {
    if (editor.value() !== written) await (typed.waits() ? null : typed.now()); // what was lost with the connection
    else {
      const now = await page.connection.ask({ do: "text" });
      if (now.ok && editor.value() === written && plain(now.text) !== written) editor.put(written = plain(now.text)); // an undo, or another window
    }
    show();
  };
  close.addEventListener("click", () => panel.close());
  panel.element.addEventListener("close", () => {
    typed.now();
    editor.end();
    page.showCodeFaults = null;
    page.besideText = false;
    page.parts.text.setAttribute("aria-pressed", "false");
  });
  show();
  editor.focus();
}
