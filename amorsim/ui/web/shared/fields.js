// The fields of forms by the kind of their widget (see `Widget` in amorsim/ui/forms/description.py).

import { brief, h, say, there } from "./dom.js";
import { Field, numberIn, shown } from "./field.js";
import { ListField } from "./list_field.js";
import { ComponentField, EitherField, GroupField } from "./nested_fields.js";
import { NumberField } from "./number_field.js";

/** True or false. */
class FlagField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on */
  constructor(parameter, on) {
    super(parameter, on);
    this.box = h("input", { id: this.id, type: "checkbox", "aria-describedby": this.described, onchange: () => this.give(this.box.checked) });
    this.element.append(h("div", { class: "line" }, this.label(parameter), this.box, this.back), this.help, this.error);
    this.update(parameter);
  }

  get controls() {
    return [this.box];
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    this.box.checked = parameter.value === true;
    this.box.disabled = Boolean(parameter.fixed);
    super.put(parameter);
  }
}

/** One of some words: `choices`, or the names of what it refers to. */
class ChoiceField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on */
  constructor(parameter, on) {
    super(parameter, on);
    this.select = h("select", { id: this.id, "aria-describedby": this.described, onchange: () => this.give(this.select.value || null) });
    this.element.append(h("div", { class: "line" }, this.label(parameter), this.select, this.back), this.help, this.error);
    this.update(parameter);
  }

  get controls() {
    return [this.select];
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    const { choices = [], is_optional } = parameter.widget;
    const value = parameter.value ?? "";
    // What the value is can be chosen, be it known or not.
    const all = [...new Set([...(is_optional || parameter.is_required ? [""] : []), ...choices, value])];
    const now = [...this.select.options].map((option) => option.value);
    if (all.join("\n") !== now.join("\n") || now.length !== all.length) {
      this.select.replaceChildren(...all.map((word) => h("option", { value: word }, word || (is_optional ? "none" : "choose …"))));
    }
    this.select.value = value;
    this.select.disabled = Boolean(parameter.fixed);
    super.put(parameter);
  }
}

/** A text, or the path of a file. */
class TextField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on */
  constructor(parameter, on) {
    super(parameter, on);
    this.text = h("input", {
      id: this.id,
      type: "text",
      class: "wide",
      autocomplete: "off",
      spellcheck: "false",
      placeholder: parameter.widget.kind === "file" ? "path of a file" : "",
      "aria-describedby": this.described,
      oninput: () => (this.isTyped = true),
      onchange: () => this.commit(),
      onkeydown: (/** @type {KeyboardEvent} */ { key }) => {
        if (key === "Escape") this.put(this.parameter);
        if (key === "Escape" || key === "Enter") this.text.blur();
      },
    });
    this.element.append(h("div", { class: "line" }, this.label(parameter), this.text, this.back), this.help, this.error);
    this.update(parameter);
  }

  get isBusy() {
    return this.isTyped;
  }

  get controls() {
    return [this.text];
  }

  async commit() {
    if (!this.isTyped) return;
    const { value } = this.text;
    this.isTyped = !(await this.give(value === "" && this.parameter.widget.is_optional ? null : value));
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    this.isTyped = false;
    this.text.value = parameter.value ?? "";
    this.text.disabled = Boolean(parameter.fixed);
    super.put(parameter);
  }
}

/** @type {Record<string, string[]>} */
const DRAWN = { fixed: ["value"], normal: ["mean", "standard deviation"], uniform: ["low", "high"] };

