// Controllers' programs, shown and changed beside the drawing.

import { askName } from "../shared/dialogs.js";
import { h, say } from "../shared/dom.js";
import { openBeside } from "./beside.js";
import { dress } from "./code_editor.js";

export const PAUSE = 400; // [ms] without typing, after which what was typed is a step: its faults show within a second

/** Let what is typed be taken at each pause in typing, and when it is left; returns what takes it now.
 * @param {Awaited<ReturnType<typeof dress>>} editor
 * @param {() => Promise<any>} take */
export function atPauses(editor, take) {
  let pause = 0;
  const drop = () => {
    clearTimeout(pause);
    pause = 0;
  };
  const now = () => {
    drop();
    return take();
  };
  editor.changed(() => {
    clearTimeout(pause);
    pause = setTimeout(now, PAUSE);
  });
  editor.left(now);
  return { now, drop, waits: () => pause !== 0 };
}

/** A text as it can be shown and typed: with one end of all lines, for which the server puts those of the file.
 * @param {string} text */
export const plain = (text) => text.replace(/\r\n?/g, "\n");

/** The file and the name of a controller such as `my_controller.py:drive`; null for one that is registered.
 * @param {string} use */
export function programOf(use) {
  const [, file, name] = use.match(/^(.+\.py):(.+)$/) ?? [];
  return file ? { file, name } : null;
}

/** Write a controller for a robot: a new file from the template, named in the scenario.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} path of the controller's table */
export function newController(page, path) {
  askName("A controller of your own", "file", "my_controller.py", `a file of Python in ${page.state.folder}; it begins with an example`, async (given) => {
    const file = given.endsWith(".py") ? given : `${given}.py`;
    const template = await page.connection.ask({ do: "code", file });
    if (!template.ok) return template;
    const made = await page.connection.ask({ do: "write_code", file, text: template.text, controller: path });
    if (made.ok) {
      page.hint(`write ${made.file}`);
      showCode(page, made.file);
    }
    return made;
  });
}

/** Faults of a file at its lines. */
const faultsIn = (/** @type {import("./editor.js").EditorPage} */ page, /** @type {string} */ file) => page.faults.flatMap(({ message }) => {
  const [, line] = message.match(new RegExp(`${file.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}[\\s\\S]{0,200}?line (\\d+)`)) ?? [];
  return message.includes(file) ? [{ line: line ? Number(line) : 1, message }] : [];
});

/** Show a program, to be changed: each pause in typing is a step of the document. It is tried when it is saved.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} file */
export async function showCode(page, file) {
  const said = await page.connection.ask({ do: "code", file });
  if (!said.ok) {
    page.hint(said.error);
    return;
  }
  const area = /** @type {HTMLTextAreaElement} */ (h("textarea", { "aria-label": file, spellcheck: "false" }));
  area.value = said.text;
  area.readOnly = page.watching;
  const state = h("p", { class: "note", role: "status" });
  const save = h("button", { class: "main holders-only", title: "Ctrl + S" }, "save");
  const close = h("button", {}, "close");
  const panel = openBeside(page, file, h("div", { class: "code" }, area, state), [close, save]);
  const editor = await dress(area, "python");
  let [written, isSaved] = [plain(said.text), said.is_saved]; // what the document says, and whether the file does
  let tried = ""; // what the user has asked to be tried
  const show = () => {
    const faults = faultsIn(page, file);
    editor.mark(faults);
    const where = editor.value() !== written ? "changed" : isSaved ? "saved" : written === tried ? "kept; save the scenario to write this file" : "kept; Ctrl + S saves it and tries it";
    say(state, page.state.is_checking ? "it is being tried" : faults.length ? `${where}; it has faults` : where);
  };
  const send = async (/** @type {string} */ command) => {
    typed.drop();
    const text = editor.value();
    if (page.watching || (command === "write_code" && text === written)) return;
    const done = await page.connection.ask({ do: command, file, text });
    if (!done.ok) {
      say(state, done.error);
      return;
    }
    [written, isSaved] = [text, Boolean(done.is_saved)];
    if (command === "save_code") tried = text;
    show();
  };
  const typed = atPauses(editor, () => send("write_code"));
  editor.changed(show);
  save.addEventListener("click", () => send("save_code"));
  close.addEventListener("click", () => panel.close());
  panel.element.addEventListener("keydown", (event) => {
    if (event.key === "s" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      send("save_code");
    }
  });
  page.showCodeFaults = async () => {
    if (editor.value() !== written) await (typed.waits() ? null : typed.now()); // what was lost with the connection
    else {
      const now = await page.connection.ask({ do: "code", file });
      if (now.ok && editor.value() === written) { // another window, or an undo, may have changed it
        [written, isSaved] = [plain(now.text), now.is_saved];
        if (editor.value() !== written) editor.put(written);
      }
    }
    show();
  };
  panel.element.addEventListener("close", () => {
    typed.now();
    editor.end();
    page.showCodeFaults = null;
  });
  show();
  editor.focus();
}
