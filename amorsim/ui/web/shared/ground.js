// Layers that every page has: the grid of round distances.

import { niceStep } from "./dom.js";
import { Layer } from "./layer.js";
import { drawGrid } from "./world_marks.js";

const LEAST = 40; // pixels between two lines

export class GridLayer extends Layer {
  isStatic = true;

  /** @param {() => boolean} isWanted */
  constructor(isWanted) {
    super();
    this.isWanted = isWanted;
  }

  get isShown() {
    return this.isWanted();
  }

  /** @param {import("./layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    drawGrid(context, camera, niceStep(LEAST / camera.scale), theme.grid);
  }
}
