// What part of the world is seen: one camera for all panes, so that they stay in step. Pure geometry, no drawing.

const NEAREST = 4000; // pixels a metre
const FARTHEST = 0.5;
const ZOOM = 0.0015; // of a wheel's turn, as a power of e
const MOST = 120; // of a turn: that of one notch of most mice
const PINCH = 10; // browsers tell of two fingers on a trackpad as a wheel that turns this much less, with Ctrl down

/** How many times larger a wheel's turn shows the world.
 * @param {{deltaY: number, ctrlKey: boolean}} event */
export function zoomOf({ deltaY, ctrlKey }) {
  const turn = ctrlKey ? PINCH * deltaY : deltaY;
  return Math.exp(-ZOOM * Math.max(-MOST, Math.min(turn, MOST)));
}

export class Camera {
  constructor() {
    this.x = 0; // world point in the middle of the pane [m]
    this.y = 0;
    this.scale = 50; // pixels a metre
    this.width = 1; // of a pane, in CSS pixels
    this.height = 1;
    this.changed = () => {};
  }

  /** @param {number} x
   * @param {number} y */
  toScreen(x, y) {
    return [this.width / 2 + (x - this.x) * this.scale, this.height / 2 - (y - this.y) * this.scale];
  }

  /** @param {number} left
   * @param {number} top */
  toWorld(left, top) {
    return [this.x + (left - this.width / 2) / this.scale, this.y - (top - this.height / 2) / this.scale];
  }

  /** This camera, moved by less than a pixel so that pictures of the world at one scale differ by whole device pixels, and as
   * much more around it as `margin` says [device pixels].
   * @param {number} ratio device pixels a CSS pixel
   * @param {number[]} margin to the left and right, above and below */
  onPixels(ratio, [beside, above] = [0, 0]) {
    const k = this.scale * ratio;
    const found = new Camera();
    [found.x, found.y, found.scale] = [Math.round(this.x * k) / k, Math.round(this.y * k) / k, this.scale];
    found.resize(this.width + (2 * beside) / ratio, this.height + (2 * above) / ratio);
    return found;
  }

  /** Put the world's metres on a canvas: after this, draw in metres with y upwards.
   * @param {CanvasRenderingContext2D} context
   * @param {number} ratio */
  apply(context, ratio) {
    const k = this.scale * ratio;
    context.setTransform(k, 0, 0, -k, (ratio * this.width) / 2 - this.x * k, (ratio * this.height) / 2 + this.y * k);
  }

  /** @param {number} width
   * @param {number} height */
  resize(width, height) {
    this.width = width;
    this.height = height;
  }

  /** See all of `[x0, y0, x1, y1]`, with a margin.
   * @param {number[]} extent */
  fit([x0, y0, x1, y1], margin = 24) {
    const wide = Math.max(this.width - 2 * margin, 10) / Math.max(x1 - x0, 1e-3);
    const high = Math.max(this.height - 2 * margin, 10) / Math.max(y1 - y0, 1e-3);
    this.scale = Math.min(NEAREST, Math.max(FARTHEST, Math.min(wide, high)));
    this.centre((x0 + x1) / 2, (y0 + y1) / 2);
  }

  /** @param {number} x
   * @param {number} y */
  centre(x, y) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) return;
    this.x = x;
    this.y = y;
    this.changed();
  }

  /** Zoom by a factor; the world point under (left, top) stays where it is.
   * @param {number} factor */
  zoom(factor, left = this.width / 2, top = this.height / 2) {
    const [x, y] = this.toWorld(left, top);
    this.scale = Math.min(NEAREST, Math.max(FARTHEST, this.scale * factor));
    this.x = x - (left - this.width / 2) / this.scale;
    this.y = y + (top - this.height / 2) / this.scale;
    this.changed();
  }

  /** Move what is seen by so many pixels.
   * @param {number} right
   * @param {number} down */
  pan(right, down) {
    this.centre(this.x - right / this.scale, this.y + down / this.scale);
  }

  /** The part of the world that is seen, `[x0, y0, x1, y1]`. */
  bounds() {
    const [x0, y1] = this.toWorld(0, 0);
    const [x1, y0] = this.toWorld(this.width, this.height);
    return [x0, y0, x1, y1];
  }
}
