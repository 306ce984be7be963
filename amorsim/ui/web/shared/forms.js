// Forms made of components' own fields: label, unit, bounds, help, a slider, and back to what the scenario says.
// Nothing here knows the Simulator: the Editor makes its forms of the same fields.

import { brief, h, niceStep, say } from "./dom.js";

const DEGREES = 180 / Math.PI;
const KINDS = {
  systematic: "Systematic errors",
  noise: "Noise",
  nominal: "What the robot holds of itself",
  controller: "Controller",
  estimator: "Estimator",
};

const pretty = (unit) => unit.replace("^2", "²").replace("^3", "³");

/** A unit as it is shown, and the factor to it: angles in degrees. */
export function shown(unit) {
  if (/^rad(?![a-z])/.test(unit)) return [pretty(unit.replace(/^rad/, "°")), DEGREES];
  return [pretty(unit), 1];
}

export class Form {
  /**
   * @param on `{set(path, value): promise of {ok, error}, restore(path)}`; values in SI units
   */
  constructor(on) {
    this.on = on;
    this.fields = new Map();
    this.element = h("div", { class: "form" });
    this.signature = "";
  }

  /** Show these parameters; where they are the same ones as before only their values change. */
  show(parameters) {
    const signature = parameters.map((p) => p.path).join("\n");
    if (signature !== this.signature) {
      this.signature = signature;
      this.build(parameters);
    }
    for (const parameter of parameters) this.fields.get(parameter.path)?.update(parameter);
  }

  /** Let go what was typed and is not so. */
  forget() {
    for (const field of this.fields.values()) field.put(field.parameter);
  }

  build(parameters) {
    this.fields.clear();
    const sections = [];
    for (const [kind, title] of Object.entries(KINDS)) {
      const mine = parameters.filter((p) => p.kind === kind);
      if (!mine.length) continue;
      const groups = [...new Set(mine.map((p) => p.group))];
      const parts = groups.map((group) => {
        const rows = mine.filter((p) => p.group === group).map((parameter) => {
          const field = new Field(parameter, this.on);
          this.fields.set(parameter.path, field);
          return field.element;
        });
        const opened = kind === "systematic" ? group === "drive" : kind === "noise" && groups.length < 2;
        return h("details", { class: "group", open: opened }, h("summary", {}, groupTitle(group)), rows);
      });
      sections.push(h("section", {}, h("h3", {}, title), parts));
    }
    this.element.replaceChildren(...sections);
  }
}

const groupTitle = (group) => group.replace(/^sensors\./, "").replaceAll("_", " ").replaceAll(".", " · ");

const KEYS_REST = 350; // milliseconds without a key after which a slider's value is set
let serial = 0;

class Field {
  constructor(parameter, on) {
    this.on = on;
    this.path = parameter.path;
    const id = `field-${++serial}`;
    const [unit, factor] = shown(parameter.unit);
    this.factor = factor;
    this.isWhole = parameter.type === "int";
    this.error = h("p", { class: "error", role: "alert", id: `${id}-error` });
    this.help = h("p", { class: "help", id: `${id}-help` });
    this.number = h("input", {
      id,
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      "aria-describedby": `${id}-help ${id}-error`,
      oninput: () => (this.isTyped = true),
      onchange: () => this.isTyped && this.commit(this.number.value),
      onkeydown: (event) => this.key(event),
    });
    this.slider = h("input", {
      type: "range",
      // Any: else it could not hold a value that is no multiple of its step.
      step: this.isWhole ? "1" : "any",
      "aria-label": parameter.label,
      oninput: () => this.preview(),
      onchange: () => this.settle(),
      onpointerdown: () => (this.rest = 0),
      onkeydown: () => (this.rest = KEYS_REST),
      onblur: () => this.slides && this.drop(),
    });
    this.back = h(
      "button",
      { class: "back", "aria-label": `${parameter.label}: as in the scenario`, title: "as in the scenario", onclick: () => this.restore() },
      "↺",
    );
    this.tick = h("span", { class: "tick", "aria-hidden": "true" });
    this.element = h(
      "div",
      { class: "field", "data-path": parameter.path },
      h("div", { class: "line" }, h("label", { for: id, title: parameter.help }, parameter.label), this.number, h("span", { class: "unit" }, unit)),
      h("div", { class: "line" }, h("div", { class: "track" }, this.slider, this.tick), this.back),
      this.help,
      this.error,
    );
    this.update(parameter);
  }

