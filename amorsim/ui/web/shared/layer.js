// Layers of a canvas. What stands still is drawn once into a bitmap, and used again until the camera, the theme or it changes.

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

  /** What a static layer depends on besides the camera and the theme. */
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

/** Static layers that lie on one another, in one bitmap. */
export class Bitmap {
  constructor() {
    this.canvas = document.createElement("canvas");
    /** @type {unknown[]} */
    this.key = [];
    this.isDrawn = false;
    this.drawings = 0; // how often it was drawn
  }

  /**
   * Draw the layers on a canvas of this size in device pixels. While the camera moves they are drawn as they are; the
   * bitmap is made when the same is wanted a second time.
   * @param {Layer[]} layers
   * @param {Brush} brush
   * @param {HTMLCanvasElement} size
   * @param {boolean} isGround whether they lie on the paper, and not on other layers
   */
  draw(layers, brush, size, isGround) {
    const { camera, theme, ratio } = brush;
    const key = [camera.x, camera.y, camera.scale, size.width, size.height, ratio, theme, ...layers, ...layers.map((layer) => layer.version)];
    const isSame = key.length === this.key.length && key.every((part, n) => part === this.key[n]);
    this.key = key;
    if (!isSame) {
      this.isDrawn = false;
      paint(layers, brush, size, isGround);
      return;
    }
    if (!this.isDrawn) {
      this.canvas.width = size.width; // which clears it
      this.canvas.height = size.height;
      const context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d", { alpha: !isGround }));
      paint(layers, { ...brush, context }, size, isGround);
      this.isDrawn = true;
      this.drawings += 1;
    }
    brush.context.setTransform(1, 0, 0, 1, 0, 0);
    brush.context.drawImage(this.canvas, 0, 0);
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
