// A scenario at rest on one canvas: what can be drawn of it without a simulation. For pages that show a file, not a run.

import { Camera } from "./camera.js";
import { Canvas } from "./canvas.js";
import { fixed } from "./dom.js";
import { GridLayer } from "./ground.js";
import { reach, trace } from "./footprint.js";
import { drawRobot } from "./marks.js";
import { NEAR, WorldPicker, at } from "./pick.js";
import { Pictures } from "./pictures.js";
import { readScene } from "./scene.js";
import { Selection } from "./selection.js";
import { Sight } from "./sight.js";
import { readTheme } from "./theme.js";
import { Hand } from "./tool.js";
import { BodiesLayer, NamesLayer, SceneLayer, SelectionLayer, WorldLayer } from "./world.js";

/** @typedef {import("../simulator/messages.d.ts").Still} Still */
/** @typedef {import("./pick.js").Found} Found */

const HELP = "Drag or Shift and arrows pan, plus and minus zoom, 0 shows all, Enter tells what is in the middle.";

const numbersOf = (/** @type {(number[] | null)[]} */ poses) => Float64Array.from(poses.flatMap((pose) => pose ?? [NaN, NaN, NaN]));

/** A moment in which all stands where it starts: what layers need of a frame. Bodies without a place are nowhere.
 * @param {Still} still */
export function stillFrame(still) {
  const truePoses = numbersOf(still.robots);
  return {
    truePoses,
    estimatedPoses: truePoses,
    obstacles: numbersOf(still.obstacles),
    flags: new Uint8Array(still.robots.length),
    selected: Math.max(0, still.robots.findIndex((pose) => pose !== null)),
    sensors: [],
    tick: 0,
  };
}

/** A layer of what does not move here: it is drawn into the bitmap.
 * @template {SceneLayer} T
 * @param {T} layer */
export function atRest(layer) {
  layer.isStatic = true;
  return layer;
}

/** The robot that is selected, which `BodiesLayer` leaves out. */
export class StillRobotLayer extends SceneLayer {
  /** @param {import("./layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { scene, frame } = this.stage;
    const robot = scene.robots[frame.selected];
    if (robot) drawRobot(context, camera, robot, frame.truePoses, frame.selected, "true", theme, false);
  }
}

/**
 * Bodies of which only the outline can be read, dashed.
 * @extends {SceneLayer<StillStage>}
 */
class OutlinesLayer extends SceneLayer {
  /** @param {import("./layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    context.beginPath();
    for (const { footprint, pose } of this.stage.still?.outlines ?? []) trace(context, footprint, pose[0], pose[1], pose[2]);
    context.strokeStyle = theme.danger;
    context.lineWidth = 1.5 / camera.scale;
    context.setLineDash([5 / camera.scale, 4 / camera.scale]);
    context.stroke();
    context.setLineDash([]);
  }
}

/** Finds robots, obstacles, outlines and what stands in the world. */
class StillPicker extends WorldPicker {
  /** @param {Still} still
   * @param {ReturnType<typeof stillFrame>} frame
   * @param {{x: number, y: number, scale: number}} point
   * @returns {Found | null} */
  pick(still, frame, { x, y, scale }) {
    const near = NEAR / scale;
    const i = this.nearestRobot(frame, "true", x, y, near, 1);
    if (i >= 0) {
      const { name, model } = this.scene.robots[i];
      return { kind: "robot", key: name, robot: i, title: name, lines: [model || "robot", at(frame.truePoses, i)] };
    }
    const outline = still.outlines.find(({ footprint, pose }) => Math.hypot(pose[0] - x, pose[1] - y) <= Math.max(reach(footprint), near));
    if (outline) {
      const [u, v] = outline.pose;
      return { kind: "outline", key: outline.name, title: outline.name, lines: ["its faults let only its outline be drawn", `x ${fixed(u, 3)} m, y ${fixed(v, 3)} m`] };
    }
    return this.nearestObstacle(frame, x, y, near) ?? this.world.nearest(x, y, near);
  }
}

export class StillStage {
  /**
   * @param {HTMLElement} root
   * @param {{id: string, label: string, picked: (place: import("./tool.js").Place) => void}} what
   */
  constructor(root, { id, label, picked }) {
    this.camera = new Camera();
    this.camera.changed = () => this.redraw();
    this.theme = readTheme(root);
    this.picked = picked;
    this.options = { grid: true };
    this.pictures = new Pictures(() => this.pictureCame());
    this.picker = new StillPicker();
    /** @type {Selection<Found>} */
    this.selection = new Selection();
    this.selection.listen(() => this.touch());
    this.sight = new Sight(this);
    this.looks = 0; // how often what stands still has come to look otherwise
    this.pane = new Canvas({ id, label: `${label}. ${HELP}`, camera: this.camera, theme: this.theme });
    this.pane.layers = [
      new GridLayer(() => this.options.grid && this.still !== undefined), new WorldLayer(this),
      ...[new BodiesLayer(this), new StillRobotLayer(this), new OutlinesLayer(this), new SelectionLayer(this, "true"), new NamesLayer(this, "true")].map(atRest),
    ];
    const hand = new Hand(this.camera, { clicked: (place) => this.pick(place) });
    this.pane.panning = hand;
    this.pane.take(hand);
    this.pane.canvas.addEventListener("dblclick", (event) => this.doubleClicked(event));
    root.addEventListener("theme", () => {
      this.pane.theme = this.theme = readTheme(root);
      this.redraw();
    });
    new ResizeObserver(() => this.resize()).observe(this.pane.element);
  }

