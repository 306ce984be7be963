// The table of true | measured | estimated | difference of the selected robot.

import { fixed, h, say, signed, there } from "../shared/dom.js";
import { KINDS } from "./quantities.js";

/** What a row carries when it is dragged: the key of its quantity. */
export const QUANTITY = "application/x-amorsim-quantity";

export class Numbers {
  /** @param {HTMLElement} table
   * @param {{plot(key: string): void, add(key: string): void}} on a row was clicked, alone or with Shift */
  constructor(table, on) {
    this.table = table;
    this.on = on;
    /** @type {{quantity: any, cells: HTMLElement[], row: HTMLElement}[]} */
    this.rows = [];
  }

  /** Another robot, with other quantities.
   * @param {any[]} quantities */
  setQuantities(quantities) {
    this.rows = quantities.map((quantity) => {
      const cells = KINDS.map((kind) => h("td", { class: kind }));
      const pick = h(
        "button",
        {
          class: "row-name",
          draggable: "true",
          title: "plot this; with Shift in a plot of its own, or drag it into a plot",
          onclick: (/** @type {PointerEvent} */ event) => (event.shiftKey ? this.on.add(quantity.key) : this.on.plot(quantity.key)),
          ondragstart: (/** @type {DragEvent} */ event) => there(event.dataTransfer).setData(QUANTITY, quantity.key),
        },
        quantity.label,
        h("span", { class: "unit" }, ` ${quantity.unit}`),
      );
      return { quantity, cells, row: h("tr", {}, h("th", { scope: "row" }, pick), cells) };
    });
    this.table.replaceChildren(...this.rows.map((row) => row.row));
  }

  /** Mark the rows that are plotted.
   * @param {Set<string>} keys */
  mark(keys) {
    for (const { quantity, row } of this.rows) row.classList.toggle("chosen", keys.has(quantity.key));
  }

  /** @param {import("./messages.d.ts").Frame} frame */
  show(frame) {
    for (const { quantity, cells } of this.rows) {
      const values = quantity.of(frame, frame.selected);
      cells.forEach((cell, k) => say(cell, k === 3 ? signed(values[k], quantity.decimals) : fixed(values[k], quantity.decimals)));
    }
  }

  /** The measured velocities in words: of the joints that are counted, and of the turning.
   * @param {import("./messages.d.ts").Frame} frame */
  velocities(frame) {
    const words = [];
    for (const { quantity } of this.rows) {
      if (quantity.key !== "turn" && !quantity.key.startsWith("joint.")) continue;
      const measured = quantity.of(frame, frame.selected)[1];
      if (Number.isFinite(measured)) words.push(`${quantity.label} ${fixed(measured, quantity.key === "turn" ? 1 : 2)} ${quantity.unit}`);
    }
    return words.slice(0, 4).join(" · ");
  }
}
