// How the panels are arranged: which stands in which slot, how large the slots are, and which panel is shown alone.

import { h, there } from "../shared/dom.js";
import { keep, kept } from "../shared/storage.js";

const PANEL = "application/x-amorsim-panel";
const KEY = "amorsim-arrangement:";
const STEP = 24; // pixels that an arrow key moves a divider
/** Pixels that a key moves a divider. @type {Record<string, number>} */
const STEPS = { ArrowLeft: -STEP, ArrowUp: -STEP, ArrowRight: STEP, ArrowDown: STEP };
const LEAST = 40; // pixels of a slot that is not folded
/** @type {Record<string, string>} */
const NAMES = { first: "between the panes", second: "between numbers and plots", third: "between plots and events", row: "under the panes", column: "beside the panes" };

/** @typedef {{shares: Record<string, number>, sizes: Record<string, number>, places: Record<string, string>}} Kept */

/** The name of the slot that a panel is in.
 * @param {HTMLElement} panel */
const slotOf = (panel) => there(panel.parentElement).dataset.slot ?? "";

export class Arrangement {
  /** @param {Record<string, HTMLElement[]>} panels those of each slot: two panes, three below, one beside
   * @param {() => void} changed another arrangement than the first, or the first again */
  constructor(panels, changed) {
    this.changed = changed;
    /** @type {Record<string, HTMLElement>} */
    this.slots = {};
    this.first = panels;
    for (const [name, inside] of Object.entries(panels)) this.slots[name] = this.slot(name, inside);
    const { slots } = this;
    this.top = h("div", { class: "top" }, slots.left, this.divider("first", slots.left, () => slots.right), slots.right);
    this.bottom = h(
      "div",
      { class: "bottom" },
      slots.low,
      this.divider("second", slots.low, () => slots.middle),
      slots.middle,
      this.divider("third", slots.middle, () => slots.last),
      slots.last,
    );
    this.element = h("div", { class: "panels" }, this.top, this.edge("row", "bottom"), this.bottom, this.edge("column", "side"), slots.side);
    this.key = "";
    this.kept = this.atFirst();
  }

  /** @param {string} name
   * @param {HTMLElement[]} inside */
  slot(name, inside) {
    const slot = h("div", { class: "slot", "data-slot": name }, inside);
    slot.addEventListener("dragover", (event) => there(event.dataTransfer).types.includes(PANEL) && event.preventDefault());
    slot.addEventListener("drop", (event) => {
      const from = there(event.dataTransfer).getData(PANEL);
      if (!from) return;
      event.preventDefault();
      this.swap(from, name);
    });
    for (const panel of inside) this.giveTitle(panel);
    return slot;
  }

  /** A panel is dragged by its title, or by the button next to it, which shows the panel alone.
   * @param {HTMLElement} panel */
  giveTitle(panel) {
    const title = /** @type {HTMLElement} */ (panel.querySelector(`#${panel.getAttribute("aria-labelledby")}`));
    const name = panel.classList[1];
    const button = h("button", { class: "tool alone", "aria-label": `${name} alone`, title: "this panel alone (or a double click on its title); drag it onto another panel: the two change places", "aria-pressed": "false" }, "⤢");
    button.addEventListener("click", () => this.showAlone(panel, button));
    title.addEventListener("dblclick", () => this.showAlone(panel, button));
    title.title = "drag it onto another panel: the two change places";
    for (const handle of [title, button]) {
      handle.draggable = true;
      handle.addEventListener("dragstart", (event) => there(event.dataTransfer).setData(PANEL, slotOf(panel)));
    }
    title.after(button);
  }

  /** @param {HTMLElement} panel
   * @param {HTMLElement} button */
  showAlone(panel, button) {
    const slot = there(panel.parentElement);
    const isAlone = !slot.classList.contains("solo");
    this.showAll();
    slot.classList.toggle("solo", isAlone);
    button.setAttribute("aria-pressed", String(isAlone));
  }

  showAll() {
    for (const other of this.element.querySelectorAll(".slot.solo")) other.classList.remove("solo");
    for (const other of this.element.querySelectorAll("button.alone")) other.setAttribute("aria-pressed", "false");
  }

  /** Let the panels of two slots change places.
   * @param {string} one
   * @param {string} other */
  swap(one, other) {
    if (one === other) return;
    const [here, there] = [[...this.slots[one].children], [...this.slots[other].children]];
    this.slots[one].replaceChildren(...there);
    this.slots[other].replaceChildren(...here);
    [this.kept.places[one], this.kept.places[other]] = [this.kept.places[other], this.kept.places[one]];
    this.keep();
  }

  // ---------------------------------------------------------------------------------------------------------- dividers

  /** A line between two neighbours of a row, which moves the border between them.
   * @param {string} name
   * @param {HTMLElement} before
   * @param {() => HTMLElement} after */
  divider(name, before, after) {
    const widths = () => [before.clientWidth, after().clientWidth];
    const divider = this.line(name, "vertical", {
      begin: widths,
      move: (/** @type {number[]} */ [one, other], /** @type {number} */ by) => {
        const moved = Math.min(Math.max(one + by, 0), one + other);
        const [a, b] = [moved, one + other - moved].map((width) => (width < LEAST ? 0 : width));
        this.share(before, a || one + other - b);
        this.share(after(), b || one + other - a);
        if (a === 0) this.share(before, 0);
        if (b === 0) this.share(after(), 0);
      },
      value: () => Math.round((100 * before.clientWidth) / Math.max(before.clientWidth + after().clientWidth, 1)),
      reset: () => [before, after()].forEach((slot) => this.share(slot, null)),
    });
    return divider;
  }

