// Completion in the scenario's text: keys of the table that one types in, and the values that a key may have.

import { h } from "../shared/dom.js";
import { tableAt } from "./table_at.js";

const MOST = 60;
const TABLES = ["world", "simulation", "recording", "[[robots]]", "[[obstacles]]", "[[zones]]", "[[landmarks]]", "[[lights]]"];

/** @typedef {{text: string, help: string}} Choice */

/** Complete what is typed in an editor of code (CodeMirror) of the scenario's text.
 * @param {import("./editor.js").EditorPage} page
 * @param {any} editor */
export function complete(page, editor) {
  const list = h("ul", { class: "completion", role: "listbox", "aria-label": "completions", hidden: true });
  page.root.append(list);
  /** @type {Choice[]} */
  let shown = [];
  let [at, asked, from] = [0, 0, 0];
  const close = () => {
    list.hidden = true;
    shown = [];
    editor.removeKeyMap(keys);
  };
  const take = () => {
    const { line, ch } = editor.getCursor();
    const { text } = shown[at];
    editor.replaceRange(text, { line, ch: from }, { line, ch });
    close();
  };
  const point = (to) => {
    at = (to + shown.length) % shown.length;
    [...list.children].forEach((item, n) => item.setAttribute("aria-selected", String(n === at)));
    list.children[at].scrollIntoView({ block: "nearest" });
  };
  const keys = { Up: () => point(at - 1), Down: () => point(at + 1), Enter: take, Tab: take, Esc: close };
  const show = async () => {
    const own = ++asked;
    const { line, ch } = editor.getCursor();
    const before = editor.getLine(line).slice(0, ch);
    const found = await choicesAt(page, editor.getValue().split("\n"), line, before);
    if (own !== asked || !found) return own === asked && close();
    const { line: now, ch: then } = editor.getCursor();
    if (now !== line || then !== ch) return null;
    close();
    from = found.from;
    const wanted = before.slice(from).toLowerCase();
    shown = found.choices.filter(({ text }) => text.toLowerCase().includes(wanted) && text !== before.slice(from)).slice(0, MOST);
    if (!shown.length) return null;
    shown.sort((one, other) => Number(other.text.toLowerCase().startsWith(wanted)) - Number(one.text.toLowerCase().startsWith(wanted)));
    list.replaceChildren(...shown.map(({ text, help }, n) => h("li", { role: "option", onpointerdown: (event) => {
      event.preventDefault(); // the text keeps the keyboard
      at = n;
      take();
    } }, h("strong", {}, text), h("span", {}, help))));
    const { left, bottom } = editor.cursorCoords({ line, ch: from }, "window");
    list.hidden = false;
    list.style.left = `${Math.min(left, innerWidth - list.offsetWidth - 8)}px`;
    list.style.top = `${Math.min(bottom + 2, innerHeight - list.offsetHeight - 8)}px`;
    editor.addKeyMap(keys);
    point(0);
    return null;
  };
  editor.addKeyMap({ "Ctrl-Space": show });
  editor.on("inputRead", (_, { text }) => /^[\w"]$/.test(text[0]) && show());
  editor.on("cursorActivity", () => {
    if (list.hidden) return;
    const { line, ch } = editor.getCursor();
    if (ch < from || /[\s=]$/.test(editor.getLine(line).slice(0, ch))) close();
  });
  editor.on("blur", close);
  return () => list.remove();
}

/**
 * What may stand where one types: null where nothing is known. `from` is the column that it begins at.
 * @param {import("./editor.js").EditorPage} page
 * @param {string[]} lines
 * @param {number} line
 * @param {string} before the line up to the cursor
 * @returns {Promise<{from: number, choices: Choice[]} | null>}
 */
async function choicesAt(page, lines, line, before) {
  const header = before.match(/^\s*(\[\[?[\w.-]*)$/);
  if (header) return { from: before.length - header[1].length, choices: TABLES.map((name) => ({ text: name.startsWith("[") ? name : `[${name}]`, help: "" })) };
  const { path, keys } = tableAt(lines, line);
  const key = before.match(/^\s*([\w-]*)$/);
  const value = before.match(/^\s*([\w-]+)\s*=\s*("[\w.-]*)$/);
  if (!path || (!key && !value)) return null;
  const [first, second] = path.split(".");
  const said = await page.connection.ask({ do: "inspect", path: second === undefined || Number.isNaN(Number(second)) ? first : `${first}.${second}` });
  if (!said.ok) return null;
  const section = said.sections.find((one) => one.path === path);
  const own = said.sections.flatMap(({ fields }) => fields).filter((field) => field.path.startsWith(`${path}.`) && !field.path.slice(path.length + 1).includes("."));
  if (key) {
    const inside = said.sections.filter((one) => one.path.startsWith(`${path}.`) && !one.path.slice(path.length + 1).includes("."));
    const choices = [
      ...(section?.use ? [{ text: "use", help: `the kind of ${section.use.kind}` }] : []),
      ...own.map((field) => ({ text: field.path.slice(path.length + 1), help: [field.help, unitOf(field)].filter(Boolean).join(" · ") })),
      ...inside.map((one) => ({ text: one.path.slice(path.length + 1), help: one.title })),
    ];
    const seen = new Set(keys);
    return { from: before.length - key[1].length, choices: choices.filter(({ text }) => !seen.has(text) && seen.add(text)) };
  }
  const values = value[1] === "use" ? section?.use?.choices : valuesOf(own.find((field) => field.path === `${path}.${value[1]}`)?.widget);
  return values ? { from: before.length - value[2].length, choices: values.map((one) => ({ text: `"${one}"`, help: "" })) } : null;
}

const unitOf = ({ widget }) => (widget?.unit ? `[${widget.unit}]` : "");

/** The values that a form offers.
 * @param {any} widget
 * @returns {string[] | undefined} */
function valuesOf(widget) {
  if (!widget) return undefined;
  if (Array.isArray(widget.choices)) return widget.choices.map(String);
  return widget.options?.map(valuesOf).find(Boolean);
}
