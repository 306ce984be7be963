// Rulers along the upper and the left edge of the canvas, in metres.

import { niceStep } from "../shared/dom.js";
import { Layer } from "../shared/layer.js";

export const WIDE = 18; // pixels
const APART = 60; // pixels from one number to the next, at least

export class RulersLayer extends Layer {
  /** @type {"pane"} */
  space = "pane";

  /** @param {() => boolean} isShown */
  constructor(isShown) {
    super();
    this.wanted = isShown;
  }

  get isShown() {
    return this.wanted();
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { width, height, scale } = camera;
    const step = niceStep(APART / scale);
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const words = (/** @type {number} */ value) => (Math.abs(value) < step / 1e6 ? "0" : value.toFixed(decimals).replace("-", "−"));
    context.fillStyle = theme.paper;
    context.globalAlpha = 0.9;
    context.fillRect(0, 0, width, WIDE);
    context.fillRect(0, 0, WIDE, height);
    context.globalAlpha = 1;
    context.strokeStyle = theme.soft;
    context.fillStyle = theme.soft;
    context.lineWidth = 1;
    context.font = "10px system-ui, sans-serif";
    const [left, top] = camera.toWorld(0, 0);
    const [right, bottom] = camera.toWorld(width, height);
    context.beginPath();
    for (let n = Math.ceil((5 * left) / step); n <= (5 * right) / step; n++) {
      const [at] = camera.toScreen((n * step) / 5, 0);
      if (at < WIDE) continue;
      context.moveTo(at, WIDE);
      context.lineTo(at, WIDE - (n % 5 ? 3 : 7));
      if (n % 5 === 0) context.fillText(words((n * step) / 5), at + 3, 10);
    }
    for (let n = Math.ceil((5 * bottom) / step); n <= (5 * top) / step; n++) {
      const [, at] = camera.toScreen(0, (n * step) / 5);
      if (at < WIDE) continue;
      context.moveTo(WIDE, at);
      context.lineTo(WIDE - (n % 5 ? 3 : 7), at);
      if (n % 5 === 0) {
        context.save();
        context.translate(9, at - 3);
        context.rotate(-Math.PI / 2);
        context.fillText(words((n * step) / 5), 0, 1);
        context.restore();
      }
    }
    context.moveTo(WIDE, WIDE);
    context.lineTo(width, WIDE);
    context.moveTo(WIDE, WIDE);
    context.lineTo(WIDE, height);
    context.stroke();
  }
}