  /** Show a scenario in place of the one before; null shows nothing. The camera stays if the same is in sight.
   * @param {Still | null} still
   * @param {(name: string) => Promise<string | null>} pictureOf the address of a map's picture */
  show(still, pictureOf) {
    const before = this.still?.extent;
    const keeps = this.sight.keeps(still) && before;
    this.still = still;
    this.scene = still && readScene(still.scene);
    this.frame = still && stillFrame(still);
    this.pictures.reset(pictureOf);
    this.selection.clear();
    if (still) this.picker.setScene(this.scene, still.extent);
    const isSame = before && still && before.every((value, n) => value === still.extent[n]);
    this.resize();
    if (!isSame && !keeps) this.fit();
    this.touch();
  }

  /** What the bitmap of what stands still depends on. */
  get version() {
    return String(this.looks);
  }

  /** Draw what stands still again. */
  touch() {
    this.looks += 1;
    this.redraw();
  }

  /** A map's picture is there. */
  pictureCame() {
    this.redraw();
  }

  posesOf() {
    return this.frame?.truePoses ?? [];
  }

  /** @param {import("./tool.js").Place} place */
  pick(place) {
    if (!this.still || !this.frame) return;
    const found = this.picker.pick(this.still, this.frame, { x: place.x, y: place.y, scale: this.camera.scale });
    this.selection.set(found ? [found] : []);
    this.picked(place);
  }

  /** @param {MouseEvent} _event */
  doubleClicked(_event) {
    this.fit();
  }

  fit() {
    if (this.still) this.camera.fit(this.still.extent);
    const { x, y, scale } = this.camera;
    this.fitted = [x, y, scale];
  }

  resize() {
    const { camera } = this;
    const wasFitted = !this.fitted || [camera.x, camera.y, camera.scale].every((part, n) => part === this.fitted?.[n]);
    const before = [camera.width, camera.height];
    const [width, height] = this.pane.resize();
    camera.resize(width, height);
    if (width !== before[0] || height !== before[1]) this.sight.resized(before, wasFitted);
    this.redraw();
  }

  redraw() {
    this.asked ||= requestAnimationFrame(() => {
      this.asked = 0;
      this.pane.draw();
    });
  }
}
