// A number in a form: typed, or dragged where it has a slider; and for an error, how it is drawn.

import { brief, h, niceStep } from "./dom.js";
import { Field, numberIn, shown } from "./field.js";

const KEYS_REST = 350; // milliseconds without a key after which a slider's value is set

export class NumberField extends Field {
  /** @param {import("./field.js").Parameter} parameter
   * @param {import("./field.js").On} on
   * @param {(parameter: import("./field.js").Parameter, element: HTMLElement) => {update(parameter: import("./field.js").Parameter): void}} drawnFields */
  constructor(parameter, on, drawnFields) {
    super(parameter, on);
    const [unit, factor] = shown(parameter.unit ?? parameter.widget.unit);
    this.factor = factor;
    /** What is being set. @type {string | null} */
    this.committing = null;
    this.isWhole = parameter.type ? parameter.type === "int" : parameter.widget.is_whole;
    this.number = h("input", {
      id: this.id,
      type: "text",
      inputmode: "decimal",
      autocomplete: "off",
      "aria-describedby": this.described,
      oninput: () => (this.isTyped = true),
      onchange: () => this.isTyped && this.commit(this.number.value),
      onkeydown: (/** @type {KeyboardEvent} */ event) => this.key(event),
    });
    this.slider = h("input", {
      type: "range",
      // Any: else it could not hold a value that is not a multiple of its step.
      step: this.isWhole ? "1" : "any",
      "aria-label": [parameter.label, parameter.group, parameter.kind === "systematic" ? "error" : parameter.kind].filter(Boolean).join(", "),
      oninput: () => this.preview(),
      onchange: () => this.settle(),
      onpointerdown: () => (this.rest = 0),
      onkeydown: () => (this.rest = KEYS_REST),
      onblur: () => this.slides && this.drop(),
    });
    this.tick = h("span", { class: "tick", "aria-hidden": "true" });
    this.sliding = h("div", { class: "line" }, h("div", { class: "track" }, this.slider, this.tick), this.back);
    this.drawing = this.drawnPart(parameter, drawnFields);
    const line = h("div", { class: "line" }, this.label(parameter), this.number, h("span", { class: "unit" }, unit), this.drawing?.button);
    this.hasSlider = Boolean(parameter.slider?.length);
    if (!this.hasSlider) line.append(this.back);
    this.element.append(line, ...(this.hasSlider ? [this.sliding] : []), this.help, this.error, ...(this.drawing ? [this.drawing.element] : []));
    this.update(parameter);
  }

  /** Of a systematic error: a button that opens the form of its parts, each fixed or drawn.
   * @param {import("./field.js").Parameter} parameter
   * @param {(parameter: import("./field.js").Parameter, element: HTMLElement) => {update(parameter: import("./field.js").Parameter): void}} drawnFields */
  drawnPart(parameter, drawnFields) {
    if (!parameter.deviation?.length || !drawnFields) return null;
    const element = h("div", { class: "parts", id: `${this.id}-parts`, hidden: true });
    const button = h(
      "button",
      {
        class: "back more",
        title: "fixed or drawn at random",
        "aria-label": `${parameter.label}: fixed or drawn at random`,
        "aria-expanded": "false",
        "aria-controls": `${this.id}-parts`,
        onclick: () => {
          element.hidden = !element.hidden;
          button.setAttribute("aria-expanded", String(!element.hidden));
          if (!element.hidden) part.fields ? part.fields.update(this.parameter) : (part.fields = drawnFields(this.parameter, element));
        },
      },
      "≈",
    );
    /** @type {{element: HTMLElement, button: HTMLElement, fields: any}} */
    const part = { element, button, fields: null };
    return part;
  }

  /** @param {import("./field.js").Parameter} parameter */
  update(parameter) {
    const [from, to] = parameter.slider ?? [];
    if (this.hasSlider && to !== undefined) {
      if (!this.slides) {
        [this.slider.min, this.slider.max] = [from, to].map((end) => String(end * this.factor));
        this.step = niceStep(Math.max((Math.abs(to - from) * this.factor) / 1000, 1e-12));
      }
      const origin = parameter.scenario ?? parameter.value ?? parameter.drawn_value ?? null;
      const share = origin === null ? -1 : (origin - from) / (to - from);
      this.tick.hidden = !(share >= 0 && share <= 1);
      this.tick.style.setProperty("--at", String(share));
    }
    this.number.disabled = this.slider.disabled = Boolean(parameter.fixed);
    super.update(parameter);
    if (this.drawing && !this.drawing.element.hidden) this.drawing.fields?.update(parameter);
  }

  get isBusy() {
    return Boolean(this.isTyped || this.slides);
  }

  get controls() {
    return [this.number];
  }

  /** @param {import("./field.js").Parameter} parameter */
  more(parameter) {
    const parts = [];
    if (parameter.drawn) parts.push(`drawn from ${parameter.drawn}${typeof parameter.drawn_value === "number" ? `: ${brief(parameter.drawn_value * this.factor)}` : ""}`);
    if (parameter.kind === "systematic" && typeof parameter.nominal === "number" && parameter.true !== null) {
      parts.push(`true ${brief(parameter.true)}, believed ${brief(parameter.nominal)}`);
    }
    return parts;
  }

  /** @param {import("./field.js").Parameter} parameter */
  put(parameter) {
    this.isTyped = false;
    const { value } = parameter;
    this.number.value = value === null || value === undefined ? "" : typeof value === "number" ? brief(value * this.factor) : String(value);
    const drawn = typeof parameter.drawn_value === "number" ? brief(parameter.drawn_value * this.factor) : "drawn";
    this.number.placeholder = parameter.drawn ? drawn : parameter.widget?.is_optional ? "none" : "";
    // The slider of what is drawn stands at what was drawn, or else in its middle.
    if (this.hasSlider) {
      const [from, to] = parameter.slider?.length ? parameter.slider : [0, 0];
      this.slider.value = String((value ?? parameter.drawn_value ?? (from + to) / 2) * this.factor);
      this.slider.setAttribute("aria-valuetext", this.number.value || parameter.drawn || "none");
    }
    this.fail("");
  }

  /** Enter sets what was typed and Escape lets it go; both give the keyboard back. What is wrong can be corrected.
   * @param {KeyboardEvent} event */
  async key({ key }) {
    if (key === "Escape") this.put(this.parameter);
    if (key === "Enter" && this.isTyped && !(await this.commit(this.number.value))) return;
    if (key === "Escape" || key === "Enter") this.number.blur();
  }

  /** What the slider stands for: a round number, within its ends. */
  get slid() {
    const step = this.step ?? 1;
    const value = Math.round(Number(this.slider.value) / step) * step;
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

  /** Set a value, once; whether it is so now.
   * @param {string} text */
  async commit(text) {
    if (text === this.committing) return false;
    const isNone = this.parameter.widget?.is_optional && /^(none)?$/.test(String(text).trim());
    const value = numberIn(text);
    if (!isNone && !Number.isFinite(value)) {
      this.fail("Expected a number.");
      return false;
    }
    const exact = isNone ? null : this.isWhole ? Math.round(value) : value / this.factor;
    this.committing = text;
    const isSo = await this.give(exact);
    this.committing = null;
    this.isTyped = !isSo;
    return isSo;
  }
}
