// The plots over time: each of one quantity of the selected robot, all of the same time, beside those of other futures.

import { Record } from "./record.js";
import { open } from "../shared/dialogs.js";
import { h, there } from "../shared/dom.js";
import { Plot } from "../shared/plot.js";
import { QUANTITY } from "./numbers.js";
import { FORMATS, savePlot } from "./plot_files.js";
import { KINDS } from "./quantities.js";

const MOST = 6; // plots
const FIRST = "apart"; // what the first plot shows at first

/** What can be drawn of a quantity: the difference, or the values, each with what the robot believes about it. */
const MODES = [["difference", "difference"], ["values", "all three"]];

/** One plot with its head. */
class QuantityPlot {
  /** @param {string} key
   * @param {Plots} plots */
  constructor(key, plots) {
    this.key = key;
    this.plots = plots;
    this.mode = "difference";
    this.chart = h("div", { class: "chart", role: "group", "aria-label": "plot" });
    this.plot = new Plot(this.chart);
    this.plot.zoomed = (zoom) => plots.zoomTo(zoom);
    this.select = h("select", { "aria-label": "quantity that is plotted", onchange: () => this.choose(this.select.value) });
    this.modes = h(
      "select",
      { "aria-label": "which curves are plotted", onchange: () => this.setMode(this.modes.value) },
      MODES.map(([mode, label]) => h("option", { value: mode }, label)),
    );
    this.saves = h("button", { class: "tool saves", "aria-label": "save this plot", title: "save this plot", onclick: () => this.save() }, "⤓");
    this.closes = h("button", { class: "tool", "aria-label": "close this plot", title: "close this plot", onclick: () => plots.remove(this) }, "×");
    this.tools = h("div", { class: "tools" }, this.plot.whole, this.select, this.modes, this.saves, this.closes);
    this.head = h("div", { class: "head" }, this.tools);
    this.element = h("div", { class: "one-plot" }, this.head, h("div", { class: "plot-area" }, this.chart));
    this.element.addEventListener("dragover", (event) => there(event.dataTransfer).types.includes(QUANTITY) && event.preventDefault());
    this.element.addEventListener("drop", (event) => {
      const quantity = there(event.dataTransfer).getData(QUANTITY);
      if (!quantity) return; // a panel, for the slot around this
      event.preventDefault();
      this.choose(quantity);
    });
  }

  /** @param {any[]} quantities */
  setQuantities(quantities) {
    this.select.replaceChildren(...quantities.map((q) => h("option", { value: q.key }, q.label)));
    this.choose(quantities.some((q) => q.key === this.key) ? this.key : quantities[0]?.key);
  }

  /** @param {string} key */
  choose(key) {
    this.key = this.select.value = key;
    this.describe();
    this.plots.chosen();
  }

  /** @param {string} mode */
  setMode(mode) {
    this.mode = this.modes.value = mode;
    this.describe();
    this.plots.chosen();
  }

  describe() {
    const quantity = this.plots.record.quantity(this.key);
    if (!quantity) return;
    const what = this.mode === "difference" ? "difference" : "true, measured and estimated values";
    this.chart.setAttribute("aria-label", `Plot over time: ${quantity.label} in ${quantity.unit}, ${what}`);
  }

  /** @param {import("../shared/theme.js").Theme} theme
   * @param {number | undefined} now */
  draw(theme, now) {
    const { record, futures } = this.plots;
    const quantity = record.quantity(this.key);
    if (!quantity) return;
    // "apart" has a bound that the robot believes in: the difference is drawn against it.
    const difference = quantity.key === "apart" ? ["estimated", "difference"] : ["difference"];
    const kinds = this.mode === "difference" ? difference : KINDS.slice(0, 3);
    const { times } = record.seriesOf(this.key);
    const [sigma] = record.columns(this.key, ["sigma"]);
    const middle = this.mode === "difference" ? null : record.columns(this.key, ["estimated"])[0];
    this.plot.draw(
      {
        curves: kinds,
        times,
        values: record.columns(this.key, kinds),
        band: quantity.sigma ? [-2, 2].map((factor) => sigma.map((one, n) => (middle ? middle[n] : 0) + factor * one)) : undefined,
        others: futures
          .filter((future) => future.record.series.get(this.key)?.times.length)
          .map((future) => ({
            name: future.name,
            times: future.record.seriesOf(this.key).times,
            values: future.record.columns(this.key, kinds),
          })),
      },
      { theme, unit: quantity.unit, now, least: 10 ** -quantity.decimals },
    );
  }

