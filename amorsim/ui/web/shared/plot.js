// Plots over time, by uPlot: a drag along the axis zooms, a double click or "all" shows all, and the pointer tells values.

// @ts-types="./uplot.d.ts"
import uPlot from "../vendor/uplot/uPlot.esm.js";
import { clock, fixed, h, niceStep, say } from "./dom.js";
import { nearest } from "./series.js";
import { DASHES } from "./theme.js";

const LEFT = 52; // pixels of the axis of values
const LEAST_DRAG = 5; // pixels
const FAR = 1; // seconds from the pointer: what is farther away is not told

/**
 * What is drawn: samples of curves, each of a kind that has a colour and dashes. `band` has the lower and the upper edge
 * of what is believed, at the same times. `others` have the same curves at other times, and are drawn pale.
 * @typedef {{name: string, times: number[], values: number[][]}} OtherCurves
 * @typedef {{curves: string[], times: number[], values: number[][], band?: number[][], others?: OtherCurves[]}} Curves
 * @typedef {{theme: import("./theme.js").Theme, unit: string, now?: number, least?: number}} Look
 *   `now` is the moment that is shown, `least` the least difference that means something
 */

export class Plot {
  /** @param {HTMLElement} element what it fills */
  constructor(element) {
    this.element = element;
    this.values = h("output", { class: "plot-values", "aria-hidden": "true" }); // also in the table, which screen readers read
    /** Shows all of the time again; for where the plot's other controls are. */
    this.whole = h("button", { class: "tool", hidden: true, title: "all of the time (or a double click)" }, "all");
    this.whole.addEventListener("click", () => this.zoomed(null));
    /** Called when the user has chosen a part of the time [s], or all of it. */
    this.zoomed = (/** @type {[number, number] | null} */ zoom) => this.zoomTo(zoom);
    element.append(this.values);
    /** @type {[number, number] | null} */
    this.zoom = null; // the time that is shown, or null for all
    /** @type {unknown[]} */
    this.made = []; // what the present one was made of
    this.range = [0, 1];
    this.magnify = 1; // how much larger lines and type are
    this.marked = NaN; // a moment of the past
    /** @type {Curves | null} */
    this.curves = null; // what is drawn, and how
    /** @type {Look | null} */
    this.look = null;
  }

  /** Show a part of the time [s], or all of it.
   * @param {[number, number] | null} zoom */
  zoomTo(zoom) {
    this.zoom = zoom;
    this.whole.hidden = !zoom;
    if (this.curves && this.look) this.draw(this.curves, this.look);
  }

  destroy() {
    this.chart?.destroy();
    this.chart = null;
  }

