// Programs and TOML in an editor with line numbers and colours (CodeMirror); without it, in a plain text area.

import { askName, open } from "../shared/dialogs.js";
import { h, say } from "../shared/dom.js";

const VENDOR = "/amorsim/web/vendor/codemirror";
const KEPT = "amorsim-code ";

/** @type {Promise<any> | null} */
let loading = null;

const sheet = (href) => document.head.append(h("link", { rel: "stylesheet", href }));
const script = (src) => new Promise((done, failed) => document.head.append(h("script", { src, onload: done, onerror: failed })));

/** The editor of code, fetched once; null where it cannot be had. */
function codeMirror() {
  loading ??= (async () => {
    sheet(`${VENDOR}/codemirror.css`);
    await script(`${VENDOR}/codemirror.js`);
    for (const name of ["python", "toml", "matchbrackets"]) await script(`${VENDOR}/${name}.js`);
    return /** @type {any} */ (globalThis).CodeMirror;
  })().catch(() => null);
  return loading;
}

/** Make a text area an editor of code; `value` and `mark` work on either.
 * @param {HTMLTextAreaElement} area
 * @param {"python" | "toml"} mode */
export async function dress(area, mode) {
  const Mirror = await codeMirror();
  if (!Mirror || !area.isConnected) return { value: () => area.value, mark: () => {}, changed: (does) => area.addEventListener("input", does), focus: () => area.focus() };
  const label = area.getAttribute("aria-label");
  const editor = Mirror.fromTextArea(area, {
    mode, lineNumbers: true, matchBrackets: true, indentUnit: 4, readOnly: area.readOnly, inputStyle: "contenteditable", viewportMargin: 50,
    extraKeys: { Tab: (one) => one.execCommand("indentMore"), "Shift-Tab": "indentLess", Esc: (one) => one.getInputField().blur() },
    screenReaderLabel: label,
  });
  const field = editor.getInputField();
  field.setAttribute("aria-label", label);
  field.setAttribute("aria-multiline", "true");
  editor.on("change", () => (area.value = editor.getValue()));
  let marks = [];
  return {
    value: () => editor.getValue(),
    mark: (faults) => {
      for (const one of marks) one.clear();
      marks = faults.map(({ line, message }) => {
        editor.addLineClass(line - 1, "background", "code-fault");
        const widget = editor.addLineWidget(line - 1, h("div", { class: "code-fault-text" }, message));
        return { clear: () => {
          widget.clear();
          editor.removeLineClass(line - 1, "background", "code-fault");
        } };
      });
    },
    changed: (does) => editor.on("change", does),
    focus: () => editor.focus(),
  };
}

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
    const made = await page.connection.ask({ do: "save_code", file, text: template.text, is_new: true });
    if (!made.ok) return made;
    const name = template.text.match(/^(?:def|class) +(\w+)/m)?.[1] ?? "drive";
    const said = await page.edit(`write ${made.file}`, [{ op: "set", path, value: { use: `${made.file}:${name}` } }]);
    if (said.ok) showCode(page, made.file);
    return said;
  });
}

/** Faults of a file at its lines. */
const faultsIn = (page, file) => page.faults.flatMap(({ message }) => {
  const [, line] = message.match(new RegExp(`${file.replace(/[.*+?^${}()|[\]\\]/g, "\\$&")}[\\s\\S]{0,200}?line (\\d+)`)) ?? [];
  return message.includes(file) ? [{ line: line ? Number(line) : 1, message }] : [];
});

/** Show a program, to be changed.
 * @param {import("./editor.js").EditorPage} page
 * @param {string} file */
export async function showCode(page, file) {
  const said = await page.connection.ask({ do: "code", file });
  if (!said.ok) {
    page.hint(said.error);
    return;
  }
  const key = `${KEPT}${page.state.folder}/${file}`;
  const kept = localStorage.getItem(key); // what was typed and not saved, when the browser ended
  const area = /** @type {HTMLTextAreaElement} */ (h("textarea", { "aria-label": file, spellcheck: "false" }));
  area.value = kept ?? said.text;
  area.readOnly = page.watching;
  const state = h("p", { class: "note", role: "status" }, kept === null ? "" : "what was typed before and not saved is here again");
  const save = h("button", { class: "main holders-only", title: "Ctrl + S" }, "save");
  const close = h("button", {}, "close");
  const dialog = open(file, h("div", { class: "code" }, area, state), [close, save]);
  const editor = await dress(area, "python");
  let saved = said.text;
  const show = () => {
    editor.mark(faultsIn(page, file));
    const isSaved = editor.value() === saved;
    say(state, !isSaved ? "not saved" : page.state.is_checking ? "saved; it is being tried" : faultsIn(page, file).length ? "saved; it has faults" : "saved");
  };
  const keep = async () => {
    const text = editor.value();
    const done = await page.connection.ask({ do: "save_code", file, text });
    if (!done.ok) {
      say(state, done.error);
      return;
    }
    saved = text;
    localStorage.removeItem(key);
    show();
  };
  editor.changed(() => {
    if (editor.value() === saved) localStorage.removeItem(key);
    else localStorage.setItem(key, editor.value());
    show();
  });
  save.addEventListener("click", keep);
  close.addEventListener("click", () => dialog.close());
  dialog.addEventListener("keydown", (event) => {
    if (event.key === "s" && (event.ctrlKey || event.metaKey)) {
      event.preventDefault();
      keep();
    }
  });
  page.showCodeFaults = show;
  dialog.addEventListener("close", () => (page.showCodeFaults = null));
  show();
  editor.focus();
}