  save() {
    const kinds = Object.entries(FORMATS).map(([format, what]) =>
      h("button", { title: what, onclick: () => savePlot(format, this, this.plots.fileName()).then(() => dialog.close()) }, format.toUpperCase()),
    );
    const dialog = open("Save this plot", h("p", { class: "help" }, "As a picture (PNG), a drawing for papers (SVG), or its numbers (CSV)."), [
      h("button", { onclick: () => dialog.close() }, "cancel"),
      ...kinds,
    ]);
  }
}

export class Plots {
  /**
   * @param {HTMLElement} element what they fill
   * @param {HTMLElement} title stands in the head of the first
   * @param {{changed(): void, zoomed(zoom: [number, number] | null): void, fileName(): string}} on
   */
  constructor(element, title, on) {
    this.element = element;
    this.title = title;
    this.on = on;
    this.fileName = on.fileName;
    this.record = new Record(null);
    /** @type {import("./futures.js").Future[]} */
    this.futures = []; // drawn beside what is played
    /** @type {[number, number] | null} */
    this.zoom = null;
    this.magnify = 1;
    this.more = h("button", { class: "tool", "aria-label": "one more plot", title: "one more plot", onclick: () => this.add() }, "+");
    /** @type {QuantityPlot[]} */
    this.list = [];
    this.insert(FIRST);
  }

  get first() {
    return this.list[0];
  }

  /** The quantities that are plotted. */
  get keys() {
    return new Set(this.list.map((one) => one.key));
  }

  /** Another robot.
   * @param {import("./record.js").Record} record */
  setRecord(record) {
    this.record = record;
    this.futures = [];
    for (const one of this.list) one.setQuantities(record.quantities);
  }

  /** @param {string} key */
  insert(key) {
    const one = new QuantityPlot(key, this);
    one.plot.magnify = this.magnify;
    this.list.push(one);
    this.element.append(one.element);
    this.arrange();
    return one;
  }

  /** One more plot, of a quantity or of the next that is not plotted yet.
   * @param {string} [key] */
  add(key) {
    if (this.list.length === MOST) return;
    const { quantities } = this.record;
    const next = key ?? quantities.find((q) => !this.keys.has(q.key))?.key ?? FIRST;
    const one = this.insert(next);
    one.setQuantities(quantities);
    one.plot.zoomTo(this.zoom);
    one.element.scrollIntoView({ block: "nearest" });
  }

  /** @param {QuantityPlot} one */
  remove(one) {
    this.list = this.list.filter((other) => other !== one);
    one.plot.destroy();
    one.element.remove();
    this.arrange();
    this.chosen();
  }

  /** What all have in common stands in the head of the first; the last of all cannot be closed. */
  arrange() {
    this.first.head.prepend(this.title);
    this.first.tools.append(this.more);
    this.more.disabled = this.list.length === MOST;
    for (const one of this.list) one.closes.hidden = this.list.length === 1;
  }

  /** Show a quantity in the first plot.
   * @param {string} key */
  choose(key) {
    this.first.choose(key);
  }

  chosen() {
    if (this.record) this.on.changed();
  }

  /** Show a part of the time in all plots, or all of it.
   * @param {[number, number] | null} zoom */
  zoomTo(zoom) {
    this.zoom = zoom;
    for (const one of this.list) one.plot.zoomTo(zoom);
    this.on.zoomed(zoom);
  }

  /** @param {number} magnify */
  setMagnify(magnify) {
    this.magnify = magnify;
    for (const one of this.list) one.plot.magnify = magnify;
  }

  /** @param {import("../shared/theme.js").Theme} theme
   * @param {{time: number} | undefined} frame */
  draw(theme, frame) {
    for (const one of this.list) one.draw(theme, frame?.time);
  }
}
