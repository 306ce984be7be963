// A plot as a file: a picture of its pixels (PNG), a drawing of its curves (SVG), or its numbers (CSV).

import { context2d, there } from "../shared/dom.js";
import { download } from "../shared/capture.js";
import { drawing } from "../shared/plot_drawing.js";
import { KINDS } from "./quantities.js";

/** The formats, and what each is. */
export const FORMATS = { png: "a picture", svg: "a drawing", csv: "numbers, a line for each moment" };

/**
 * @param {string} format one of those of `FORMATS`
 * @param {any} one a plot of a quantity
 * @param {string} name of the file, without the quantity and the ending
 */
export async function savePlot(format, one, name) {
  const file = `${name}-${one.key.replace(/[^\w.-]/g, "_")}.${format}`;
  if (format === "png") download(await picture(one.plot), file);
  if (format === "svg") download(new Blob([drawing(one.plot, one.plots.record.quantity(one.key).label)], { type: "image/svg+xml" }), file);
  if (format === "csv") download(new Blob([table(one.plots.record, one.plots.futures, one.key)], { type: "text/csv" }), file);
}

/** @param {import("../shared/plot.js").Plot} plot
 * @returns {Promise<Blob>} */
function picture({ chart, look }) {
  const { canvas } = chart.ctx;
  const whole = document.createElement("canvas");
  [whole.width, whole.height] = [canvas.width, canvas.height];
  const context = context2d(whole, { alpha: false });
  context.fillStyle = there(look).theme.paper;
  context.fillRect(0, 0, whole.width, whole.height);
  context.drawImage(canvas, 0, 0);
  return new Promise((done) => whole.toBlob((blob) => done(there(blob)), "image/png"));
}

/**
 * A line for each sample, of what is played and of each other future; empty where there is no value.
 * @param {import("./record.js").Record} record
 * @param {import("./futures.js").Future[]} futures
 * @param {string} key
 */
export function table(record, futures, key) {
  const names = [...KINDS, "sigma"];
  const { unit } = there(record.quantity(key));
  const lines = [["future", "time [s]", ...names.map((name) => `${name} [${unit}]`)].join(",")];
  for (const one of [{ name: "", record }, ...futures]) {
    const series = one.record.series.get(key);
    const columns = one.record.columns(key, names);
    series?.times.forEach((time, n) => lines.push([one.name, Number(time.toFixed(6)), ...columns.map((column) => written(column[n]))].join(",")));
  }
  return lines.join("\n") + "\n";
}

const written = (/** @type {number} */ value) => (Number.isFinite(value) ? String(value) : "");
