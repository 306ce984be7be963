// The Simulator's layers: what is true of the world, what the selected robot knows, and what is written over both.

import { Layer } from "../shared/layer.js";
import {
  drawBelievedParts, drawEllipse, drawFloor, drawMap, drawMarks, drawObstacles, drawRobot, drawTrail,
} from "../shared/marks.js";
import { drawCrowd } from "./crowd.js";
import { drawNames } from "./names.js";
import { drawReadings, isDrawn } from "./readings.js";

/** @typedef {import("../shared/layer.js").Brush} Brush */
/** @typedef {"true" | "estimated"} View what a pane shows: the world as it is, or as the robot knows it */

/** A layer of the stage's scene and newest frame. */
class SceneLayer extends Layer {
  /** @param {import("./stage.js").Stage} stage */
  constructor(stage) {
    super();
    this.stage = stage;
  }

  get isShown() {
    return Boolean(this.stage.scene && this.stage.frame);
  }

  /** The robot that is looked at. */
  get robot() {
    return this.stage.scene.robots[this.stage.frame.selected];
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
    drawMap(context, camera, scene.map, pictures.path(scene.map), pictures.of(scene.map, theme.wall), theme.wall);
    drawFloor(context, camera, scene.floor, theme);
  }
}

/** The map and the landmarks that the robot knows. */
export class KnownLayer extends SceneLayer {
  isStatic = true;

  get version() {
    return `${this.stage.pictures.version} ${this.stage.frame.selected}`;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { robot, stage } = this;
    if (!robot) return;
    const [map, shade] = [robot.knowledge, theme["known-wall"]];
    if (map) drawMap(context, camera, map, stage.pictures.path(map), stage.pictures.of(map, shade), shade);
    drawMarks(context, camera, robot.landmarks, shade);
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

/** The robot that is looked at, where it is or believes to be, with its readings and its path. */
export class RobotLayer extends SceneLayer {
  /** @param {import("./stage.js").Stage} stage
   * @param {View} view */
  constructor(stage, view) {
    super(stage);
    this.view = view;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { robot, stage, view } = this;
    if (!robot) return;
    const { frame, options } = stage;
    const [isTrue, i] = [view === "true", frame.selected];
    const poses = stage.posesOf(view);
    const pose = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    if (options.trails) drawTrail(context, camera, isTrue ? stage.trueTrail : stage.estimatedTrail, view, theme);
    robot.sensors.forEach((sensor, s) => {
      if (!isDrawn(sensor) || stage.hidden.has(sensor.name) || !frame.sensors[s]) return;
      const values = isTrue ? frame.sensors[s].true : frame.sensors[s].measured;
      const shape = isTrue ? (stage.trueSensors[s] ?? sensor) : sensor;
      drawReadings({ context, camera, theme, kind: isTrue ? "true" : "measured" }, shape, pose, values);
    });
    if (!isTrue) {
      if (options.ellipse) drawEllipse(context, camera, pose, Array.from(frame.covariances.subarray(6 * i, 6 * i + 6)), theme);
      drawBelievedParts(context, camera, robot.parts, frame.believedParts, theme);
    }
    drawRobot(context, camera, robot, poses, i, view, theme, isTrue && Boolean(frame.flags[i] & 1));
  }
}

/** A cross where an event happened. */
export class MarkLayer extends SceneLayer {
  get isShown() {
    const { mark, frame } = this.stage;
    return Boolean(super.isShown && mark && frame.tick >= mark.tick);
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const [x, y] = this.stage.mark.point;
    const size = 9 / camera.scale;
    context.strokeStyle = theme.danger;
    context.lineWidth = 2.5 / camera.scale;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(x - size, y - side * size);
      context.lineTo(x + size, y + side * size);
    }
    context.stroke();
  }
}

/** What is selected of one view, where it is not a robot or a reading, which show themselves. */
export class SelectionLayer extends SceneLayer {
  /** @param {import("./stage.js").Stage} stage
   * @param {View} view */
  constructor(stage, view) {
    super(stage);
    this.view = view;
  }

  get things() {
    return this.stage.selection.things.filter((thing) => thing.view === this.view);
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

/** Names beside robots: of the others only where the world is shown, for a robot knows nothing of them. */
export class NamesLayer extends SceneLayer {
  /** @type {"pane"} */
  space = "pane";

  /** @param {import("./stage.js").Stage} stage
   * @param {View} view */
  constructor(stage, view) {
    super(stage);
    this.view = view;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { scene, frame } = this.stage;
    drawNames(context, camera, scene.robots, this.stage.posesOf(this.view), frame.selected, this.view !== "true", theme);
  }
}