  /**
   * @param {Curves} curves
   * @param {Look} look
   */
  draw(curves, look) {
    [this.curves, this.look] = [curves, look];
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width < 2 * LEFT || height < 48) return;
    const made = [look.theme, look.unit, this.magnify, curves.others?.length, Boolean(curves.band), ...curves.curves];
    if (!this.chart || made.length !== this.made.length || made.some((part, n) => part !== this.made[n])) {
      this.chart?.destroy();
      this.made = made;
      this.chart = this.make(curves, look, width, height);
    } else if (this.chart.width !== width || this.chart.height !== height) {
      this.chart.setSize({ width, height });
    }
    const newest = curves.times[curves.times.length - 1] ?? 0;
    const [from, to] = spanOf(curves, look, this.zoom);
    this.range = rangeOf(curves, from, to, look.least ?? 1e-6);
    const now = look.now ?? Infinity;
    this.marked = now < newest - 1e-9 ? now : NaN;
    const columns = [...(curves.band ?? []), ...curves.values].map(withGaps);
    const tables = [[curves.times, ...columns], ...(curves.others ?? []).map((other) => [other.times, ...other.values.map(withGaps)])];
    this.chart.batch(() => {
      this.chart.setData(tables.length > 1 ? uPlot.join(tables) : tables[0], false);
      this.chart.setScale("x", { min: from, max: to });
      this.chart.setScale("y", { min: this.range[0], max: this.range[1] });
    });
    this.tell();
  }

  /**
   * @param {Curves} curves
   * @param {Look} look
   * @param {number} width
   * @param {number} height
   */
  make(curves, { theme, unit }, width, height) {
    const large = this.magnify;
    const series = (/** @type {string} */ kind, /** @type {number} */ alpha) => ({
      stroke: theme[kind] ?? theme.ink,
      alpha,
      width: 1.5 * large,
      dash: (DASHES[kind] ?? []).map((/** @type {number} */ part) => part * 0.8 * large),
      points: { show: false },
    });
    const quiet = { stroke: theme.soft, font: `${11 * large}px system-ui, sans-serif`, ticks: { show: false } };
    return new uPlot(
      {
        width,
        height,
        padding: [8, 14 * large, 0, 0],
        legend: { show: false },
        cursor: {
          y: false,
          drag: { x: true, y: false, setScale: false, dist: LEAST_DRAG },
          points: { size: 6, width: 0 },
          bind: { dblclick: () => () => (this.zoomed(null), null) },
          sync: { key: "time", setSeries: false },
        },
        scales: { x: { time: false, auto: false }, y: { auto: false, range: () => /** @type {[number, number]} */ (this.range) } },
        axes: [
          { ...quiet, size: 22 * large, gap: 4, grid: { show: false }, space: 70 * large, values: (/** @type {unknown} */ _, /** @type {number[]} */ times) => times.map((time) => timeOf(time, times)) },
          {
            ...quiet,
            size: LEFT * large,
            gap: 6,
            grid: { stroke: theme.line, width: 1 },
            splits: (/** @type {unknown} */ _, /** @type {unknown} */ __, /** @type {number} */ low, /** @type {number} */ high) => linesBetween(low, high, height / large),
            values: (/** @type {unknown} */ _, /** @type {number[]} */ lines) => lines.map((value) => fixed(value, decimalsOf(lines))),
          },
        ],
        bands: curves.band ? [{ series: [2, 1], fill: theme["estimated-fill"] }] : [],
        series: [
          {},
          ...(curves.band ?? []).map(() => ({ width: 0, stroke: "transparent", points: { show: false } })),
          ...curves.curves.map((kind) => series(kind, 1)),
          ...(curves.others ?? []).flatMap(() => curves.curves.map((kind) => series(kind, 0.4))),
        ],
        hooks: {
          draw: [(/** @type {any} */ chart) => this.mark(chart, theme, unit)],
          setCursor: [() => this.tell()],
          setSelect: [(/** @type {any} */ chart) => this.selected(chart)],
        },
      },
      [[], ...(curves.band ?? []).map(() => []), ...[curves, ...(curves.others ?? [])].flatMap(({ values }) => values.map(() => []))],
      this.element,
    );
  }

  /** The unit, and where in the past the panes are.
   * @param {any} chart
   * @param {import("./theme.js").Theme} theme
   * @param {string} unit */
  mark(chart, theme, unit) {
    const { ctx: context, bbox } = chart;
    const ratio = uPlot.pxRatio * this.magnify;
    context.save();
    context.fillStyle = theme.soft;
    context.font = `${11 * ratio}px system-ui, sans-serif`;
    context.textAlign = "left";
    context.textBaseline = "alphabetic";
    if (unit) context.fillText(`[${unit}]`, 6 * ratio, bbox.top + bbox.height + 15 * ratio);
    const x = chart.valToPos(this.marked, "x", true);
    if (x >= bbox.left && x <= bbox.left + bbox.width) {
      context.strokeStyle = theme.danger;
      context.lineWidth = ratio;
      context.setLineDash([]);
      context.beginPath();
      context.moveTo(x, bbox.top);
      context.lineTo(x, bbox.top + bbox.height);
      context.stroke();
    }
    context.restore();
  }

  /** A part of the time was dragged over.
   * @param {any} chart */
  selected(chart) {
    const { left, width } = chart.select;
    if (width < LEAST_DRAG) return;
    const [from, to] = [chart.posToVal(left, "x"), chart.posToVal(left + width, "x")];
    chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoomed([from, to]);
  }

  /** Tell the values under the pointer. */
  tell() {
    const place = this.chart?.cursor.idx;
    const time = this.chart?.cursor.left >= 0 && Number.isInteger(place) ? this.chart.data[0][place] : undefined;
    const { curves: drawn, look } = this;
    if (time === undefined || !drawn || !look) {
      say(this.values, "");
      return;
    }
    const decimals = Math.max(0, Math.round(-Math.log10(look.least ?? 1e-3)));
    const { curves, others = [] } = drawn;
    const told = [{ name: "", ...drawn }, ...others].flatMap(({ name, times, values }) => {
      const n = nearest(times, time);
      if (n < 0 || Math.abs(times[n] - time) > FAR) return [];
      const words = curves.map((kind, c) => `${kind} ${fixed(values[c][n], decimals)}`).join(" · ");
      return [name ? `${name}: ${words}` : words];
    });
    say(this.values, `${fixed(time, 2)} s: ${told.join(" · ")} ${look.unit}`);
  }
}

/** @param {number[]} column */
const withGaps = (column) => column.map((value) => (Number.isFinite(value) ? value : null));

/**
 * The time that is shown, from and to [s].
 * @param {Curves} curves
 * @param {Look} look
 * @param {[number, number] | null} zoom
 */
export function spanOf(curves, look, zoom) {
  const ends = [curves, ...(curves.others ?? [])].map(({ times }) => times[times.length - 1] ?? 0);
  return zoom ?? [0, Math.max(look.now ?? 0, ...ends, 1)];
}

/** A moment on the axis: in minutes where it is long.
 * @param {number} time
 * @param {number[]} all */
export const timeOf = (time, all) =>
  all[all.length - 1] >= 120 ? clock(time).replace(/\.0$/, "") : `${Number(time.toFixed(6))} s`.replace("-", "−");

/** Values of round distance.
 * @param {number} low
 * @param {number} high
 * @param {number} height pixels */
export function linesBetween(low, high, height) {
  const step = niceStep(((high - low) * 26) / Math.max(height - 30, 26));
  const lines = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n++) lines.push(n * step);
  return lines;
}

/** @param {number[]} lines */
export const decimalsOf = (lines) => (lines.length < 2 ? 3 : Math.max(0, -Math.floor(Math.log10(lines[1] - lines[0]) + 1e-9)));

/**
 * Bounds of the axis: all finite values of a time, a little air, never of less height than four of the least digits shown.
 * @param {Curves} curves
 * @param {number} from
 * @param {number} to
 * @param {number} least
 * @returns {[number, number]}
 */
function rangeOf(curves, from, to, least) {
  let [low, high] = [Infinity, -Infinity];
  const tables = [curves, ...(curves.others ?? []), { times: curves.times, values: curves.band ?? [] }];
  for (const { times, values } of tables) {
    for (const column of values) {
      for (let n = 0; n < column.length; n++) {
        const value = column[n];
        if (!Number.isFinite(value) || times[n] < from || times[n] > to) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
  }
  if (low > high) return [0, 1];
  const air = Math.max((high - low) * 0.06, Math.abs(high) * 1e-6);
  if (high - low < 4 * least) {
    const middle = (low + high) / 2;
    return low >= 0 && high < 4 * least ? [0, 4 * least] : [middle - 4 * least, middle + 4 * least];
  }
  return [low >= 0 && low < high * 0.5 ? 0 : low - air, high + air];
}
