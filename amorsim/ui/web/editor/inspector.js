// The inspector: what the selected thing says, as forms where its fields are known, and else as TOML.

import { h, say, there } from "../shared/dom.js";
import { makeField } from "../shared/fields.js";
import { manualButton } from "../shared/manual.js";
import { shapeOf } from "../shared/nested_fields.js";
import { wordsOf } from "./geometry.js";
import { holdSensor } from "./mounting.js";
import { drawing, more, reordering } from "./more.js";
import { reshaping } from "./reshape.js";

/**
 * A table of a thing, as `Section` in amorsim/ui/editor/inspectors/inspector.py.
 * @typedef {{title: string, path: string, depth: number, use: {kind: string, value: string, choices: string[], is_optional: boolean, op?: string} | null,
 *   fields: any[], toml: string | null, can_go: boolean, origin: string,
 *   adding: {label: string, path: string, kind: string, choices: string[], is_list: boolean, value?: any}[]}} Section
 */

const FIRST = ["Controller", "Motion"]; // sections that are open from the beginning
// Kinds of component that have a manual.
const MANUALS = ["controller", "drive", "estimator", "map_loader", "motion", "noise", "planner", "sensor", "task", "world_generator"];
const NONE = "nothing is selected: click a thing on the canvas or in the list";
const BEGIN = "nothing is here yet: press R and click two corners for four walls; then choose a robot in “add …”, and click where it is to stand";
const LEAVE_OUT = "remove it here: the model's value or the default holds";