/** A number that is fixed, or drawn from a distribution. */
class DistributionField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on */
  constructor(parameter, on) {
    super(parameter, on);
    const [unit, factor] = shown(parameter.widget.unit ?? "");
    this.factor = factor;
    this.unit = unit;
    const { is_optional } = parameter.widget;
    this.kind = h(
      "select",
      { id: this.id, "aria-describedby": this.described, onchange: () => this.turn() },
      is_optional ? h("option", { value: "none" }, "none") : null,
      Object.keys(DRAWN).map((kind) => h("option", { value: kind }, kind)),
    );
    this.numbers = [0, 1].map(() =>
      h("input", { type: "text", inputmode: "decimal", autocomplete: "off", "aria-describedby": this.described, oninput: () => (this.isTyped = true), onchange: () => this.commit() }),
    );
    const numbers = h("div", { class: "line numbers" }, ...this.numbers, h("span", { class: "unit" }, unit));
    const line = h("div", { class: "line" }, this.label(parameter), this.kind, numbers);
    this.element.append(line, this.help, this.error);
    this.update(parameter);
  }

  get isBusy() {
    return this.isTyped;
  }

  get controls() {
    return this.numbers;
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    this.isTyped = false;
    const { value } = parameter;
    const kind = value === null || value === undefined ? "none" : typeof value === "object" ? Object.keys(value)[0] : "fixed";
    this.kind.value = kind;
    this.show(typeof value === "object" && value !== null ? value[kind] : [value]);
    for (const one of [this.kind, ...this.numbers]) one.disabled = Boolean(parameter.fixed);
    super.put(parameter);
  }

  /** @param {any[]} values */
  show(values) {
    const names = DRAWN[this.kind.value] ?? [];
    this.numbers.forEach((number, n) => {
      number.hidden = n >= names.length;
      number.setAttribute("aria-label", `${this.parameter.label}: ${names[n] ?? "not used"}`);
      number.title = names[n] ?? "";
      number.value = typeof values[n] === "number" ? brief(values[n] * this.factor) : "";
    });
  }

  /** Another distribution, about the number that there was. */
  turn() {
    const kind = this.kind.value;
    const { value } = this.parameter;
    const there = typeof value === "object" && value !== null ? (value.normal?.[0] ?? (value.uniform[0] + value.uniform[1]) / 2) : value;
    const about = there ?? (this.unit === "×" ? 1 : 0);
    const wide = 0.01 * Math.abs(about) || 0.01;
    if (kind === "none") return this.give(null);
    if (kind === "fixed") return this.give(about);
    return this.give({ [kind]: kind === "normal" ? [about, wide] : [about - wide, about + wide] });
  }

  async commit() {
    const kind = this.kind.value;
    const values = this.numbers.slice(0, DRAWN[kind]?.length ?? 0).map((number) => numberIn(number.value) / this.factor);
    if (!values.every(Number.isFinite)) {
      this.fail("Expected a number.");
      return;
    }
    this.isTyped = !(await this.give(kind === "fixed" ? values[0] : { [kind]: values }));
  }
}

/** @type {Record<string, any>} */
const KINDS = {
  number: NumberField,
  flag: FlagField,
  choice: ChoiceField,
  name: ChoiceField,
  text: TextField,
  file: TextField,
  list: ListField,
  table: ListField,
  forms: ListField,
  form: GroupField,
  component: ComponentField,
  distribution: DistributionField,
  either: EitherField,
};

const NESTED = [ListField, GroupField, ComponentField, EitherField]; // which make the fields in them

/** A part of an error without a mark of its own: the error has one. */
const plainly = (/** @type {import("../simulator/messages.d.ts").FieldForm} */ part) => ({ ...part, is_given: false });

/** The parts of an error, of which each is fixed or drawn; all of them are set at once, and can be taken back.
 * @param {import("./field.js").Parameter} parameter
 * @param {HTMLElement} element
 * @param {import("./field.js").On} on */
function errorParts(parameter, element, on) {
  const target = parameter.path.replace(/\.\w+$/, "");
  const values = () => Object.fromEntries(fields.map((field) => [field.name, field.parameter.value]));
  const set = (/** @type {string} */ path, /** @type {any} */ value) => {
    const name = there(path.split(".").at(-1));
    const all = /** @type {Record<string, any>} */ ({ ...values(), [name]: value });
    // What stands in place of the nominal value leaves nothing to be multiplied or added to.
    if (name === "value" && value !== null) [all.scale, all.add] = [1, 0];
    if ((name === "scale" || name === "add") && value !== null) all.value = null;
    return on.set(target, all);
  };
  const fields = (parameter.deviation ?? []).map((part) => {
    const field = makeField(plainly(part), { set, restore: on.restore });
    const name = part.path.split(".").at(-1);
    field.element.removeAttribute("data-path"); // which is that of the error's own field
    field.element.dataset.part = name;
    return Object.assign(field, { name });
  });
  const error = h("p", { class: "error", role: "alert" });
  const take = async () => {
    const said = await on.set(target, null);
    say(error, said.ok ? "" : said.error);
  };
  const remove = h("button", { class: "tool remove", onclick: take }, "remove this error");
  element.append(...fields.map((field) => field.element), h("div", { class: "line" }, remove), error);
  const update = (/** @type {import("./field.js").Parameter} */ { deviation = [] }) => {
    deviation.forEach((part, n) => fields[n].update(plainly(part)));
    remove.disabled = !deviation.some((part) => part.is_given);
  };
  update(parameter);
  return { update };
}

/** The field of a `FieldForm` or `ParameterForm`; its `element` shows it, its `update` takes another value.
 * @param {import("./field.js").Parameter} parameter
 * @param {import("./field.js").On} on */
export function makeField(parameter, on) {
  const Kind = KINDS[parameter.widget?.kind ?? "number"];
  if (NESTED.includes(Kind)) return new Kind(parameter, on, makeField);
  return new Kind(parameter, on, (/** @type {import("./field.js").Parameter} */ shown, /** @type {HTMLElement} */ element) => errorParts(shown, element, on));
}