  /** How much of its row a slot gets, beside the others; null for what it had at first.
   * @param {HTMLElement} slot
   * @param {number | null} pixels */
  share(slot, pixels) {
    const { shares } = this.kept;
    const row = /** @type {NodeListOf<HTMLElement>} */ (there(slot.parentElement).querySelectorAll(":scope > .slot"));
    const names = Array.from(row, (other) => other.dataset.slot ?? "");
    if (pixels === null) {
      for (const name of names) delete shares[name];
    } else {
      // The others of its row must be in pixels as well.
      row.forEach((other, n) => shares[names[n]] ??= other.clientWidth);
      shares[slot.dataset.slot ?? ""] = Math.round(pixels);
    }
    this.apply();
  }

  /** A line beside the panes or under them, which gives what lies beyond it another size.
   * @param {string} name
   * @param {string} beyond
   * @returns {HTMLElement} */
  edge(name, beyond) {
    const isRow = name === "row";
    const target = () => (isRow ? this.bottom : this.slots.side);
    const size = () => (isRow ? target().clientHeight : target().clientWidth);
    const whole = () => (isRow ? this.element.clientHeight : this.element.clientWidth);
    return this.line(name, isRow ? "horizontal" : "vertical", {
      begin: size,
      move: (/** @type {number} */ began, /** @type {number} */ by) => {
        const wanted = Math.min(Math.max(began - by, 0), whole() - 120);
        this.kept.sizes[beyond] = wanted < LEAST ? 0 : Math.round(wanted);
        this.apply();
      },
      value: () => Math.round((100 * size()) / Math.max(whole(), 1)),
      reset: () => {
        delete this.kept.sizes[beyond];
        this.apply();
      },
    });
  }

  /** @param {string} name
   * @param {string} orientation
   * @param {{begin: () => any, move: (began: any, by: number) => void, value: () => number, reset: () => void}} does */
  line(name, orientation, { begin, move, value, reset }) {
    const line = h("div", {
      class: `divider ${name}`,
      role: "separator",
      tabindex: "0",
      "aria-orientation": orientation,
      "aria-label": `border ${NAMES[name]}`,
      title: "drag to resize; a double click resets it",
    });
    const along = (/** @type {PointerEvent} */ event) => (orientation === "vertical" ? event.clientX : event.clientY);
    const say = () => line.setAttribute("aria-valuenow", String(value()));
    /** @type {{at: number, began: any} | null} */
    let from = null;
    line.addEventListener("pointerdown", (event) => {
      event.preventDefault(); // no text is selected and dragged
      line.setPointerCapture(event.pointerId);
      from = { at: along(event), began: begin() };
    });
    line.addEventListener("pointermove", (event) => from && move(from.began, along(event) - from.at));
    for (const end of ["pointerup", "pointercancel"]) {
      line.addEventListener(end, () => {
        if (from) this.keep();
        from = null;
        say();
      });
    }
    line.addEventListener("dblclick", () => {
      reset();
      this.keep();
    });
    line.addEventListener("keydown", (event) => {
      const by = STEPS[event.key];
      if (event.key === "Enter") reset();
      else if (by) move(begin(), by);
      else return;
      event.preventDefault();
      event.stopPropagation();
      this.keep();
      say();
    });
    line.addEventListener("focus", say);
    line.setAttribute("aria-valuenow", "50");
    return line;
  }

  // ------------------------------------------------------------------------------------------------------------ keeping

  /** @returns {Kept} */
  atFirst() {
    return { shares: {}, sizes: {}, places: Object.fromEntries(Object.keys(this.slots).map((name) => [name, name])) };
  }

  /** Whether it is as at first. */
  get isFirst() {
    const { shares, sizes, places } = this.kept;
    return !Object.keys(shares).length && !Object.keys(sizes).length && Object.entries(places).every(([slot, home]) => slot === home);
  }

  /** Take the arrangement that was kept for a scenario.
   * @param {string} scenario */
  load(scenario) {
    this.key = KEY + scenario;
    this.kept = this.atFirst();
    try {
      const found = JSON.parse(kept(this.key) ?? "{}");
      for (const part of /** @type {const} */ (["shares", "sizes"])) {
        for (const [name, size] of Object.entries(found[part] ?? {})) if (Number.isFinite(size)) this.kept[part][name] = size;
      }
      const names = Object.keys(this.slots);
      const homes = names.map((name) => found.places?.[name]);
      if (names.every((name) => homes.includes(name))) this.kept.places = found.places;
    } catch {
      // What is kept is not of this version.
    }
    for (const [slot, home] of Object.entries(this.kept.places)) this.slots[slot].replaceChildren(...this.first[home]);
    this.apply();
  }

  reset() {
    this.showAll();
    this.kept = this.atFirst();
    for (const [slot, inside] of Object.entries(this.first)) this.slots[slot].replaceChildren(...inside);
    this.keep();
    this.apply();
  }

  keep() {
    if (this.key) keep(this.key, this.isFirst ? null : JSON.stringify(this.kept));
    this.changed();
  }

  apply() {
    for (const [name, slot] of Object.entries(this.slots)) {
      const share = this.kept.shares[name];
      slot.style.flexGrow = share === undefined ? "" : String(share);
      slot.classList.toggle("folded", share === 0);
    }
    for (const [name, element] of Object.entries({ bottom: this.bottom, side: this.slots.side })) {
      const size = this.kept.sizes[name];
      if (size === undefined) this.element.style.removeProperty(`--${name}`);
      else this.element.style.setProperty(`--${name}`, `${size}px`);
      element.classList.toggle("folded", size === 0);
    }
    this.changed();
  }
}
