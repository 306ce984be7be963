// A picture under the world to trace a floor plan from: its place, its scale by two points, how strong it is.
// It is kept by this browser, and is not part of the scenario.

import { open } from "../shared/dialogs.js";
import { h, say, context2d, there } from "../shared/dom.js";
import { numberIn } from "../shared/field.js";
import { Layer } from "../shared/layer.js";
import { DrawTool } from "./draw_tools.js";

const WIDEST = 1600; // pixels of what is kept
const KEPT = "amorsim-underlay ";

/** The picture, in the world: its lower left corner [m], metres a pixel, and its opacity. */
export class UnderlayLayer extends Layer {
  isStatic = true;

  constructor() {
    super();
    /** @type {HTMLImageElement | null} */
    this.image = null;
    this.place = { x: 0, y: 0, scale: 0.01, opacity: 0.5 };
  }

  get isShown() {
    return this.image !== null;
  }

  get version() {
    return this.place; // another object whenever it, or the picture, changes
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context }) {
    const image = there(this.image);
    const { place } = this;
    context.save();
    context.globalAlpha = place.opacity;
    context.translate(place.x, place.y);
    context.scale(place.scale, -place.scale);
    context.drawImage(image, 0, -image.height);
    context.restore();
  }
}

const keyOf = (/** @type {import("./editor.js").EditorPage} */ page) => `${KEPT}${page.state.folder}/${page.state.name}`;

/** @param {import("./editor.js").EditorPage} page */
function keep(page) {
  const { image, place } = page.stage.underlay;
  try {
    if (image) localStorage.setItem(keyOf(page), JSON.stringify({ src: image.src, place }));
    else localStorage.removeItem(keyOf(page));
  } catch {
    page.hint("the browser has no space left for the picture; it is lost when you reload the page");
  }
}

/** @param {import("./editor.js").EditorPage} page
 * @param {string} src
 * @param {any} place */
function show(page, src, place) {
  const image = new Image();
  image.onload = () => {
    const { underlay } = page.stage;
    underlay.image = image;
    underlay.place = place ?? { ...underlay.place, scale: 10 / image.width };
    page.stage.redraw();
    keep(page);
  };
  image.onerror = () => page.hint("the browser cannot read this file as a picture");
  image.src = src;
}

/** Take up the picture of before. @param {import("./editor.js").EditorPage} page */
export function takeUp(page) {
  try {
    const kept = JSON.parse(localStorage.getItem(keyOf(page)) ?? "null");
    if (kept) show(page, kept.src, kept.place);
  } catch {
    localStorage.removeItem(keyOf(page));
  }
}

/** A file as an address that can be kept, in at most so many pixels.
 * @param {File} file */
async function addressOf(file) {
  const picture = await createImageBitmap(file);
  const scale = Math.min(1, WIDEST / Math.max(picture.width, picture.height));
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [Math.round(picture.width * scale), Math.round(picture.height * scale)];
  context2d(canvas).drawImage(picture, 0, 0, canvas.width, canvas.height);
  return canvas.toDataURL("image/png");
}

/** Two points of the picture, and how far apart they really are.
 * Moves the picture so that the first stays where it is. */
class ScaleTool extends DrawTool {
  get says() {
    return this.points.length ? "Click the second point." : "Click a point of the picture whose distance to another you know.";
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  snapped({ x, y }) {
    return { x, y, kind: "" };
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  about(mark) {
    const [from] = this.points;
    return from ? { walls: [[...from, mark.x, mark.y]], words: `now ${Math.hypot(mark.x - from[0], mark.y - from[1]).toFixed(2)} m`, at: [mark.x, mark.y] } : {};
  }

  /** @param {import("./draw_tools.js").Mark} mark */
  point({ x, y }) {
    if (!this.points.length) {
      this.points = [[x, y]];
      this.page.showTool(this);
      return;
    }
    const [[u, v]] = this.points;
    const now = Math.hypot(x - u, y - v);
    this.cancel();
    this.page.take("select");
    if (now > 0) askDistance(this.page, [u, v], now);
  }
}

/** @param {import("./editor.js").EditorPage} page
 * @param {number[]} point
 * @param {any} now */
function askDistance(page, [x, y], now) {
  const problem = h("p", { class: "error", role: "alert" });
  const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: now.toFixed(2) });
  const set = () => {
    const distance = numberIn(input.value);
    if (!(distance > 0)) {
      say(problem, "Expected a distance in metres.");
      return;
    }
    const { underlay } = page.stage;
    const factor = distance / now;
    const { place } = underlay;
    underlay.place = { ...place, x: x + (place.x - x) * factor, y: y + (place.y - y) * factor, scale: place.scale * factor };
    page.stage.redraw();
    keep(page);
    dialog.close();
  };
  const dialog = open("Scale of the picture", h("div", {}, h("label", { class: "asked" }, h("span", {}, "distance of the two points"), input, h("span", { class: "unit" }, "m")), problem), [
    h("button", { onclick: () => dialog.close() }, "cancel"), h("button", { class: "main", onclick: set }, "set"),
  ]);
  input.select();
}

/** The picture under the world: chosen, moved, scaled, made weaker, taken away.
 * @param {import("./editor.js").EditorPage} page */
export function askUnderlay(page) {
  const { underlay } = page.stage;
  const file = h("input", { type: "file", accept: "image/*", "aria-label": "picture", onchange: async () => {
    const [one] = file.files ?? [];
    if (one) show(page, await addressOf(one).catch(() => ""), null);
  } });
  const change = (/** @type {object} */ part) => {
    underlay.place = { ...underlay.place, ...part };
    page.stage.redraw();
    keep(page);
  };
  const number = (/** @type {string} */ name, /** @type {string} */ label) => {
    const input = h("input", { type: "text", inputmode: "decimal", autocomplete: "off", value: String(Math.round(/** @type {any} */ (underlay.place)[name] * 1e4) / 1e4), onchange: () => {
      const value = numberIn(input.value);
      if (Number.isFinite(value)) change({ [name]: value });
    } });
    return h("label", { class: "asked" }, h("span", {}, label), input, h("span", { class: "unit" }, "m"));
  };
  const opacity = h("input", { type: "range", min: "0.05", max: "1", step: "0.05", oninput: () => change({ opacity: Number(opacity.value) }) });
  opacity.value = String(underlay.place.opacity);
  const dialog = open("A picture under the world", h("div", {}, h("p", { class: "note" }, "To trace a floor plan. It is kept by this browser alone, and is not part of the scenario."), h("p", {}, file),
    h("label", { class: "asked" }, h("span", {}, "opacity"), opacity), number("x", "left edge"), number("y", "lower edge")), [
    h("button", { onclick: () => {
      underlay.image = null;
      keep(page);
      page.stage.redraw();
      dialog.close();
    } }, "take away"),
    h("button", { onclick: () => {
      dialog.close();
      page.hold(new ScaleTool(page), "scale");
    } }, "scale by two points"),
    h("button", { class: "main", onclick: () => dialog.close() }, "done"),
  ]);
}
