// Live plots on a canvas of their own: a few thousand points in rings, drawn as one column of least and most a pixel.

import { clock, niceStep } from "./dom.js";
import { DASHES } from "./theme.js";

const MOST = 9000;

/** Samples of several curves over time, in bounded memory: when it is full, every other of the older half goes. */
export class Series {
  constructor(curves) {
    this.curves = curves; // names of kinds: "true", "measured", "estimated", "difference"
    this.clear();
  }

  clear() {
    this.times = [];
    this.values = this.curves.map(() => []);
  }

  /** Add a sample; one earlier than the last cuts off what came after it. */
  add(time, values) {
    while (this.times.length && this.times[this.times.length - 1] > time - 1e-9) {
      this.times.pop();
      for (const column of this.values) column.pop();
    }
    this.times.push(time);
    this.values.forEach((column, c) => column.push(values[c] ?? NaN));
    if (this.times.length <= MOST) return;
    const keep = (_, i) => i > MOST / 2 || i % 2 === 0;
    this.times = this.times.filter(keep);
    this.values = this.values.map((column) => column.filter(keep));
  }
}

export class Plot {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
  }

  draw(series, { theme, unit, now, least = 1e-6 }) {
    const { canvas, context } = this;
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = canvas;
    if (canvas.width !== Math.round(width * ratio)) canvas.width = Math.round(width * ratio);
    if (canvas.height !== Math.round(height * ratio)) canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = theme.paper;
    context.fillRect(0, 0, width, height);
    const box = { left: 52, right: width - 10, top: 8, bottom: height - 20 };
    if (box.right - box.left < 20 || box.bottom - box.top < 20) return;
    const [low, high] = range(series.values, least);
    const last = Math.max(now ?? 0, series.times[series.times.length - 1] ?? 0, 1);
    const across = (time) => box.left + ((box.right - box.left) * time) / last;
    const up = (value) => box.bottom - ((box.bottom - box.top) * (value - low)) / (high - low);
    this.axes(box, low, high, last, across, up, theme, unit);
    context.save();
    context.beginPath();
    context.rect(box.left, box.top - 2, box.right - box.left + 2, box.bottom - box.top + 4);
    context.clip();
    series.curves.forEach((kind, c) => this.curve(series.times, series.values[c], kind, across, up, theme));
    if (now < series.times[series.times.length - 1] - 1e-9) this.cursor(across(now), box, theme);
    context.restore();
  }

  axes(box, low, high, last, across, up, theme, unit) {
    const { context } = this;
    context.font = "11px system-ui, sans-serif";
    context.lineWidth = 1;
    context.strokeStyle = theme.line;
    context.fillStyle = theme.soft;
    context.setLineDash([]);
    const step = niceStep(((high - low) * 26) / (box.bottom - box.top));
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    context.textAlign = "right";
    context.textBaseline = "middle";
    context.beginPath();
    for (let value = Math.ceil(low / step) * step; value <= high + step / 1e6; value += step) {
      const y = Math.round(up(value)) + 0.5;
      context.moveTo(box.left, y);
      context.lineTo(box.right, y);
      context.fillText(value.toFixed(decimals).replace("-", "−"), box.left - 6, y);
    }
    context.stroke();
    context.textAlign = "center";
    context.textBaseline = "alphabetic";
    const wide = niceStep((last * 70) / (box.right - box.left));
    for (let time = 0; time <= last + wide / 1e6; time += wide) {
      if (across(time) > box.right - 14) break;
      context.fillText(last >= 120 ? clock(time).replace(/\.0$/, "") : `${+time.toFixed(6)} s`, across(time), box.bottom + 14);
    }
    context.textAlign = "left";
    context.fillText(unit ? `[${unit}]` : "", 6, box.bottom + 14);
  }

  /** Where in the past the panes are. */
  cursor(x, box, { danger }) {
    const { context } = this;
    context.strokeStyle = danger;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x, box.top);
    context.lineTo(x, box.bottom);
    context.stroke();
  }

  curve(times, values, kind, across, up, theme) {
    const { context } = this;
    context.strokeStyle = theme[kind] ?? theme.ink;
    context.lineWidth = 1.5;
    context.setLineDash((DASHES[kind] ?? []).map((d) => d * 0.8));
    context.beginPath();
    let down = false;
    let column = -1;
    let [least, most, first, end] = [0, 0, 0, 0];
    const flush = () => {
      if (column < 0) return;
      if (down) context.lineTo(column, up(first));
      else context.moveTo(column, up(first));
      if (least < most) {
        context.lineTo(column, up(least));
        context.lineTo(column, up(most));
        context.lineTo(column, up(end));
      }
      down = true;
    };
    for (let i = 0; i < times.length; i++) {
      const value = values[i];
      if (!Number.isFinite(value)) {
        flush();
        column = -1;
        down = false;
        continue;
      }
      const x = Math.round(across(times[i]) * 2) / 2;
      if (x === column) {
        least = Math.min(least, value);
        most = Math.max(most, value);
        end = value;
        continue;
      }
      flush();
      column = x;
      least = most = first = end = value;
    }
    flush();
    context.stroke();
    context.setLineDash([]);
  }
}

/** Bounds of the axis: all finite values, a little air, never of less height than four of the least digits shown. */
function range(columns, least) {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) {
    for (const value of column) {
      if (!Number.isFinite(value)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
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
