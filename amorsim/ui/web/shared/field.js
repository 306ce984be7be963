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

const pretty = (/** @type {string} */ unit) => unit.replaceAll("^2", "²").replaceAll("^3", "³");

/** A unit as it is shown, and the factor to it: angles in degrees.
 * @param {string} unit
 * @returns {[string, number]} */
export function shown(unit) {
  if (/^rad(?![a-z])/.test(unit)) return [pretty(unit.replace(/^rad/, "°")), DEGREES];
  return [pretty(unit.replace(/^deg(?![a-z])/, "°")), 1];
}

/** The bounds of a number in words: "> 0 and ≤ 9 m".
 * @param {any} bounds */
export function limits({ low, high, is_open, unit }) {
  const [name, factor] = shown(unit ?? "");
  const parts = [];
  if (typeof low === "number") parts.push(`${is_open[0] ? ">" : "≥"} ${brief(low * factor)}`);
  if (typeof high === "number") parts.push(`${is_open[1] ? "<" : "≤"} ${brief(high * factor)}`);
  return parts.length ? `${parts.join(" and ")} ${name === "×" ? "" : name}`.trim() : "";
}

/** A typed number, or NaN.
 * @param {any} text */
export function numberIn(text) {
  const plain = String(text).trim().replace("−", "-").replace(",", ".");
  return plain === "" ? NaN : Number(plain);
}

/**
 * What a form shows of a value: a `FieldForm`, or a `ParameterForm` of a robot that runs; `grows` is false of a list whose length is set.
 * @typedef {Pick<import("../simulator/messages.d.ts").FieldForm, "path" | "label" | "help" | "value" | "widget" | "fixed">
 *   & Partial<import("../simulator/messages.d.ts").FieldForm> & Partial<import("../simulator/messages.d.ts").ParameterForm> & {grows?: boolean}} Parameter
 */

/**
 * Sets and restores values by path, in the form's units.
 * @typedef {{ok: boolean, error: string}} Said
 * @typedef {{set: (path: string, value: any) => Promise<Said>, restore: (path: string) => Promise<Said>}} On
 * And, where noise can come and go, adds and removes elements of chains; `ask` has the manuals of components.
 * @typedef {On & {ask: (command: object) => Promise<any>, noises: (path: string, table?: object) => Promise<any>,
 *   add: (path: string, table: object) => Promise<Said>, remove: (path: string) => Promise<Said>}} FormOn
 * @typedef {(parameter: Parameter, on: On) => Field} MakeField
 */

let serial = 0;

/** Whether a value is another than in the scenario, or is given at all where there is none to compare it with. */
export const isChanged = (/** @type {Parameter} */ parameter) => parameter.is_changed ?? parameter.is_given;

/** Which of the marks a field has.
 * @param {Parameter} parameter */
export function stateOf(parameter) {
  if (parameter.fixed) return "fixed";
  if (isChanged(parameter)) return "changed";
  if (parameter.drawn) return "drawn";
  if (parameter.origin === "model" || parameter.origin === "device") return "inherited";
  return parameter.origin === "default" || parameter.is_given === false ? "default" : "own";
}

/** What the marks mean, in a line. */
export function marksInWords() {
  const parts = /** @type {const} */ (["changed", "drawn", "inherited", "fixed"]).map((state) => h("span", {}, h("span", { class: "mark" }, MARKS[state][0]), MARKS[state][1]));
  return h("p", { class: "legend-of-marks" }, parts);
}

export class Field {
  /**
   * @param {Parameter} parameter
   * @param {On} on
   */
  constructor(parameter, on) {
    this.on = on;
    this.parameter = parameter;
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

  /** The label of one control.
   * @param {Parameter} parameter */
  label(parameter) {
    return h("label", { for: this.id, title: parameter.help }, this.mark, parameter.label);
  }

  /** The name of a group of controls.
   * @param {Parameter} parameter */
  legend(parameter) {
    return h("span", { class: "legend", id: `${this.id}-legend`, title: parameter.help }, this.mark, parameter.label);
  }

  /** Show a parameter, whose value may be another than before.
   * @param {Parameter} parameter */
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

  /** @param {Parameter} parameter */
  words(parameter) {
    const parts = [parameter.help, limits({ ...parameter.widget, ...parameter }), parameter.fixed, ...this.more(parameter)];
    const state = stateOf(parameter);
    if (state === "changed" && parameter.is_changed) parts.push(`changed${parameter.source ? `; the scenario's value is ${parameter.source}` : ""}`);
    else if (parameter.source) parts.push(parameter.source);
    return parts.filter(Boolean).join("; ").replace(/\.;/g, ";");
  }

  /** What else is to be said of a parameter. @returns {string[]}
   * @param {Parameter} _parameter */
  more(_parameter) {
    return [];
  }

  /** Show a parameter's value in the controls.
   * @param {Parameter} _parameter */
  put(_parameter) {
    this.fail("");
  }

  /** Set a value; whether it is so now.
   * @param {any} value */
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

  /** @param {string} problem */
  fail(problem) {
    // The form says already whose parameter it is.
    say(this.error, problem.replace(/^(robot '[^']*', )?([\w.[\]]+: )+/, ""));
    for (const control of this.controls) control.setAttribute("aria-invalid", problem ? "true" : "false");
  }
}
