// What the robot has mapped: the growing map, the scan that was matched, and the pose graph, each with a switch.

import { coloured } from "../shared/world_marks.js";
import { SceneLayer } from "../shared/world.js";
import { Asked } from "./asked.js";

/** @typedef {import("../shared/layer.js").Brush} Brush */
/** @typedef {{estimator: string, map: {extent: number[], png: string} | null, scan: number[][] | null, poses: number[][] | null, edges: number[][] | null}} One */

const SWITCHES = [
  ["map", "map", "the map that its estimators have drawn"],
  ["scan", "matched scan", "the last scan, where its estimator lays it"],
  ["poses", "graph", "the pose graph: key poses, and what links them"],
];
const DOT = 2; // pixels

/**
 * What was mapped, as it came last, and the switches.
 * @extends {Asked<One[]>}
 */
export class Mapped extends Asked {
  /**
   * @param {(command: object) => Promise<any>} ask
   * @param {() => void} changed
   */
  constructor(ask, changed) {
    const look = async (/** @type {number} */ robot) => {
      const said = await ask({ do: "mapped", robot });
      return { ok: said.ok, found: said.mapped };
    };
    super(look, changed, { every: 700, label: "what is drawn of its map", switches: SWITCHES, nothing: [] });
    /** @type {Map<string, {png: string, image: HTMLImageElement, extent: number[], shades: Map<string, HTMLCanvasElement>}>} */
    this.images = new Map();
  }

  /** @override @param {string} name */
  has(name) {
    return this.found.some((one) => /** @type {any} */ (one)[name]);
  }

  /** An estimator maps from its start, or never. @override @param {One[]} found */
  isNever(found) {
    return !found.length;
  }

  /** @override @param {One[]} found */
  set(found) {
    super.set(found);
    for (const one of found) this.load(one);
  }

  /** The picture of a map; the one before is shown until it has come.
   * @param {One} one */
  load({ estimator, map }) {
    if (!map?.png || this.images.get(estimator)?.png === map.png) return;
    const image = new Image();
    image.onload = () => {
      this.images.set(estimator, { png: map.png, image, extent: map.extent, shades: new Map() });
      this.changed();
    };
    image.src = `data:image/png;base64,${map.png}`;
  }

  /** The maps that have come: where they lie, and their pictures in a colour.
   * @param {string} colour */
  maps(colour) {
    return this.found.flatMap(({ estimator, map }) => {
      const had = map && this.images.get(estimator);
      if (!had) return [];
      const picture = had.shades.get(colour) ?? coloured(had.image, colour);
      had.shades.set(colour, picture);
      return [{ extent: had.extent, picture }];
    });
  }
}

/**
 * Draws it. Of several maps, the first: that is the one of the estimator that the controller follows, or the nearest to it.
 * @extends {SceneLayer<import("./stage.js").Stage>}
 */
export class MappedLayer extends SceneLayer {
  get isShown() {
    return super.isShown && this.stage.mapped.found.length > 0;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { mapped } = this.stage;
    const [map] = mapped.shows.map ? mapped.maps(theme.estimated) : [];
    if (map) {
      const [x0, y0, x1, y1] = map.extent;
      context.save();
      context.translate(x0, y1);
      context.scale(1, -1);
      context.imageSmoothingEnabled = false;
      context.drawImage(map.picture, 0, 0, x1 - x0, y1 - y0);
      context.restore();
    }
    for (const { scan, poses, edges } of mapped.found) {
      if (poses && mapped.shows.poses) drawGraph(context, camera, theme, poses, edges ?? []);
      if (scan && mapped.shows.scan) drawPoints(context, camera, theme.measured, scan);
    }
  }
}

/** @param {CanvasRenderingContext2D} context
 * @param {import("../shared/world_marks.js").Scaled} camera
 * @param {string} colour
 * @param {number[][]} points */
function drawPoints(context, camera, colour, points) {
  const size = DOT / camera.scale;
  context.fillStyle = colour;
  for (const [x, y] of points) context.fillRect(x - size / 2, y - size / 2, size, size);
}

/** @param {CanvasRenderingContext2D} context
 * @param {import("../shared/world_marks.js").Scaled} camera
 * @param {import("../shared/theme.js").Theme} theme
 * @param {number[][]} poses
 * @param {number[][]} edges */
function drawGraph(context, camera, theme, poses, edges) {
  context.strokeStyle = theme.estimated;
  context.lineWidth = 1 / camera.scale;
  context.beginPath();
  for (const [a, b] of edges) {
    if (!poses[a] || !poses[b]) continue;
    context.moveTo(poses[a][0], poses[a][1]);
    context.lineTo(poses[b][0], poses[b][1]);
  }
  context.stroke();
  drawPoints(context, { scale: camera.scale / 2 }, theme.estimated, poses);
}
