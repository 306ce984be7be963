// Layers of a scene that every page draws alike: walls and floor, bodies where they truly are, what is selected, names.

import { drawCrowd } from "./crowd.js";
import { Layer } from "./layer.js";
import { drawObstacles } from "./marks.js";
import { drawNames } from "./names.js";
import { drawFloor, drawMap, drawStanding } from "./world_marks.js";

/** @typedef {import("./layer.js").Brush} Brush */
/** @typedef {"true" | "estimated"} View what a pane shows: the world as it is, or as the robot knows it */

/**
 * What layers draw from: a page's scene and the newest frame of it, with the pictures of its maps. `version` differs
 * whenever static layers look otherwise.
 * @typedef {{
 *   scene?: any,
 *   frame?: any,
 *   version?: string,
 *   pictures: import("./pictures.js").Pictures,
 *   selection: import("./selection.js").Selection<any>,
 *   posesOf: (view: View) => ArrayLike<number>,
 * }} Sight
 */

/**
 * A layer of a scene and its newest frame.
 * @template {Sight} [T=Sight]
 */
export class SceneLayer extends Layer {
  /** @param {T} stage */
  constructor(stage) {
    super();
    this.stage = stage;
  }

  get isShown() {
    return Boolean(this.stage.scene && this.stage.frame);
  }

  get version() {
    return this.stage.version ?? "";
  }

  /** The robot that is looked at. */
  get robot() {
    return this.stage.scene.robots[this.stage.frame.selected];
  }
}

/**
 * A layer that shows one of the views.
 * @template {Sight} [T=Sight]
 * @extends {SceneLayer<T>}
 */
export class ViewLayer extends SceneLayer {
  /** @param {T} stage
   * @param {View} view */
  constructor(stage, view) {
    super(stage);
    this.view = view;
  }
}

/** Walls and floor, as they are. */
export class WorldLayer extends SceneLayer {
  isStatic = true;

  get version() {
    return String(this.stage.pictures.version);
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { scene, pictures } = this.stage;
    drawFloor(context, camera, scene.floor, theme);
    drawMap(context, camera, scene.map, pictures.path(scene.map), pictures.of(scene.map, theme.wall), theme.wall);
    drawStanding(context, camera, scene.floor, theme);
  }
}

/** Obstacles and parts of robots, and all robots but the one that is looked at, where they are. */
export class BodiesLayer extends SceneLayer {
  /** @param {Brush} brush */
  draw({ context, camera, ratio, theme }) {
    const { scene, frame } = this.stage;
    drawObstacles(context, camera, scene.obstacles, frame.obstacles, theme);
    drawCrowd(context, camera, ratio, scene.robots, frame.truePoses, frame.selected, theme);
  }
}

/** What is selected of one view, where it is not a robot or a reading, which show themselves. */
export class SelectionLayer extends ViewLayer {
  get things() {
    return this.stage.selection.things.filter((/** @type {import("./pick.js").Found} */ thing) => thing.view === this.view);
  }

  get isShown() {
    return super.isShown && this.things.length > 0;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    context.strokeStyle = theme.estimated;
    context.lineWidth = 4 / camera.scale;
    context.beginPath();
    for (const { line, point } of this.things) {
      if (line) {
        context.moveTo(line[0], line[1]);
        context.lineTo(line[2], line[3]);
      } else if (point) {
        const reach = 9 / camera.scale;
        context.moveTo(point[0] + reach, point[1]);
        context.arc(point[0], point[1], reach, 0, 2 * Math.PI);
      }
    }
    context.stroke();
  }
}

/** Names next to robots: of the others only where the world is shown, for a robot knows nothing of them. */
export class NamesLayer extends ViewLayer {
  /** @type {"pane"} */
  space = "pane";

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { scene, frame } = this.stage;
    drawNames(context, camera, scene.robots, this.stage.posesOf(this.view), frame.selected, this.view !== "true", theme);
  }
}
