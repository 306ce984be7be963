// A canvas: layers drawn through a camera at the device's pixels, a scale bar, coordinates, and a tool for pointer and keys.

import { zoomOf } from "./camera.js";
import { fixed, h, niceStep, say } from "./dom.js";
import { Bitmap, drawLayer } from "./layer.js";
import { Pinch } from "./pinch.js";
import { Tool } from "./tool.js";

const BUTTONS = { left: 0, middle: 1 };

export class Canvas {
  /**
   * @param {{id: string, label: string, camera: import("./camera.js").Camera, theme: import("./theme.js").Theme}} what
   *   `camera` may be shared with other canvases, `label` is for those who do not see it
   */
  constructor({ id, label, camera, theme }) {
    this.camera = camera;
    this.theme = theme;
    this.magnify = 1; // how much larger lines, type and marks are drawn; pixels here are as many of the page's
    this.ratio = 1; // device pixels a pixel of ours
    this.width = 1; // in CSS pixels; canvases that share a camera may differ, and see the same point in their middle
    this.height = 1;
    /** @type {import("./layer.js").Layer[]} */
    this.layers = []; // the lowest first
    /** @type {Bitmap[]} */
    this.bitmaps = [];
    this.edge = 0; // pixels on the left that something else needs
    this.tool = new Tool();
    /** @type {Tool | null} */
    this.active = null; // the tool that the pointer is down with
    this.panning = new Tool(); // the tool of the middle button
    this.pinch = new Pinch(camera);
    /** Where the pointer is, if it is over the canvas and was used last. @type {{left: number, top: number} | null} */
    this.pointed = null;
    this.coordinates = h("output", { class: "coordinates", "aria-hidden": "true" });
    this.canvas = /** @type {HTMLCanvasElement} */ (h("canvas", { id, tabindex: "0", role: "img", "aria-label": label }));
    this.element = h("div", { class: "pane" }, this.canvas, this.coordinates);
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d", { alpha: false }));
    this.listen();
  }

  /** Take a tool in place of the one there is.
   * @param {Tool} tool */
  take(tool) {
    this.cancel();
    this.tool.cancel();
    this.tool = tool;
    this.showCursor();
  }

  /** Give up what the pointer has begun. */
  cancel() {
    this.active?.cancel();
    this.active = null;
    this.showCursor();
  }

