// Chains of noise in a form: their elements, which can be taken out, and drafts of elements that can be added.

import { h, say, there } from "./dom.js";
import { makeField } from "./fields.js";

/**
 * `value` with another value at a path of keys and numbers; another `use` is another component, and has nothing else yet.
 * @param {string[]} path
 * @param {any} value
 * @param {any} given
 */
function withValue(value, path, given) {
  const [key, ...rest] = path;
  if (key === "use") return { use: given };
  const copy = Array.isArray(value) ? [...value] : { ...value };
  copy[key] = rest.length ? withValue(copy[key], rest, given) : given;
  return copy;
}

/**
 * `table` without what is at a path.
 * @param {Record<string, any>} table
 * @param {string[]} path
 * @returns {Record<string, any>}
 */
function without(table, path) {
  const [key, ...rest] = path;
  const { [key]: inner, ...others } = table;
  if (!rest.length || inner === null || typeof inner !== "object") return others;
  return { ...others, [key]: without(inner, rest) };
}

/** A component that is not yet there: which it is, and the form of its fields. Nothing is set before it is added. */
class Draft {
  /** @param {string} label
   * @param {any[]} choices
   * @param {{add: (table: object) => Promise<any>, choices: (table: object) => Promise<any>, done: () => void}} on promises of
   *   {ok, error}, and of {ok, choices} */
  constructor(label, choices, on) {
    this.choices = choices;
    this.on = on;
    this.select = h("select", { "aria-label": `${label}: which`, onchange: () => this.turn() }, choices.map((one) => h("option", { value: one.name }, one.name)));
    this.about = h("p", { class: "note" });
    this.fields = h("div", { class: "inner" });
    this.error = h("p", { class: "error", role: "alert" });
    this.element = h(
      "div",
      { class: "draft" },
      h("div", { class: "line" }, this.select, h("button", { class: "tool main", onclick: () => this.add() }, "add"), h("button", { class: "tool", onclick: () => on.done() }, "cancel")),
      this.about,
      this.fields,
      this.error,
    );
    this.turn();
  }

  /** Another component: its form, of which nothing is said yet. */
  turn() {
    const choice = this.choices.find((one) => one.name === this.select.value) ?? this.choices[0];
    /** @type {Record<string, any>} */
    this.table = { use: choice.name };
    say(this.about, choice.help);
    say(this.error, "");
    const on = { set: (/** @type {string} */ path, /** @type {any} */ value) => this.set(path, value), restore: (/** @type {string} */ path) => this.drop(path) };
    this.made = new Map(choice.fields.map((/** @type {import("./field.js").Parameter} */ parameter) => [parameter.path, makeField(parameter, on)]));
    this.fields.replaceChildren(...[...this.made.values()].map((field) => field.element));
  }

  /** @param {string} path
   * @param {any} value */
  set(path, value) {
    const [key, ...rest] = path.split(".");
    const there = this.table && key in this.table ? this.table[key] : this.made?.get(key)?.parameter.value;
    return this.say({ ...this.table, [key]: rest.length ? withValue(there, rest, value) : value });
  }

  /** Leave out what is said at a path, or in the component that it leads into.
   * @param {string} path */
  drop(path) {
    const table = without(this.table ?? {}, path.split("."));
    return this.say(table);
  }

  /** Say another table, and show the form that it has: the fields follow the components that are chosen in it.
   * @param {Record<string, any>} table */
  async say(table) {
    this.table = table;
    const said = await this.on.choices(table);
    if (said.ok && this.table === table) {
      const { fields } = said.choices.find((/** @type {{name: string}} */ one) => one.name === table.use);
      for (const field of fields) this.made?.get(field.path)?.update(field);
    }
    return said;
  }

  async add() {
    const said = await this.on.add(there(this.table));
    say(this.error, said.ok ? "" : said.error);
    if (said.ok) this.on.done();
  }
}

/**
 * The rows of a chain: its elements with their fields, and a button that begins a draft.
 * @param {import("../simulator/messages.d.ts").ChainForm} chain
 * @param {(path: string) => HTMLElement[]} rows the elements of the fields of the element at a path
 * @param {import("./field.js").FormOn} on
 */
export function chainRows(chain, rows, on) {
  const name = chain.path.replace(/^sensors\.|\.noise$/g, "");
  const elements = chain.elements.map((element) => {
    const remove = h("button", { class: "back", title: "take it out of the chain", "aria-label": `${name}: remove ${element.name}` }, "×");
    const error = h("p", { class: "error", role: "alert" });
    remove.addEventListener("click", async () => {
      const said = await on.remove(element.path);
      if (!said.ok) say(error, said.error);
    });
    const use = element.use === element.name ? null : h("span", { class: "unit" }, element.use);
    const added = element.is_added ? h("span", { class: "mark", title: "the scenario does not have it" }, "+") : null;
    const head = h("div", { class: "element", "data-element": element.path }, added, h("span", { class: "name" }, element.name), use, remove);
    return [head, error, ...rows(element.path)];
  });
  const place = h("div", { class: "adding" });
  const gone = chain.gone.length ? h("p", { class: "note" }, `taken out: ${chain.gone.join(", ")}`) : null;
  const begin = h("button", { class: "tool", "aria-label": `${name}: add noise` }, "add noise …");
  const end = () => place.replaceChildren(begin, ...(gone ? [gone] : []));
  begin.addEventListener("click", async () => {
    const said = await on.noises(chain.path);
    if (!said.ok) return;
    const draft = new Draft(name, said.choices, { add: (/** @type {Record<string, any>} */ table) => on.add(chain.path, table), choices: (/** @type {Record<string, any>} */ table) => on.noises(chain.path, table), done: end });
    place.replaceChildren(draft.element);
    draft.select.focus();
  });
  end();
  return [...elements.flat(), place];
}

/** A list of numbers that may be given an error.
 * @param {import("../simulator/messages.d.ts").TargetForm[]} targets
 * @param {(path: string, value: any) => any} set */
export function targetRows(targets, set) {
  if (!targets.length) return [];
  const select = h("select", { "aria-label": "number that is to have an error" }, targets.map(({ path, label }) => h("option", { value: path }, label)));
  const add = h("button", { class: "tool", onclick: () => set(`errors.${select.value}`, { scale: 1, add: 0 }) }, "add an error");
  return [h("div", { class: "adding", "data-adds": "error" }, select, add)];
}