export class Inspector {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    this.page = page;
    this.title = h("h2", { id: "inspector-title" }, "Nothing selected");
    this.element = h("div", { class: "scroll form", tabindex: "0", role: "group", "aria-labelledby": "inspector-title" });
    this.signature = "";
    this.path = "";
    /** @type {Map<string, any>} */
    this.fields = new Map();
    /** @type {Map<string, boolean>} */
    this.opened = new Map();
    this.asked = 0;
    /** What is shown. @type {Section[]} */
    this.sections = [];
    page.stage.selection.listen(() => this.refresh());
  }

  /** Show what is selected, as it is now. */
  async refresh() {
    const asked = ++this.asked;
    const { selection } = this.page.stage;
    const one = /** @type {import("./stage.js").Chosen | null} */ (selection.only);
    if (!one) {
      const count = selection.things.length;
      const { things, walls } = this.page.stage;
      const words = walls.walls.length || things.some(({ kind }) => kind !== "settings") ? NONE : BEGIN;
      this.empty(count ? `${count} things selected` : "Nothing selected", count ? "drag moves them all; Delete deletes them" : words, reshaping(this.page));
      return;
    }
    if (one.wall !== undefined) {
      this.wall(one.wall);
      return;
    }
    if (one.path !== this.path) this.empty(one.title, "reading …");
    const said = await this.page.connection.ask({ do: "inspect", path: one.path });
    if (asked !== this.asked) return;
    if (!said.ok) {
      this.empty(one.title, said.error);
      return;
    }
    say(this.title, one.title);
    this.show(there(one.path), said.sections);
  }

  /** @param {string} title
   * @param {string} words
   * @param {HTMLElement[]} more */
  empty(title, words, more = []) {
    say(this.title, title);
    this.signature = this.path = "";
    this.fields.clear();
    this.element.replaceChildren(h("p", { class: "empty" }, words), ...more);
  }

  /** The ends of a wall. @param {number} n */
  wall(n) {
    const { page } = this;
    const wall = page.stage.walls.walls[n];
    say(this.title, `wall ${n + 1}`);
    this.signature = this.path = "";
    this.fields.clear();
    const set = async (/** @type {string} */ path, /** @type {any} */ value) => {
      const other = [...wall];
      other[Number(path)] = value;
      return await page.edit("move a wall", [{ op: "walls", change: [[n, other]] }]);
    };
    const fields = ["x of one end", "y of one end", "x of the other", "y of the other"].map((label, k) =>
      makeField({ path: String(k), label, help: "", value: wall[k], is_given: false, fixed: page.wallsFixed || page.watching,
        widget: /** @type {any} */ ({ kind: "number", is_optional: false, unit: "m", low: null, high: null, is_open: [false, false], is_whole: false }) }, { set, restore: (path) => set(path, wall[Number(path)]) }).element);
    this.element.replaceChildren(
      h("p", { class: "note" }, `${wordsOf(wall)}; walls are kept in ${page.state?.map || "the map's file"}`),
      ...fields,
      ...reshaping(page),
    );
  }

  /** @param {string} path
   * @param {Section[]} sections */
  show(path, sections) {
    this.sections = sections;
    const signature = JSON.stringify([path, this.page.watching, sections.map((one) => [one.path, one.use, one.toml === null, one.origin, shapeOf(one.fields)])]);
    if (signature !== this.signature) {
      this.signature = signature;
      this.path = path;
      this.build(sections);
    }
    for (const section of sections) {
      for (const field of section.fields) this.fields.get(field.path)?.update(this.fixed(field));
      const area = /** @type {HTMLTextAreaElement | null} */ (this.element.querySelector(`textarea[data-path="${CSS.escape(section.path)}"]`));
      if (area && document.activeElement !== area) area.value = section.toml ?? "";
    }
    this.tellFaults(sections);
  }

  /** A field as it is shown: of a body that the file puts nowhere, with the place that its map gives it.
   * @param {any} field */
  fixed(field) {
    const place = this.placeOf(field.path);
    const value = place && !field.is_given ? place.pose[place.part] * (place.part === 2 ? 180 / Math.PI : 1) : field.value;
    return { ...field, value, ...(this.page.watching ? { fixed: "another window holds the pen" } : {}) };
  }

  /** Which part of which pose a path is, or null. @param {string} path */
  placeOf(path) {
    const [, holder, key] = path.match(/^(\w+\.\d+)\.pose\.(x|y|heading_deg)$/) ?? [];
    const thing = this.page.stage.things.find((one) => one.path === holder);
    return thing?.pose ? { path: holder, pose: thing.pose, part: ["x", "y", "heading_deg"].indexOf(key) } : null;
  }

  /** Say a value, as a step.
   * @param {string} path
   * @param {any} value */
  set(path, value) {
    const [part, key] = path.split(".").slice(-2);
    const words = key === "use" ? `choose ${value} as ${part}` : value === null ? `no ${key}` : `change ${key.replace(/_deg$/, "").replaceAll("_", " ")}`;
    const place = this.placeOf(path);
    if (!place) return this.page.edit(words, [{ op: "set", path, value }]);
    const [x, y, heading] = place.pose;
    const pose = [x, y, (heading * 180) / Math.PI].map((one) => Math.round(one * 1e6) / 1e6);
    return this.page.edit(words, [{ op: "pose", path: place.path, value: pose.map((one, n) => (n === place.part ? value : one)) }]);
  }

  /** @param {any[]} sections */
  build(sections) {
    this.fields.clear();
    this.element.replaceChildren(
      h("p", { class: "legend-of-marks" }, h("span", {}, h("span", { class: "mark" }, "●"), "its own"), h("span", {}, h("span", { class: "mark" }, "↳"), "from its model")),
      ...sections.map((section, n) => this.section(section, n)),
    );
  }

  /** @param {Section} section
   * @param {number} n */
  section(section, n) {
    const { page } = this;
    const on = {
      set: (/** @type {string} */ path, /** @type {any} */ value) => this.set(path, value),
      restore: (/** @type {string} */ path) => page.edit(`leave out ${path.split(".").at(-1)}`, [{ op: "remove", path }]),
    };
    const parts = [];
    if (section.origin) parts.push(h("p", { class: "note" }, section.origin));
    if (section.use) parts.push(this.use(section));
    for (const parameter of section.fields) {
      const field = makeField(this.fixed(parameter), on);
      this.know(field);
      parts.push(field.element);
      if (parameter.widget?.kind === "table" && parameter.widget.frame === "world" && !page.watching) parts.push(drawing(page, parameter));
    }
    if (section.toml !== null) parts.push(this.toml(section));
    for (const adding of section.adding) parts.push(this.adding(adding));
    parts.push(...more(page, section));
    parts.push(h("p", { class: "fault-text", role: "alert", "data-faults": section.path }));
    if (section.can_go && !page.watching) {
      const drop = () => page.edit(`remove ${section.title}`, [{ op: "remove", path: section.path }]);
      parts.push(h("div", { class: "row" }, h("button", { class: "tool", onclick: drop }, `remove ${section.title}`), reordering(page, section, this.sections)));
    }
    const isOpen = this.opened.get(section.path + section.title) ?? (n < 2 || FIRST.includes(section.title));
    const depth = ["", " deep", " deeper"][section.depth] ?? " deeper";
    const details = h(
      "details",
      { class: `section${depth}`, open: isOpen, "data-section": section.path },
      h("summary", {}, h("span", { class: "title" }, section.title), h("span", { class: "use" }, section.use?.value ?? "")),
      parts,
    );
    const sensor = section.path.match(/^robots\.\d+\.sensors\.([^.]+)$/)?.[1];
    details.addEventListener("toggle", () => {
      this.opened.set(section.path + section.title, details.open);
      if (sensor && details.open) holdSensor(page, sensor);
    });
    return details;
  }

  /** Keep a field by its path, and those within it. @param {any} field */
  know(field) {
    this.fields.set(field.path, field);
    field.back.title = LEAVE_OUT;
    field.back.setAttribute("aria-label", `${field.parameter.label}: ${LEAVE_OUT}`);
    for (const inner of field.fields ?? []) this.know(inner);
  }

  /** Which component or shape it is.
   * @param {any} section */
  use({ use, path, title }) {
    const { page } = this;
    const id = `use-${path}`;
    const all = [...new Set([...(use.is_optional || !use.value ? [""] : []), ...use.choices, use.value])];
    const select = h("select", { id, disabled: page.watching }, all.map((name) => h("option", { value: name }, name || "none")));
    select.value = use.value;
    select.addEventListener("change", async () => {
      const { value } = select;
      const what = title.toLowerCase();
      if (use.kind === "world_generator") await page.edit(`choose the generator ${value}`, [{ op: "set", path, value: { generate: value, seed: 1 } }]);
      else if (use.op) await page.edit(`${what}: ${value || "none"}`, [{ op: use.op, path, value }]);
      else if (use.kind === "shape") await page.edit(`choose a ${value}`, [{ op: "shape", path, value }]);
      else if (!value) await page.edit(`no ${what}`, [{ op: "remove", path }]);
      else await page.edit(`choose ${value} as ${what}`, [{ op: "set", path: `${path}.use`, value }]);
      select.value = use.value;
    });
    const about = MANUALS.includes(use.kind) && use.value && !use.value.includes(":") ? [manualButton((command) => page.connection.ask(command), use.kind, use.value)] : [];
    return h("div", { class: "row" }, h("label", { for: id }, "kind"), select, ...about);
  }

  /** A table's text. @param {Section} section */
  toml({ toml, path, title }) {
    const { page } = this;
    const area = h("textarea", { "aria-label": `${title} as TOML`, "data-path": path, spellcheck: "false", rows: String(Math.min(14, Math.max(3, (toml ?? "").split("\n").length))) });
    area.value = toml ?? "";
    area.readOnly = page.watching;
    const problem = h("p", { class: "error", role: "alert" });
    const set = async () => {
      const said = await page.edit(`change ${title.toLowerCase()}`, [{ op: "toml", path, text: area.value }]);
      say(problem, said.ok ? "" : said.error);
    };
    area.addEventListener("keydown", (event) => {
      if (event.key === "Enter" && event.ctrlKey) set();
    });
    const buttons = page.watching ? null : h("div", { class: "line" }, h("button", { class: "tool", title: "Ctrl + Enter", onclick: set }, "set"));
    return h("div", { class: "toml" }, area, problem, buttons);
  }

  /** A component more.
   * @param {Section["adding"][0]} what */
  adding({ label, path, kind, choices, is_list: isList, value }) {
    const { page } = this;
    if (page.watching) return "";
    if (value) return h("div", { class: "row" }, h("button", { class: "tool", onclick: () => page.edit(label, [{ op: "add", path, value }]) }, label));
    const id = `add-${path}`;
    const select = h("select", { id }, choices.map((name) => h("option", { value: name }, name)));
    const add = () => {
      const use = select.value;
      if (isList) return page.edit(`add ${use}`, [{ op: "add", path, value: { use } }]);
      if (kind === "error") return page.edit(`add an error of ${use}`, [{ op: "set", path: `${path}.${use}`, value: { scale: 1 } }]);
      const taken = [...this.element.querySelectorAll("[data-section]")].map((one) => /** @type {HTMLElement} */ (one).dataset.section);
      let [name, number] = [use, 1];
      while (taken.includes(`${path}.${name}`)) name = `${use}${++number}`;
      this.opened.set(`${path}.${name}${name}`, true);
      return page.edit(`add ${kind} ${name}`, [{ op: "set", path: `${path}.${name}`, value: { use } }]);
    };
    return h("div", { class: "row" }, h("label", { for: id }, label), select, h("button", { class: "tool", "aria-label": label, onclick: add }, "add"));
  }

  /** Put the faults where they belong: at a field, or else at the section that holds it.
   * @param {any[]} sections */
  tellFaults(sections) {
    const { faults } = this.page;
    const rest = new Map(sections.map(({ path }) => [path, /** @type {string[]} */ ([])]));
    for (const fault of faults.filter(({ at }) => at === this.path || at.startsWith(`${this.path}.`))) {
      const field = this.fields.get(fault.at);
      if (field) field.fail(fault.message);
      const holder = sections.map(({ path }) => path).filter((path) => fault.at === path || fault.at.startsWith(`${path}.`)).sort((a, b) => b.length - a.length)[0];
      if (!field && holder !== undefined) rest.get(holder)?.push(`${fault.at.slice(holder.length + 1)} ${fault.message}`.trim());
      const place = holder !== undefined && this.element.querySelector(`[data-section="${CSS.escape(holder)}"]`);
      if (place) /** @type {HTMLDetailsElement} */ (place).open = true;
    }
    for (const [path, words] of rest) {
      const place = this.element.querySelector(`[data-faults="${CSS.escape(path)}"]`);
      if (place) say(place, words.join("\n"));
      this.element.querySelector(`[data-section="${CSS.escape(path)}"]`)?.classList.toggle("faulty", words.length > 0);
    }
  }
}
