// Completion in the scenario's text: keys of the table that one types in, and the values that a key may have.

import { tableAt } from "./table_at.js";

const TABLES = ["world", "simulation", "recording", "floor", "task", "[[robots]]", "[[obstacles]]", "[[zones]]", "[[landmarks]]", "[[lights]]"];

/**
 * What may stand where one types: null where nothing is known. `from` is the column that it begins at.
 * @param {import("./editor.js").EditorPage} page
 * @param {string[]} lines
 * @param {number} line
 * @param {string} before the line up to the cursor
 * @returns {ReturnType<import("./code_editor.js").Choices>}
 */
export async function choicesAt(page, lines, line, before) {
  const header = before.match(/^\s*(\[\[?[\w.-]*)$/);
  if (header) return { from: before.length - header[1].length, choices: TABLES.map((name) => ({ text: name.startsWith("[") ? name : `[${name}]`, help: "" })) };
  const { path: written, keys } = tableAt(lines, line);
  const key = before.match(/^\s*([\w-]*)$/);
  const value = before.match(/^\s*([\w-]+)\s*=\s*("[\w.-]*)$/);
  if (!written || (!key && !value)) return null;
  const [first, second] = written.split(".");
  const isListed = second !== undefined && !Number.isNaN(Number(second));
  const thing = isListed ? `${first}.${second}` : first;
  let [said, path] = [await page.connection.ask({ do: "inspect", path: thing }), written];
  if (!said.ok && isListed) { // one that is only being written: as the first of its kind
    path = `${first}.0${written.slice(thing.length)}`;
    said = await page.connection.ask({ do: "inspect", path: `${first}.0` });
  }
  if (!said.ok) return null;
  const sections = /** @type {any[]} */ (said.sections);
  const section = sections.find((/** @type {any} */ one) => one.path === path);
  const own = /** @type {import("../simulator/messages.d.ts").FieldForm[]} */ (sections.flatMap(({ fields }) => fields)).filter((field) => field.path.startsWith(`${path}.`) && !field.path.slice(path.length + 1).includes("."));
  if (key) {
    const inside = sections.filter((one) => one.path.startsWith(`${path}.`) && !one.path.slice(path.length + 1).includes("."));
    const choices = [
      ...(section?.use ? [{ text: "use", help: `the kind of ${section.use.kind}` }] : []),
      ...own.map((field) => ({ text: field.path.slice(path.length + 1), help: [field.help, unitOf(field)].filter(Boolean).join(" · ") })),
      ...inside.map((one) => ({ text: one.path.slice(path.length + 1), help: one.title })),
    ];
    const seen = new Set(keys);
    return { from: before.length - key[1].length, choices: choices.filter(({ text }) => !seen.has(text) && seen.add(text)) };
  }
  if (!value) return null;
  const values = value[1] === "use" ? section?.use?.choices : valuesOf(own.find((field) => field.path === `${path}.${value[1]}`)?.widget);
  return values ? { from: before.length - value[2].length, choices: values.map((/** @type {string} */ one) => ({ text: `"${one}"`, help: "" })) } : null;
}

const unitOf = (/** @type {import("../simulator/messages.d.ts").FieldForm} */ { widget }) => (widget?.unit ? `[${widget.unit}]` : "");

/** The values that a form offers.
 * @param {any} widget
 * @returns {string[] | undefined} */
function valuesOf(widget) {
  if (!widget) return undefined;
  if (Array.isArray(widget.choices)) return widget.choices.map(String);
  return widget.options?.map(valuesOf).find(Boolean);
}