  /** Fit the canvas to its element; returns its width and height in pixels. */
  resize() {
    this.ratio = (globalThis.devicePixelRatio || 1) * this.magnify;
    const [clientWidth, clientHeight] = [this.element.clientWidth / this.magnify, this.element.clientHeight / this.magnify];
    [this.width, this.height] = [clientWidth, clientHeight];
    const [width, height] = [Math.round(clientWidth * this.ratio), Math.round(clientHeight * this.ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    return [clientWidth, clientHeight];
  }

  draw() {
    const { context, ratio, theme } = this;
    if (!this.canvas.width || !this.canvas.height) return; // another panel is shown alone
    const camera = this.camera.onPixels(ratio);
    camera.resize(this.width, this.height);
    const brush = { context, camera, ratio, theme };
    const shown = this.layers.filter((layer) => layer.isShown);
    let [at, run] = [0, 0];
    // The first run has the paper, also where it has no layer.
    while (at < shown.length || run === 0) {
      const from = at;
      while (at < shown.length && shown[at].isStatic) at++;
      if (at > from || run === 0) {
        this.bitmaps[run] ??= new Bitmap();
        this.bitmaps[run].draw(shown.slice(from, at), brush, this.canvas, run === 0);
        run++;
      }
      while (at < shown.length && !shown[at].isStatic) drawLayer(shown[at++], brush);
    }
    this.bitmaps.length = run;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.drawScale();
    if (!this.pointed && this.canvas.matches(":focus-visible")) this.drawMiddle();
  }

  drawScale() {
    const { context, camera, theme } = this;
    const length = niceStep(50 / camera.scale);
    const wide = length * camera.scale;
    const [left, base] = [12.5 + this.edge, this.height - 12.5];
    const text = length >= 1 ? `${length} m` : `${Math.round(length * 1000)} mm`;
    context.font = "12px system-ui, sans-serif";
    context.globalAlpha = 0.8;
    context.fillStyle = theme.paper;
    context.fillRect(left - 6, base - 12, wide + context.measureText(text).width + 18, 18);
    context.globalAlpha = 1;
    context.strokeStyle = theme.soft;
    context.fillStyle = theme.soft;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(left, base - 4);
    context.lineTo(left, base);
    context.lineTo(left + wide, base);
    context.lineTo(left + wide, base - 4);
    context.stroke();
    context.fillText(text, left + wide + 6, base);
  }

  /** What keys point at. */
  drawMiddle() {
    const { context, theme } = this;
    const [x, y] = [this.width / 2, this.height / 2];
    context.strokeStyle = theme.ink;
    context.lineWidth = 1;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(x + 4 * side, y);
      context.lineTo(x + 11 * side, y);
      context.moveTo(x, y + 4 * side);
      context.lineTo(x, y + 11 * side);
    }
    context.stroke();
  }

  showCursor() {
    this.canvas.style.cursor = (this.active ?? this.tool).cursor;
  }

  /** @param {MouseEvent} event
   * @returns {import("./tool.js").Place} */
  placeOf(event) {
    const box = this.canvas.getBoundingClientRect();
    const [left, top] = [(event.clientX - box.left) / this.magnify, (event.clientY - box.top) / this.magnify];
    return this.placeAt(left, top);
  }

  /** @param {number} left pixels
   * @param {number} top
   * @returns {import("./tool.js").Place} */
  placeAt(left, top) {
    const [x, y] = this.camera.toWorld(...this.onCamera(left, top));
    return { x, y, left, top };
  }

  /** A point of the canvas in the camera's own pixels.
   * @param {number} left
   * @param {number} top
   * @returns {[number, number]} */
  onCamera(left, top) {
    return [left + (this.camera.width - this.width) / 2, top + (this.camera.height - this.height) / 2];
  }

  /** @param {import("./tool.js").Place} place
   * @returns {import("./pinch.js").Finger} */
  fingerAt(place) {
    const [left, top] = this.onCamera(place.left, place.top);
    return { left, top };
  }

  /** The place that keys point at: the pointer's, or the middle where the keyboard alone is used.
   * @returns {import("./tool.js").Place} */
  get keyPlace() {
    const { left, top } = this.pointed ?? { left: this.width / 2, top: this.height / 2 };
    return this.placeAt(left, top);
  }

  /** Move what is seen, by keys; they point at the middle then, and so does the tool.
   * @param {number} right pixels
   * @param {number} down */
  pan(right, down) {
    this.camera.pan(right, down);
    this.pointed = null;
    this.tool.move(this.keyPlace, /** @type {any} */ ({ altKey: false, shiftKey: false }));
  }

  listen() {
    const { canvas, camera } = this;
    canvas.addEventListener("pointerdown", (event) => {
      this.pointed = this.placeOf(event);
      if (event.pointerType === "touch" && this.pinch.down(event.pointerId, this.fingerAt(this.placeOf(event)))) {
        this.cancel(); // what the first finger had begun
        return;
      }
      if (this.active || !Object.values(BUTTONS).includes(event.button)) return;
      canvas.setPointerCapture(event.pointerId);
      this.active = event.button === BUTTONS.middle ? this.panning : this.tool;
      this.active.down(this.placeOf(event), event);
      this.showCursor();
    });
    canvas.addEventListener("pointermove", (event) => {
      const place = this.placeOf(event);
      if (this.pinch.move(event.pointerId, this.fingerAt(place))) return;
      this.pointed = place;
      say(this.coordinates, `${fixed(place.x, 2)}, ${fixed(place.y, 2)} m`);
      (this.active ?? this.tool).move(place, event);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (this.pinch.up(event.pointerId)) return;
      const { active } = this;
      this.active = null;
      active?.up(this.placeOf(event), event);
      this.showCursor();
    });
    for (const end of ["pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(end, (event) => {
        this.pinch.up(/** @type {PointerEvent} */ (event).pointerId);
        if (this.active) this.cancel();
      });
    }
    canvas.addEventListener("pointerleave", () => {
      this.pointed = null;
      say(this.coordinates, "");
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const { left, top } = this.placeOf(event);
        camera.zoom(zoomOf(event), ...this.onCamera(left, top));
      },
      { passive: false },
    );
    canvas.addEventListener("keydown", (event) => {
      if (event.key === "Escape" && this.active) {
        this.cancel();
        return;
      }
      if (this.tool.key(event, this.keyPlace)) event.preventDefault();
    });
    canvas.addEventListener("focus", () => {
      if (canvas.matches(":focus-visible")) this.pointed = null; // it came by the keyboard
      camera.changed();
    });
    canvas.addEventListener("blur", () => camera.changed());
  }
}
