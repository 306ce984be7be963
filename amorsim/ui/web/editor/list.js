// The list of objects, a line for each with its faults, and the list of all faults.

import { h, say } from "../shared/dom.js";
import { manualButton } from "../shared/manual.js";
import { drawing } from "./drawing.js";

/** @type {Record<string, string>} */
const KINDS = { settings: "Scenario", robot: "Robots", obstacle: "Obstacles", zone: "Zones", landmark: "Landmarks", light: "Lights", wall: "Walls" };
const MOST = 300; // lines of a kind
const EYE = "M2 10q8-9 16 0q-8 9-16 0z M12.5 10a2.5 2.5 0 1 1-5 0a2.5 2.5 0 1 1 5 0z";
const STRUCK = "M4 17L16 3";
const PADLOCK = "M4.5 9h11v8h-11z M7 9V6a3 3 0 0 1 6 0v3";

export class ObjectList {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    this.page = page;
    this.element = h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "objects" });
    /** @type {Map<string, HTMLButtonElement>} */
    this.lines = new Map();
    page.stage.selection.listen(() => this.mark());
  }

  /** @param {import("./stage.js").Thing[]} things
   * @param {number[][]} walls */
  show(things, walls) {
    const { stage } = this.page;
    this.lines.clear();
    const parts = [];
    for (const [kind, title] of Object.entries(KINDS)) {
      if (kind === "wall") {
        if (!walls.length) continue;
        const lines = walls.slice(0, MOST).map(([a, b, c, d], n) =>
          this.line(`wall ${n}`, `wall ${n + 1}`, `${Math.hypot(c - a, d - b).toFixed(2)} m`, 0, () => stage.chosenWall(n)));
        const more = walls.length > MOST ? h("li", { class: "kind" }, `and ${walls.length - MOST} more`) : null;
        const isOpen = this.element.querySelector("details.walls[open]") !== null;
        const fold = h("details", { class: "walls", open: isOpen }, h("summary", {}, `${title} (${walls.length})`), h("ul", { class: "things" }, lines, more));
        parts.push(this.head(kind, fold));
        continue;
      }
      const mine = things.filter((thing) => thing.kind === kind);
      if (!mine.length) continue;
      const lines = mine.slice(0, MOST).map((thing) => this.line(thing.path, thing.name, thing.note, thing.faults, () => stage.chosenOf(thing)));
      if (mine.length > MOST) lines.push(h("li", { class: "kind" }, `and ${mine.length - MOST} more`));
      parts.push(this.head(kind, h("span", {}, title)), h("ul", { class: "things" }, lines));
    }
    this.element.replaceChildren(...parts);
    this.mark();
  }

  /** The title of a kind, and the buttons that hide and lock it.
   * @param {string} kind
   * @param {HTMLElement} title */
  head(kind, title) {
    const { stage } = this.page;
    if (kind === "settings") return h("div", { class: "layer" }, title);
    const button = (/** @type {Set<string>} */ set, /** @type {string} */ label, /** @type {string} */ sign, struck = "") => {
      const show = () => one.replaceChildren(drawing(set.has(kind) ? `${sign} ${struck}` : sign));
      const one = h("button", { class: "tool", "aria-pressed": String(set.has(kind)), "aria-label": `${label} ${KINDS[kind].toLowerCase()}`, title: label });
      show();
      one.addEventListener("click", () => {
        set.has(kind) ? set.delete(kind) : set.add(kind);
        one.setAttribute("aria-pressed", String(set.has(kind)));
        show();
        stage.selection.set(stage.selection.things.filter((chosen) => stage.isFree(chosen.kind)));
        stage.hide();
      });
      return one;
    };
    return h("div", { class: "layer" }, title, h("div", { class: "both" }, button(stage.hidden, "hide", EYE, STRUCK), button(stage.locked, "lock", PADLOCK)));
  }

  /** @param {string} key
   * @param {string} name
   * @param {string} note
   * @param {number} faults
   * @param {() => import("./stage.js").Chosen} chosen */
  line(key, name, note, faults, chosen) {
    const { selection } = this.page.stage;
    const button = h(
      "button",
      { class: "thing", "aria-pressed": "false", "data-key": key, onclick: (/** @type {PointerEvent} */ event) => {
        const one = chosen();
        selection.set(event.shiftKey || event.ctrlKey ? [...selection.things.filter(({ key: other }) => other !== one.key), one] : [one]);
      } },
      h("span", { class: "name" }, name),
      faults ? h("span", { class: "faulty" }, faults === 1 ? "1 fault" : `${faults} faults`) : null,
      h("span", { class: "note" }, note),
    );
    this.lines.set(key, button);
    return h("li", {}, button);
  }

  mark() {
    const chosen = new Set(this.page.stage.selection.things.map(({ key }) => key));
    for (const [key, line] of this.lines) line.setAttribute("aria-pressed", String(chosen.has(key)));
    if (chosen.size === 1) this.lines.get(String([...chosen][0]))?.scrollIntoView({ block: "nearest" });
  }
}

/** @type {Record<string, string>} */
const LACKS = { world: "walls", robots: "a robot" };

/** The faults, and what a new scenario only has not yet, in words.
 * @param {any[]} faults
 * @param {boolean} isNew
 * @returns {[any[], string[]]} */
export function faultsAndLacks(faults, isNew) {
  const isLack = (/** @type {any} */ { at, message }) => isNew && at in LACKS && message.startsWith("missing");
  return [faults.filter((one) => !isLack(one)), faults.filter(isLack).map(({ at }) => LACKS[at])];
}

/** The faults, each a button that leads to what it is about, and beside it the manual of the component that it is in.
 * @param {(import("../simulator/messages.d.ts").FaultLine & {at: string, component: [string, string] | null})[]} faults
 * @param {(at: string) => void} go
 * @param {import("../shared/manual.js").Ask} ask */
export function faultButtons(faults, go, ask) {
  return h(
    "ol",
    { class: "faults-list" },
    faults.map((fault) =>
      h(
        "li",
        {},
        h(
          "button",
          { class: "fault", onclick: () => go(fault.at) },
          h("div", { class: "where" }, [fault.path || fault.file, fault.line === null ? "" : `line ${fault.line}`].filter(Boolean).join(", ")),
          h("div", { class: "problem" }, fault.message),
        ),
        fault.component && manualButton(ask, ...fault.component),
      )),
  );
}

/** The numbers of walls, robots and so on, in words.
 * @param {HTMLElement} element
 * @param {import("./stage.js").Thing[]} things
 * @param {number[][]} walls */
export function counts(element, things, walls) {
  const words = Object.entries({ robot: "robots", obstacle: "obstacles", zone: "zones", landmark: "landmarks", light: "lights" }).flatMap(([kind, many]) => {
    const count = things.filter((thing) => thing.kind === kind).reduce((sum, thing) => sum + Math.max(1, thing.robots.length + thing.obstacles.length), 0);
    return count ? [`${count} ${count === 1 ? kind : many}`] : [];
  });
  say(element, [walls.length === 1 ? "1 wall" : `${walls.length} walls`, ...words].join(" · "));
}
