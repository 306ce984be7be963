// A form of the fields that the server describes (`FieldForm`, `ParameterForm`), which reports changes by path.
// Nothing here knows the Simulator: the Editor makes its forms of the same fields.

import { h } from "./dom.js";
import { marksInWords } from "./field.js";
import { makeField } from "./fields.js";

export { shown } from "./field.js";

const KINDS = {
  systematic: "Systematic errors",
  noise: "Noise",
  nominal: "What the robot holds of itself",
  controller: "Controller",
  estimator: "Estimator",
};

export class Form {
  /**
   * @param on `{set(path, value): promise of {ok, error}, restore(path): the same}`; values in the form's units
   */
  constructor(on) {
    this.on = on;
    this.fields = new Map();
    this.element = h("div", { class: "form" });
    this.signature = "";
  }

  /** Show these fields; where they are the same ones as before only their values change. */
  show(parameters) {
    const signature = parameters.map((p) => `${p.path} ${p.widget?.kind} ${Boolean(p.slider?.length)}`).join("\n");
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

  /** Which groups are open, to be so again. */
  get opened() {
    const groups = /** @type {NodeListOf<HTMLDetailsElement>} */ (this.element.querySelectorAll("details.group"));
    return new Map([...groups].map((group) => [group.dataset.group, group.open]));
  }

  build(parameters) {
    const { opened } = this;
    this.fields.clear();
    const sections = [];
    const kinds = [...new Set(parameters.map((p) => p.kind))].sort((a, b) => Object.keys(KINDS).indexOf(a) - Object.keys(KINDS).indexOf(b));
    for (const kind of kinds) {
      const mine = parameters.filter((p) => p.kind === kind);
      const groups = [...new Set(mine.map((p) => p.group))];
      const parts = groups.map((group) => {
        const rows = this.rows(mine.filter((p) => p.group === group), kind);
        if (group === undefined) return h("div", { class: "group" }, rows);
        const key = `${kind} ${group}`;
        const isOpen = opened.get(key) ?? (kind === "systematic" ? group === "drive" : kind === "noise" && groups.length < 2);
        return h("details", { class: "group", open: isOpen, "data-group": key }, h("summary", {}, groupTitle(group)), rows);
      });
      sections.push(h("section", {}, KINDS[kind] ? h("h3", {}, KINDS[kind]) : null, parts));
    }
    this.element.replaceChildren(marksInWords(), ...sections);
  }

  rows(parameters, _kind) {
    return parameters.map((parameter) => {
      const field = makeField(parameter, this.on);
      this.fields.set(parameter.path, field);
      return field.element;
    });
  }
}

const groupTitle = (group) => group.replace(/^sensors\./, "").replaceAll("_", " ").replaceAll(".", " · ");
