// The list of a fleet: each robot with its state, found by a search or by a box drawn around robots in a pane.

import { colourChip, fixed, h, say } from "../shared/dom.js";
import { ROBOT } from "./protocol.js";

const MOST = 200; // robots that are listed at once
const ORDERS = [["", "in order"], ["apart", "largest error first"]];

export class Fleet {
  /** @param {(robot: number) => void} select */
  constructor(select) {
    this.select = select;
    this.search = h("input", { type: "text", "aria-label": "search the robots", placeholder: "name, model or state", oninput: () => this.build() });
    this.order = h("select", { "aria-label": "order of the robots", onchange: () => this.build() }, ORDERS.map(([value, label]) => h("option", { value }, label)));
    this.whole = h("button", { class: "tool", hidden: true, title: "list all robots again", onclick: () => this.only(null) }, "all");
    this.count = h("p", { class: "count", role: "status" });
    this.rows = h("ul", { class: "fleet-rows" });
    this.element = h(
      "section",
      { class: "fleet", "aria-label": "robots", hidden: true },
      h("div", { class: "fleet-head" }, this.search, this.order, this.whole),
      this.count,
      h("div", { class: "scroll", tabindex: "0", role: "group", "aria-label": "list of robots" }, this.rows),
    );
    /** @type {any} */
    this.scene = null;
    /** @type {any} */
    this.frame = null;
    /** @type {Set<number> | null} */
    this.chosen = null; // those in the box that was drawn
    /** @type {{robot: number, button: HTMLElement, state: HTMLElement}[]} */
    this.listed = [];
  }

  /** @param {import("../shared/scene.js").Scene} scene */
  setScene(scene) {
    this.scene = scene;
    this.chosen = null;
    this.search.value = "";
    this.build();
  }

  /** List some robots alone, or all.
   * @param {number[] | null} robots */
  only(robots) {
    this.chosen = robots && new Set(robots);
    this.whole.hidden = !robots;
    this.build();
  }

  toggle() {
    this.element.hidden = !this.element.hidden;
    if (!this.element.hidden) {
      this.build();
      this.search.focus();
    }
  }

  /** Take a frame; the list is brought up to date where it is seen.
   * @param {import("./messages.d.ts").Frame} frame */
  show(frame) {
    this.frame = frame;
    if (this.element.hidden || !this.scene) return;
    if (this.order.value || this.search.value) this.build(); // another state may be another place
    else this.tell();
  }

  /** @param {number} i */
  apart(i) {
    const { truePoses: truth, estimatedPoses: belief } = this.frame;
    return Math.hypot(truth[3 * i] - belief[3 * i], truth[3 * i + 1] - belief[3 * i + 1]);
  }

  /** @param {number} i */
  stateOf(i) {
    const flags = this.frame.flags[i];
    const words = [];
    if (flags & ROBOT.touching) words.push("in contact");
    if (flags & ROBOT.byHand) words.push("by hand");
    if (flags & ROBOT.ended) words.push("ended");
    return words.join(", ");
  }

  build() {
    if (this.element.hidden || !this.scene || !this.frame) return;
    const wanted = this.search.value.trim().toLowerCase();
    const matches = (/** @type {import("../shared/scene.js").Robot} */ robot, /** @type {number} */ i) =>
      (!this.chosen || this.chosen.has(i)) && (!wanted || `${robot.name} ${robot.model ?? ""} ${this.stateOf(i)}`.toLowerCase().includes(wanted));
    const found = this.scene.robots.map((/** @type {import("../shared/scene.js").Robot} */ robot, /** @type {number} */ i) => (matches(robot, i) ? i : -1)).filter((/** @type {number} */ i) => i >= 0);
    if (this.order.value) found.sort((/** @type {number} */ one, /** @type {number} */ other) => (this.apart(other) || 0) - (this.apart(one) || 0));
    const shown = found.slice(0, MOST);
    const total = this.scene.robots.length;
    say(this.count, `${found.length === total ? total : `${found.length} of ${total}`} robots${found.length > MOST ? `, the first ${MOST} are listed` : ""}`);
    if (shown.length !== this.listed.length || shown.some((/** @type {number} */ robot, /** @type {number} */ n) => this.listed[n].robot !== robot)) {
      this.listed = shown.map((/** @type {number} */ robot) => this.row(robot));
      this.rows.replaceChildren(...this.listed.map(({ button }) => h("li", {}, button)));
    }
    this.tell();
  }

  /** @param {number} i */
  row(i) {
    const robot = this.scene.robots[i];
    const state = h("span", { class: "state" });
    const button = h("button", { class: "fleet-row", onclick: () => this.select(i) }, h("span", { class: "name" }, robot.colour ? colourChip(robot.colour) : null, robot.name), state);
    return { robot: i, button, state };
  }

  tell() {
    for (const { robot, button, state } of this.listed) {
      const error = this.apart(robot);
      const words = [this.stateOf(robot), Number.isFinite(error) ? `${fixed(error, 2)} m off` : ""];
      say(state, words.filter(Boolean).join(" · "));
      button.setAttribute("aria-pressed", String(robot === this.frame.selected));
    }
  }
}
