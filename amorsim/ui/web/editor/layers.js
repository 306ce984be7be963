// Layers of the Editor's canvas: the marks of what is selected, and what a tool is about to do.

import { there } from "../shared/dom.js";
import { reach, trace } from "../shared/footprint.js";
import { SceneLayer } from "../shared/world.js";
import { boxOf } from "./geometry.js";
import { turnHandle, wallHandles } from "./grips.js";

const MOST_DASHED = 50; // boxes: dashes take long to draw

/**
 * Boxes about what is selected, and rings about what has faults: of things that are being dragged, or of all others.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class MarksLayer extends SceneLayer {
  /** @param {import("./stage.js").EditStage} stage
   * @param {boolean} isDragged */
  constructor(stage, isDragged) {
    super(stage);
    this.isDragged = isDragged;
  }

  get isShown() {
    return !this.isDragged || this.stage.moved.size > 0;
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { stage } = this;
    const px = 1 / camera.scale;
    const isMine = (/** @type {any} */ { path }) => stage.moved.has(path) === this.isDragged;
    context.lineWidth = 1.5 * px;
    context.strokeStyle = theme.estimated;
    const chosen = stage.chosenThings.filter(isMine);
    context.setLineDash(chosen.length > MOST_DASHED ? [] : [5 * px, 3 * px]);
    context.beginPath();
    for (const thing of chosen) {
      const pose = stage.poseOf(thing);
      if (!pose) continue;
      const [x0, y0, x1, y1] = boxOf(there(thing.footprint), pose);
      context.rect(x0 - 4 * px, y0 - 4 * px, x1 - x0 + 8 * px, y1 - y0 + 8 * px);
      const isBody = thing.robots.length + thing.obstacles.length > 0;
      if (this.isDragged && !isBody) trace(context, there(thing.footprint), pose[0], pose[1], pose[2]); // a zone, a landmark, a lamp
    }
    context.stroke();
    context.setLineDash([]);
    context.strokeStyle = theme.danger;
    context.lineWidth = 2 * px;
    context.beginPath();
    for (const thing of stage.things.filter(isMine)) {
      const pose = thing.faults && thing.footprint && !stage.hidden.has(thing.kind) ? stage.poseOf(thing) : null;
      if (!pose) continue;
      const far = reach(thing.footprint) + 7 * px;
      context.moveTo(pose[0] + far, pose[1]);
      context.arc(pose[0], pose[1], far, 0, 2 * Math.PI);
    }
    context.stroke();
  }
}

/**
 * What a tool is about to do, and what of the selected things can be taken hold of.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class PreviewLayer extends SceneLayer {
  get isShown() {
    return true;
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { stage } = this;
    const px = 1 / camera.scale;
    context.strokeStyle = theme.estimated;
    for (const { cells } of stage.strokes) drawCells(context, cells, theme);
    const preview = stage.preview;
    if (preview) {
      context.beginPath();
      for (const { footprint, pose } of preview.bodies ?? []) trace(context, footprint, pose[0], pose[1], pose[2]);
      for (const [a, b, c, d] of preview.walls ?? []) {
        context.moveTo(a, b);
        context.lineTo(c, d);
      }
      context.lineWidth = 2.5 * px;
      context.stroke();
      if (preview.cells) drawCells(context, preview.cells, theme);
      if (preview.box) {
        const [x0, y0, x1, y1] = preview.box;
        context.lineWidth = px;
        context.setLineDash([4 * px, 3 * px]);
        context.strokeRect(x0, y0, x1 - x0, y1 - y0);
        context.setLineDash([]);
      }
    }
    this.handles(context, px, theme);
    if (preview?.mark) {
      const { x, y, kind } = preview.mark;
      const side = kind === "grid" || !kind ? 3 * px : 6 * px;
      context.lineWidth = 2 * px;
      context.strokeStyle = theme.measured;
      context.strokeRect(x - side, y - side, 2 * side, 2 * side);
    }
  }

  /** @param {CanvasRenderingContext2D} context
   * @param {number} px
   * @param {import("../shared/theme.js").Theme} theme */
  handles(context, px, theme) {
    const { stage } = this;
    const handle = turnHandle(stage);
    if (handle) {
      context.beginPath();
      context.moveTo(handle.from[0], handle.from[1]);
      context.lineTo(handle.x, handle.y);
      context.lineWidth = 1.5 * px;
      context.strokeStyle = theme.estimated;
      context.stroke();
      context.beginPath();
      context.arc(handle.x, handle.y, 6 * px, 0, 2 * Math.PI);
      context.fillStyle = theme.estimated;
      context.fill();
    }
    for (const { x, y, shape } of stage.grips()) {
      context.beginPath();
      if (shape === "square") context.rect(x - 5 * px, y - 5 * px, 10 * px, 10 * px);
      else context.arc(x, y, (shape === "small" ? 3.5 : 6) * px, 0, 2 * Math.PI);
      context.fillStyle = shape === "small" ? theme.paper : theme.estimated;
      context.fill();
      context.lineWidth = 1.5 * px;
      context.strokeStyle = shape === "small" ? theme.estimated : theme.paper;
      context.stroke();
    }
    for (const [x, y] of wallHandles(stage)) {
      context.beginPath();
      context.arc(x, y, 6 * px, 0, 2 * Math.PI);
      context.fillStyle = theme.paper;
      context.fill();
      context.lineWidth = 2 * px;
      context.strokeStyle = theme.estimated;
      context.stroke();
    }
  }
}

/** The cells that a brush is about to change.
 * @param {CanvasRenderingContext2D} context
 * @param {any} cells
 * @param {import("../shared/theme.js").Theme} theme */
function drawCells(context, { spans, side, rows, x, y, heading, isOccupied, isFaint }, theme) {
  context.save();
  context.translate(x, y);
  context.rotate(heading);
  context.scale(side, side);
  context.globalAlpha = isFaint ? 0.4 : 1;
  context.fillStyle = isOccupied ? theme.wall : theme.paper;
  for (const [row, first, end] of spans) context.fillRect(first, rows - row - 1, end - first, 1);
  if (!isOccupied && isFaint) {
    context.fillStyle = theme.estimated;
    for (const [row, first, end] of spans) context.fillRect(first, rows - row - 1, end - first, 1);
  }
  context.restore();
}

/**
 * Words next to what is being drawn.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class WordsLayer extends SceneLayer {
  /** @type {"pane"} */
  space = "pane";

  get isShown() {
    return Boolean(this.stage.preview?.words);
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { words, at } = this.stage.preview;
    const [left, top] = camera.toScreen(at[0], at[1]);
    context.font = "600 13px system-ui, sans-serif";
    const wide = context.measureText(words).width;
    context.fillStyle = theme.paper;
    context.globalAlpha = 0.85;
    context.fillRect(left + 11, top - 24, wide + 8, 19);
    context.globalAlpha = 1;
    context.fillStyle = theme.estimated;
    context.fillText(words, left + 15, top - 10);
  }
}
