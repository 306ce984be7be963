// What all fields of a form have: a label, marks of where the value comes from, help, a fault, and the way back.

import { brief, h, say } from "./dom.js";

const DEGREES = 180 / Math.PI;
const MARKS = {
  changed: ["●", "changed"],
  drawn: ["≈", "drawn at random"],
  inherited: ["↳", "from a model or device"],
  fixed: ["▪", "cannot change now"],
  default: ["", "a default"],
  own: ["", ""],
};

const pretty = (unit) => unit.replaceAll("^2", "²").replaceAll("^3", "³");

/** A unit as it is shown, and the factor to it: angles in degrees. */
export function shown(unit) {
  if (/^rad(?![a-z])/.test(unit)) return [pretty(unit.replace(/^rad/, "°")), DEGREES];
  return [pretty(unit.replace(/^deg(?![a-z])/, "°")), 1];
}

/** The bounds of a number in words: "> 0 and ≤ 9 m". */
export function limits({ low, high, is_open, unit }) {
  const [name, factor] = shown(unit ?? "");
  const parts = [];
  if (typeof low === "number") parts.push(`${is_open[0] ? ">" : "≥"} ${brief(low * factor)}`);
  if (typeof high === "number") parts.push(`${is_open[1] ? "<" : "≤"} ${brief(high * factor)}`);
  return parts.length ? `${parts.join(" and ")} ${name === "×" ? "" : name}`.trim() : "";
}

/** A typed number, or NaN. */
export function numberIn(text) {
  const plain = String(text).trim().replace("−", "-").replace(",", ".");
  return plain === "" ? NaN : Number(plain);
}

let serial = 0;

/** @param parameter a `FieldForm` or `ParameterForm`; with `is_changed` where it is compared with a scenario */
export const isChanged = (parameter) => parameter.is_changed ?? parameter.is_given;

/** Which of the marks a field has. */
export function stateOf(parameter) {
  if (parameter.fixed) return "fixed";
  if (isChanged(parameter)) return "changed";
  if (parameter.drawn) return "drawn";
  if (parameter.origin === "model" || parameter.origin === "device") return "inherited";
  return parameter.origin === "default" || parameter.is_given === false ? "default" : "own";
}

/** What the marks mean, in a line. */
export function marksInWords() {
  const parts = ["changed", "drawn", "inherited", "fixed"].map((state) => h("span", {}, h("span", { class: "mark" }, MARKS[state][0]), MARKS[state][1]));
  return h("p", { class: "legend-of-marks" }, parts);
}

export class Field {
  /**
   * @param on `{set(path, value): promise of {ok, error}, restore(path): the same}`; values in the form's units
   */
  constructor(parameter, on) {
    this.on = on;
    this.path = parameter.path;
    this.id = `field-${++serial}`;
    this.error = h("p", { class: "error", role: "alert", id: `${this.id}-error` });
    this.help = h("p", { class: "help", id: `${this.id}-help` });
    this.described = `${this.id}-help ${this.id}-error`;
    this.mark = h("span", { class: "mark" });
    this.back = h(
      "button",
      { class: "back", "aria-label": `${parameter.label}: as in the scenario`, title: "as in the scenario", onclick: () => this.restore() },
      "↺",
    );
    this.element = h("div", { class: "field", "data-path": parameter.path, "data-kind": parameter.widget?.kind });
  }

  /** The label of one control. */
  label(parameter) {
    return h("label", { for: this.id, title: parameter.help }, this.mark, parameter.label);
  }

  /** The name of a group of controls. */
  legend(parameter) {
    return h("span", { class: "legend", id: `${this.id}-legend`, title: parameter.help }, this.mark, parameter.label);
  }

  /** Show a parameter, whose value may be another than before. */
  update(parameter) {
    this.parameter = parameter;
    const state = stateOf(parameter);
    const [sign, words] = MARKS[state];
    say(this.mark, sign);
    this.mark.title = words;
    for (const name of Object.keys(MARKS)) this.element.classList.toggle(name, name === state);
    this.element.dataset.state = state;
    this.back.disabled = Boolean(parameter.fixed) || !isChanged(parameter) || Boolean(parameter.is_added);
    say(this.help, this.words(parameter));
    if (!this.isBusy) this.put(parameter);
  }

  /** Whether the user is changing it. @returns {boolean} */
  get isBusy() {
    return false;
  }

  words(parameter) {
    const parts = [parameter.help, limits({ ...parameter.widget, ...parameter }), parameter.fixed, ...this.more(parameter)];
    const state = stateOf(parameter);
    if (state === "changed" && parameter.is_changed) parts.push(`changed${parameter.source ? `; the scenario's value is ${parameter.source}` : ""}`);
    else if (parameter.source) parts.push(parameter.source);
    return parts.filter(Boolean).join("; ").replace(/\.;/g, ";");
  }

  /** What else is to be said of a parameter. @returns {string[]} */
  more(_parameter) {
    return [];
  }

  /** Show a parameter's value in the controls. */
  put(_parameter) {
    this.fail("");
  }

  /** Set a value; whether it is so now. */
  async give(value, path = this.path) {
    const said = await this.on.set(path, value);
    this.fail(said.ok ? "" : said.error);
    return said.ok;
  }

  async restore() {
    const said = await this.on.restore(this.path);
    this.fail(said.ok ? "" : said.error);
  }

  /** The controls that are marked when the value is wrong. @returns {HTMLElement[]} */
  get controls() {
    return [];
  }

  fail(problem) {
    // The form says already whose parameter it is.
    say(this.error, problem.replace(/^(robot '[^']*', )?([\w.[\]]+: )+/, ""));
    for (const control of this.controls) control.setAttribute("aria-invalid", problem ? "true" : "false");
  }
}
