// A list in a form: of numbers or texts, of rows of numbers, or of tables with fields of their own.

import { brief, h, there } from "./dom.js";
import { Field, numberIn, shown } from "./field.js";

const MOST = 200; // items that are shown

export class ListField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on
   * @param {import("./field.js").MakeField} makeField */
  constructor(parameter, on, makeField) {
    super(parameter, on);
    this.makeField = makeField;
    const { kind, item } = parameter.widget;
    this.kind = kind;
    const [unit, factor] = kind === "forms" ? ["", 1] : shown(item.unit ?? "");
    this.unit = unit;
    this.factor = factor;
    this.items = h("div", { class: "items" });
    this.grow = h("button", { class: "tool", onclick: () => this.give(this.longer()) }, "add");
    this.summary = h("summary", {}, this.legend(parameter));
    this.element.append(
      h("details", { role: "group", "aria-labelledby": `${this.id}-legend` }, this.summary, this.items, h("div", { class: "line" }, this.grow, this.back)),
      this.help,
      this.error,
    );
    this.update(parameter);
  }

  get values() {
    return Array.isArray(this.parameter.value) ? this.parameter.value : [];
  }

  get isBusy() {
    return this.items?.contains(document.activeElement) && this.values.length === this.shownCount;
  }

  get controls() {
    return [...(this.items?.querySelectorAll("input") ?? [])];
  }

  /** An item like the last, or an empty one. */
  another() {
    if (this.values.length) return structuredClone(this.values.at(-1));
    const { fields, columns, item } = this.parameter.widget;
    if (this.kind === "forms") return Object.fromEntries(fields.map((field) => [field.path, field.value]));
    if (this.kind === "table") return columns.map(() => 0);
    return item.kind === "number" ? 0 : item.kind === "flag" ? false : "";
  }

  /** The list with an item more, or all items of one that has a length. */
  longer() {
    const { length } = this.parameter.widget;
    return length ? Array.from({ length }, () => this.another()) : [...this.values, this.another()];
  }

  /** Whether items can come and go. */
  get grows() {
    const { widget, fixed, grows } = this.parameter;
    return !fixed && grows !== false && (widget.length ?? null) === null;
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    const { values } = this;
    this.shownCount = values.length;
    const legend = this.summary.firstChild;
    there(there(legend).lastChild).textContent = `${parameter.label} (${values.length})`;
    this.grow.hidden = !this.grows && Boolean(parameter.fixed || parameter.grows === false || values.length > 0);
    this.items.replaceChildren(...this.rows(parameter, values.slice(0, MOST)));
    if (values.length > MOST) this.items.append(h("p", { class: "note" }, `and ${values.length - MOST} more`));
    super.put(parameter);
  }

  /** @param {import("./field.js").Parameter} parameter
   * @param {any[]} values */
  rows(parameter, values) {
    if (this.kind === "forms") return values.map((value, n) => this.form(parameter, value, n));
    if (this.kind === "table") {
      const names = parameter.widget.columns.map((name) => h("span", {}, name));
      const head = h("div", { class: "row columns", "aria-hidden": "true" }, names, h("span", { class: "unit" }, this.unit));
      return [head, ...values.map((row, n) => this.row(row.map((/** @type {number} */ value, /** @type {number} */ k) => this.cell(value, [n, k])), n))];
    }
    return values.map((value, n) => this.row([this.cell(value, [n])], n));
  }

  /** @param {any[]} cells
   * @param {number} n */
  row(cells, n) {
    return h("div", { class: "row" }, cells, this.dropper(n));
  }

  /** @param {number} n */
  dropper(n) {
    if (!this.grows) return null;
    const drop = () => this.give(this.values.filter((_, k) => k !== n));
    return h("button", { class: "back", "aria-label": `${this.parameter.label}: remove number ${n + 1}`, title: "remove", onclick: drop }, "×");
  }

  /** @param {any} value
   * @param {number[]} place */
  cell(value, place) {
    const { columns, item } = this.parameter.widget;
    const name = columns?.[there(place.at(-1))] ?? "";
    const input = h("input", {
      type: "text",
      value: typeof value === "number" ? brief(value * this.factor) : String(value),
      disabled: Boolean(this.parameter.fixed),
      "aria-label": `${this.parameter.label} ${place[0] + 1} ${name}`.trim(),
      "aria-describedby": this.described,
      onchange: () => {
        const said = item.kind === "number" ? numberIn(input.value) / this.factor : input.value;
        if (typeof said === "number" && !Number.isFinite(said)) this.fail("Expected a number.");
        else this.give(said, `${this.path}.${place.join(".")}`);
      },
      onkeydown: (/** @type {KeyboardEvent} */ { key }) => (key === "Enter" || key === "Escape") && input.blur(),
    });
    return input;
  }

  /** @param {import("./field.js").Parameter} parameter
   * @param {any} value
   * @param {number} n */
  form(parameter, value, n) {
    const fields = parameter.widget.fields.map((field) =>
      this.makeField(
        { ...field, path: `${this.path}.${n}.${field.path}`, value: value[field.path] ?? field.value, is_given: false, fixed: parameter.fixed },
        this.on,
      ).element
    );
    return h("div", { class: "inner" }, h("div", { class: "line" }, h("span", { class: "legend" }, `${n + 1}`), this.dropper(n)), fields);
  }
}