  update(parameter) {
    this.parameter = parameter;
    const [from, to] = parameter.slider;
    if (!this.slides) {
      [this.slider.min, this.slider.max] = [from, to].map((end) => String(end * this.factor));
      this.step = niceStep(Math.max((Math.abs(to - from) * this.factor) / 1000, 1e-12));
    }
    const origin = parameter.scenario ?? parameter.value;
    const share = origin === null ? -1 : (origin - from) / (to - from);
    this.tick.hidden = !(share >= 0 && share <= 1);
    this.tick.style.setProperty("--at", share);
    const changed = parameter.value !== parameter.scenario && !(parameter.value === null && parameter.drawn);
    this.element.classList.toggle("changed", changed);
    this.back.disabled = !changed;
    say(this.help, this.words(parameter));
    if (!this.isTyped && !this.slides) this.put(parameter);
  }

  words(parameter) {
    const [unit, factor] = shown(parameter.unit);
    const bound = (value) => brief(value * factor);
    const [openLow, openHigh] = parameter.is_open;
    const limits = [];
    if (parameter.low !== null) limits.push(`${openLow ? ">" : "≥"} ${bound(parameter.low)}`);
    if (parameter.high !== null) limits.push(`${openHigh ? "<" : "≤"} ${bound(parameter.high)}`);
    const parts = [parameter.help, limits.length ? `${limits.join(" and ")} ${unit === "×" ? "" : unit}`.trim() : ""];
    if (parameter.drawn) parts.push(`drawn: ${parameter.drawn}`);
    if (parameter.kind === "systematic" && parameter.nominal !== null && parameter.true !== null) {
      parts.push(`true ${brief(parameter.true)}, believed ${brief(parameter.nominal)}`);
    }
    return parts.filter(Boolean).join("; ");
  }

  put(parameter) {
    this.isTyped = false;
    this.number.value = parameter.value === null ? "" : brief(parameter.value * this.factor);
    this.number.placeholder = parameter.drawn ? "drawn" : "";
    // The slider of what is drawn stands in its middle, which is that of what it is drawn from.
    const [from, to] = parameter.slider;
    this.slider.value = String((parameter.value ?? (from + to) / 2) * this.factor);
    this.slider.setAttribute("aria-valuetext", this.number.value || parameter.drawn);
    this.fail("");
  }

  /** Enter sets what was typed and Escape lets it go; both give the keyboard back. What is wrong can be corrected. */
  async key({ key }) {
    if (key === "Escape") this.put(this.parameter);
    if (key === "Enter" && this.isTyped && !(await this.commit(this.number.value))) return;
    if (key === "Escape" || key === "Enter") this.number.blur();
  }

  /** What the slider stands for: a round number, within its ends. */
  get slid() {
    const value = Math.round(Number(this.slider.value) / this.step) * this.step;
    return this.isWhole ? Number(this.slider.value) : Math.min(Math.max(value, Number(this.slider.min)), Number(this.slider.max));
  }

  preview() {
    this.slides = true;
    this.number.value = brief(this.slid);
    this.slider.setAttribute("aria-valuetext", this.number.value);
  }

  /** Set where the slider was let go: one change, however far it was dragged. Of keys pressed one after another the last. */
  settle() {
    clearTimeout(this.soon);
    if (this.slides) this.soon = setTimeout(() => this.drop(), this.rest ?? KEYS_REST);
  }

  async drop() {
    clearTimeout(this.soon);
    if (this.slides) await this.commit(this.number.value);
    this.slides = false;
  }

  /** Set a value, once; whether it is so now. */
  async commit(text) {
    if (text === this.committing) return false;
    const value = Number(String(text).trim().replace("−", "-").replace(",", "."));
    if (String(text).trim() === "" || !Number.isFinite(value)) {
      this.fail("Expected a number.");
      return false;
    }
    const exact = this.isWhole ? Math.round(value) : value / this.factor;
    this.committing = text;
    const said = await this.on.set(this.path, exact);
    this.committing = null;
    this.isTyped = !said.ok;
    this.fail(said.ok ? "" : said.error);
    return said.ok;
  }

  async restore() {
    const said = await this.on.restore(this.path);
    this.fail(said.ok ? "" : said.error);
  }

  fail(problem) {
    // The form says already whose parameter it is.
    say(this.error, problem.replace(/^(robot '[^']*', )?([\w.[\]]+: )+/, ""));
    this.number.setAttribute("aria-invalid", problem ? "true" : "false");
  }
}
