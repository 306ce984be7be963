// A form of the fields that the server describes (`FieldForm`, `ParameterForm`), which reports changes by path.
// Nothing here knows the Simulator: the Editor makes its forms of the same fields.

import { h } from "./dom.js";
import { chainRows, targetRows } from "./chains.js";
import { marksInWords } from "./field.js";
import { makeField } from "./fields.js";
import { manualButton } from "./manual.js";

export { shown } from "./field.js";

/** @type {Record<string, string>} */
const KINDS = {
  systematic: "Systematic errors",
  noise: "Noise",
  nominal: "What the robot holds of itself",
  controller: "Controller",
  estimator: "Estimator",
};

/**
 * @typedef {{chains?: import("../simulator/messages.d.ts").ChainForm[], targets?: import("../simulator/messages.d.ts").TargetForm[],
 *   components?: Record<string, [string, string]>}} Parts chains and targets, and the kind and name of what a group is of, by the group
 */

/** @type {Parts} */
const NOTHING = {};

export class Form {
  /**
   * @param {import("./field.js").FormOn} on
   */
  constructor(on) {
    this.on = on;
    this.fields = new Map();
    this.element = h("div", { class: "form" });
    this.signature = "";
  }

  /**
   * Show these fields; where they are the same ones as before only their values change.
   * @param {import("./field.js").Parameter[]} parameters
   */
  show(parameters, parts = NOTHING) {
    const { chains = [], targets = [], components = {} } = parts;
    const fields = parameters.map((p) => `${p.path} ${p.widget?.kind} ${Boolean(p.slider?.length)}`);
    const elements = chains.map((chain) => `${chain.path}: ${chain.elements.map((one) => `${one.name} ${one.is_added}`)} ${chain.gone}`);
    const signature = [...fields, ...elements, ...targets.map((one) => one.path)].join("\n");
    if (signature !== this.signature) {
      this.signature = signature;
      this.build(parameters, chains, targets, components);
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

  /** @param {import("./field.js").Parameter[]} parameters
   * @param {import("../simulator/messages.d.ts").ChainForm[]} chains
   * @param {import("../simulator/messages.d.ts").TargetForm[]} targets
   * @param {Record<string, [string, string]>} components */
  build(parameters, chains, targets, components) {
    const { opened } = this;
    this.fields.clear();
    const order = Object.keys(KINDS);
    const kinds = new Set(parameters.map((p) => p.kind ?? ""));
    if (chains.length) kinds.add("noise");
    const sections = [...kinds].sort((a, b) => order.indexOf(a) - order.indexOf(b)).map((kind) => {
      const mine = parameters.filter((p) => p.kind === kind);
      const isChains = kind === "noise" && chains.length > 0;
      const groups = isChains ? chains.map((chain) => chain.group) : [...new Set(mine.map((p) => p.group))];
      const parts = groups.map((group, n) => {
        const rows = isChains ? chainRows(chains[n], (path) => this.rows(mine.filter((p) => p.part === path || p.part?.startsWith(`${path}.`))), this.on) : this.rows(mine.filter((p) => p.group === group));
        if (group === undefined) return h("div", { class: "group" }, rows);
        const key = `${kind} ${group}`;
        const isOpen = opened.get(key) ?? (kind === "systematic" ? group === "drive" : kind === "noise" && groups.length < 2);
        return h("details", { class: "group", open: isOpen, "data-group": key }, h("summary", {}, groupTitle(group)), isChains ? null : this.about(components[group]), rows);
      });
      const added = kind === "systematic" ? targetRows(targets, this.on.set) : [];
      return h("section", {}, KINDS[kind] ? h("h3", {}, KINDS[kind]) : null, parts, added);
    });
    this.element.replaceChildren(marksInWords(), ...sections);
  }

  /** What a group of fields is of, with its manual.
   * @param {[string, string] | undefined} component */
  about(component) {
    if (!component) return null;
    const [kind, name] = component;
    return h("p", { class: "about" }, manualButton(this.on.ask, kind, name, `? ${name}`));
  }

  /** @param {import("./field.js").Parameter[]} parameters */
  rows(parameters) {
    return parameters.map((parameter) => {
      const field = makeField(parameter, this.on);
      this.fields.set(parameter.path, field);
      return field.element;
    });
  }
}

const groupTitle = (/** @type {string} */ group) => group.replace(/^sensors\./, "").replaceAll("_", " ").replaceAll(".", " · ");
