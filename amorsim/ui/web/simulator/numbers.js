// The table of true | measured | estimated | difference, and the plot of the row that is chosen.

import { fixed, h, say, signed } from "../shared/dom.js";
import { Plot } from "../shared/plot.js";
import { Series } from "../shared/series.js";
import { momentsOf } from "./past.js";
import { KINDS, quantitiesOf } from "./quantities.js";

export class Numbers {
  constructor(table, plotHead, chart) {
    this.table = table;
    this.plot = new Plot(chart);
    this.chart = chart;
    this.chosen = "apart";
    this.showsDifference = true;
    this.select = h("select", { "aria-label": "quantity that is plotted", onchange: () => this.choose(this.select.value) });
    this.mode = h(
      "select",
      { "aria-label": "which curves are plotted", onchange: () => this.setMode(this.mode.value) },
      h("option", { value: "difference" }, "difference"),
      h("option", { value: "values" }, "all three"),
    );
    plotHead.append(this.plot.whole, this.select, this.mode);
    this.quantities = [];
    this.series = new Map();
    this.changed = () => {}; // called when something else is to be drawn
  }

  /** Another robot: its quantities, and nothing recorded of them yet. */
  setRobot(robot) {
    this.quantities = robot ? quantitiesOf(robot) : [];
    this.series = new Map(this.quantities.map((q) => [q.key, new Series(KINDS)]));
    if (!this.quantities.some((q) => q.key === this.chosen)) this.chosen = this.quantities[0]?.key;
    this.select.replaceChildren(...this.quantities.map((q) => h("option", { value: q.key }, q.label)));
    this.rows = this.quantities.map((quantity) => {
      const cells = KINDS.map((kind) => h("td", { class: kind }));
      const pick = h(
        "button",
        { class: "row-name", title: "plot this", onclick: () => this.choose(quantity.key) },
        quantity.label,
        h("span", { class: "unit" }, ` ${quantity.unit}`),
      );
      return { quantity, cells, row: h("tr", {}, h("th", { scope: "row" }, pick), cells) };
    });
    this.table.replaceChildren(...this.rows.map((row) => row.row));
    this.choose(this.chosen);
  }

  choose(key) {
    if (key !== this.chosen) this.plot.zoomTo(null);
    this.chosen = key;
    this.select.value = key;
    for (const { quantity, row } of this.rows ?? []) row.classList.toggle("chosen", quantity.key === key);
    this.describe();
    this.changed();
  }

  setMode(mode) {
    this.mode.value = mode;
    this.showsDifference = mode === "difference";
    this.describe();
    this.changed();
  }

  describe() {
    const quantity = this.quantities.find((q) => q.key === this.chosen);
    if (!quantity) return;
    const what = this.showsDifference ? "difference" : "true, measured and estimated values";
    this.chart.setAttribute("aria-label", `Plot over time: ${quantity.label} in ${quantity.unit}, ${what}`);
  }

  clear() {
    for (const series of this.series.values()) series.clear();
  }

  /** Take what was recorded, after a reload, a turn to another robot or a step back in time; `dt` in s. */
  load(history, robot, dt) {
    const moments = momentsOf(history, robot, dt);
    const last = moments.at(-1)?.time ?? -1;
    for (const quantity of this.quantities) {
      const series = this.series.get(quantity.key);
      // What has come since it was asked for stays.
      const later = series.times.flatMap((time, n) => (time > last + 1e-9 ? [[time, series.values.map((column) => column[n])]] : []));
      series.clear();
      for (const moment of moments) series.add(moment.time, quantity.of(moment, 0));
      for (const [time, values] of later) series.add(time, values);
    }
  }

  /** Keep a frame's values; those of the past are kept already. */
  record(frame) {
    for (const quantity of this.quantities) {
      this.series.get(quantity.key).add(frame.time, quantity.of(frame, frame.selected));
    }
  }

  show(frame) {
    for (const { quantity, cells } of this.rows ?? []) {
      const values = quantity.of(frame, frame.selected);
      cells.forEach((cell, k) => say(cell, k === 3 ? signed(values[k], quantity.decimals) : fixed(values[k], quantity.decimals)));
    }
  }

  /** The measured velocities in words: of the joints that are counted, and of the turning. */
  velocities(frame) {
    const words = [];
    for (const quantity of this.quantities) {
      if (quantity.key !== "turn" && !quantity.key.startsWith("joint.")) continue;
      const measured = quantity.of(frame, frame.selected)[1];
      if (Number.isFinite(measured)) words.push(`${quantity.label} ${fixed(measured, quantity.key === "turn" ? 1 : 2)} ${quantity.unit}`);
    }
    return words.slice(0, 4).join(" · ");
  }

  draw(theme, frame) {
    const quantity = this.quantities.find((q) => q.key === this.chosen);
    const series = this.series.get(this.chosen);
    if (!quantity || !series) return;
    // "apart" has a bound that the robot believes in: the difference is drawn against it.
    const wanted = this.showsDifference
      ? quantity.key === "apart" ? ["estimated", "difference"] : ["difference"]
      : KINDS.slice(0, 3);
    const shown = { curves: wanted, times: series.times, values: wanted.map((kind) => series.values[KINDS.indexOf(kind)]) };
    this.plot.draw(shown, { theme, unit: quantity.unit, now: frame?.time, least: 10 ** -quantity.decimals });
  }
}
