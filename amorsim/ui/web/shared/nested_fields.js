// Fields with fields in them: tables, components, and values of one of several kinds.

import { h } from "./dom.js";
import { Field } from "./field.js";

/** A table with fields of its own. */
export class GroupField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on
   * @param {import("./field.js").MakeField} makeField */
  constructor(parameter, on, makeField) {
    super(parameter, on);
    this.makeField = makeField;
    this.fields = parameter.widget.fields.map((field) => makeField(field, on));
    const inner = h("div", { class: "inner", role: "group", "aria-labelledby": `${this.id}-legend` }, this.fields.map((field) => field.element));
    this.element.append(h("div", { class: "line" }, this.legend(parameter), this.back), this.help, inner, this.error);
    this.update(parameter);
  }

  get isBusy() {
    return this.fields.some((field) => field.isBusy);
  }

  /** @param {import("./field.js").Parameter} parameter */
  update(parameter) {
    super.update(parameter);
    parameter.widget.fields.forEach((field, n) => this.fields[n].update({ ...field, fixed: parameter.fixed || field.fixed }));
  }
}

/**
 * What decides how fields are shown: all that is known of them but their values.
 * @param {any[]} fields
 * @returns {any[]}
 */
export function shapeOf(fields) {
  return fields.map(({ path, widget }) => [path, { ...widget, fields: shapeOf(widget?.fields ?? []) }]);
}

/** A component, or none where that may be: which one it is, and the fields of its own, which may be components again. */
export class ComponentField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on
   * @param {import("./field.js").MakeField} makeField */
  constructor(parameter, on, makeField) {
    super(parameter, on);
    this.makeField = makeField;
    /** @type {Field[]} */
    this.fields = [];
    this.signature = "";
    this.select = h("select", { id: this.id, "aria-describedby": this.described, onchange: () => this.choose() });
    this.inner = h("div", { class: "inner", role: "group", "aria-label": parameter.label });
    this.element.append(h("div", { class: "line" }, this.label(parameter), this.select, this.back), this.help, this.error, this.inner);
    this.update(parameter);
  }

  get controls() {
    return [this.select];
  }

  /** Which one it is; nothing where there is none, or none is chosen yet. */
  get used() {
    return this.parameter.value?.use ?? "";
  }

  async choose() {
    const { value } = this.select;
    const isSaid = value ? await this.give(value, `${this.path}.use`) : await this.give(null);
    if (!isSaid) this.select.value = this.used;
  }

  /** @param {import("./field.js").Parameter} parameter */
  update(parameter) {
    const fields = parameter.widget.fields.map((field) => ({ ...field, fixed: parameter.fixed || field.fixed }));
    const signature = JSON.stringify(shapeOf(fields));
    if (signature !== this.signature) {
      this.signature = signature;
      this.fields = fields.map((field) => this.makeField(field, this.on));
      this.inner.replaceChildren(...this.fields.map((field) => field.element));
      this.inner.hidden = !fields.length;
    }
    super.update(parameter);
    fields.forEach((field, n) => this.fields[n].update(field));
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    const { choices, is_optional: isOptional } = parameter.widget;
    const all = [...new Set([...(this.used && !isOptional ? [] : [""]), ...choices, this.used])];
    this.select.replaceChildren(...all.map((word) => h("option", { value: word }, word || (isOptional ? "none" : "choose …"))));
    this.select.value = this.used;
    this.select.disabled = Boolean(parameter.fixed);
    super.put(parameter);
  }
}

/** @type {Record<string, string>} */
const WORDS = { number: "a number", flag: "yes or no", text: "a text", name: "a name", file: "a file", list: "numbers", forms: "tables" };

/** Kinds that show a value, by its type. @type {Record<string, string[]>} */
const SHOWN_BY = { number: ["number"], boolean: ["flag"], string: ["choice", "text", "name", "file"] };

/** What a kind of value is called.
 * @param {import("../simulator/messages.d.ts").Widget} widget */
function wordsOf({ kind, choices = [], frame }) {
  if (kind === "choice") return choices.length === 1 ? choices[0] : "a word";
  if (kind === "table") return frame ? "points" : "rows";
  return WORDS[kind] ?? kind;
}

/** What one of several kinds of value is shown by. */
export class EitherField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on
   * @param {import("./field.js").MakeField} makeField */
  constructor(parameter, on, makeField) {
    super(parameter, on);
    this.makeField = makeField;
    const { options } = parameter.widget;
    this.select = h(
      "select",
      { id: this.id, "aria-label": `kind of ${parameter.label}`, onchange: () => this.turn(Number(this.select.value)) },
      options.map((option, n) => h("option", { value: String(n) }, wordsOf(option))),
    );
    this.holder = h("div", {});
    this.element.append(h("div", { class: "line either" }, this.select), this.holder);
    this.update(parameter);
  }

  /** Which option shows a value.
   * @param {import("./field.js").Parameter} parameter */
  fitting({ value, widget }) {
    const kinds = Array.isArray(value) ? ["list", "table", "forms"] : SHOWN_BY[typeof value] ?? [];
    return Math.max(0, widget.options.findIndex((option) => kinds.includes(option.kind)));
  }

  /** @param {number} n */
  turn(n) {
    this.chosen = n;
    const [option, { value }] = [this.parameter.widget.options[n], this.parameter];
    this.inner = this.makeField({ ...this.parameter, widget: option, value: this.fitting(this.parameter) === n ? value : null }, this.on);
    this.holder.replaceChildren(this.inner.element);
  }

  get isBusy() {
    return Boolean(this.inner?.isBusy);
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    const n = this.fitting(parameter);
    this.select.value = String(n);
    this.select.disabled = Boolean(parameter.fixed);
    if (n === this.chosen) this.inner?.update({ ...parameter, widget: parameter.widget.options[n] });
    else this.turn(n);
    super.put(parameter);
  }
}
