// Layers of a canvas. What stands still is drawn once into a bitmap, which is shifted while the camera moves.

/**
 * What a layer draws with: `context` is set to the world's metres with y upwards, or to CSS pixels where the layer's
 * `space` is "pane".
 * @typedef {{
 *   context: CanvasRenderingContext2D,
 *   camera: import("./camera.js").Camera,
 *   ratio: number,
 *   theme: import("./theme.js").Theme,
 * }} Brush
 */

/** Something that a canvas shows, above the layers before it. */
export class Layer {
  /** @type {"world" | "pane"} */
  space = "world";

  /** Whether it is the same from frame to frame: then it is drawn again only where `version` differs. */
  isStatic = false;

  get isShown() {
    return true;
  }

  /** What a static layer depends on besides the camera and the theme.
   * @returns {unknown} */
  get version() {
    return "";
  }

  /** @param {Brush} _brush */
  draw(_brush) {}
}

/**
 * @param {Layer} layer
 * @param {Brush} brush
 */
export function drawLayer(layer, brush) {
  const { context, camera, ratio } = brush;
  if (layer.space === "world") camera.apply(context, ratio);
  else context.setTransform(ratio, 0, 0, ratio, 0, 0);
  layer.draw(brush);
}

const MARGIN = 0.25; // of the canvas's width and height, which a bitmap has more on each side

/** Static layers that lie on one another, in one bitmap that is larger than the canvas. */
export class Bitmap {
  constructor() {
    this.canvas = document.createElement("canvas");
    /** @type {unknown[]} */
    this.key = [];
    /** The camera that it was drawn with; null before. @type {import("./camera.js").Camera | null} */
    this.camera = null;
    this.drawings = 0; // how often it was drawn
  }

  /**
   * Draw the layers on a canvas of this size in device pixels. What changes is drawn as it is; the bitmap is made when
   * the same is wanted a second time, and again when the camera has left its margin.
   * @param {Layer[]} layers
   * @param {Brush} brush
   * @param {HTMLCanvasElement} size
   * @param {boolean} isGround whether they lie on the paper, and not on other layers
   */
  draw(layers, brush, size, isGround) {
    const { camera, theme, ratio } = brush;
    const key = [camera.scale, size.width, size.height, ratio, theme, ...layers, ...layers.map((layer) => layer.version)];
    const isSame = key.length === this.key.length && key.every((part, n) => part === this.key[n]);
    this.key = key;
    if (!isSame) {
      this.camera = null;
      paint(layers, brush, size, isGround);
      return;
    }
    const margin = [Math.ceil(MARGIN * size.width), Math.ceil(MARGIN * size.height)];
    let shift = this.shift(brush);
    if (!this.camera || shift.some((part, n) => Math.abs(part) > margin[n])) {
      this.make(layers, brush, [size.width + 2 * margin[0], size.height + 2 * margin[1]], margin, isGround);
      shift = [0, 0];
    }
    brush.context.setTransform(1, 0, 0, 1, 0, 0);
    brush.context.drawImage(this.canvas, shift[0] - margin[0], shift[1] - margin[1]);
  }

  /** How far it lies from where the camera sees it now, in device pixels to the right and down.
   * @param {Brush} brush */
  shift({ camera, ratio }) {
    if (!this.camera) return [0, 0];
    const k = camera.scale * ratio;
    return [Math.round((this.camera.x - camera.x) * k), Math.round((camera.y - this.camera.y) * k)];
  }

  /**
   * @param {Layer[]} layers
   * @param {Brush} brush
   * @param {number[]} size
   * @param {number[]} margin
   * @param {boolean} isGround
   */
  make(layers, brush, [width, height], margin, isGround) {
    this.canvas.width = width; // which clears it
    this.canvas.height = height;
    const context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d", { alpha: !isGround }));
    this.camera = brush.camera.onPixels(brush.ratio, margin);
    paint(layers, { ...brush, context, camera: this.camera }, this.canvas, isGround);
    this.drawings += 1;
  }
}

/**
 * @param {Layer[]} layers
 * @param {Brush} brush
 * @param {HTMLCanvasElement} size
 * @param {boolean} isGround
 */
function paint(layers, brush, size, isGround) {
  if (isGround) {
    brush.context.setTransform(1, 0, 0, 1, 0, 0);
    brush.context.fillStyle = brush.theme.paper;
    brush.context.fillRect(0, 0, size.width, size.height);
  }
  for (const layer of layers) drawLayer(layer, brush);
}
