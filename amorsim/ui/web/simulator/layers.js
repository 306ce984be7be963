// The Simulator's own layers: what the selected robot knows, its readings and path, and where an event happened.

import { there } from "../shared/dom.js";
import { drawCloud, drawHypotheses } from "../shared/cloud.js";
import { trace } from "../shared/footprint.js";
import { drawBelievedParts, drawEllipse, drawRobot, drawTrail } from "../shared/marks.js";
import { drawMap, drawMarks } from "../shared/world_marks.js";
import { SceneLayer, ViewLayer } from "../shared/world.js";
import { poseAt } from "./futures.js";
import { drawReadings, isDrawn } from "./readings.js";

/** @typedef {import("../shared/layer.js").Brush} Brush */
/** @typedef {import("../shared/world.js").View} View */

/**
 * The map and the landmarks that the robot knows.
 * @extends {SceneLayer<import("./stage.js").Stage>}
 */
export class KnownLayer extends SceneLayer {
  isStatic = true;

  get version() {
    return `${this.stage.pictures.version} ${there(this.stage.frame).selected}`;
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

/**
 * The robot that is looked at, where it is or believes to be, with its readings and its path.
 * @extends {ViewLayer<import("./stage.js").Stage>}
 */
export class RobotLayer extends ViewLayer {
  /** @param {Brush} brush */
  draw({ context, camera, ratio, theme }) {
    const { robot, stage, view } = this;
    if (!robot) return;
    const { options } = stage;
    const frame = there(stage.frame);
    const [isTrue, i] = [view === "true", frame.selected];
    const poses = stage.posesOf(view);
    const pose = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    if (options.trails) drawTrail(context, camera, isTrue ? stage.trueTrail : stage.estimatedTrail, view, theme);
    robot.sensors.forEach((/** @type {import("./readings.js").Shape} */ sensor, /** @type {number} */ s) => {
      if (!isDrawn(sensor) || stage.hidden.has(sensor.name) || !frame.sensors[s]) return;
      const values = isTrue ? frame.sensors[s].true : frame.sensors[s].measured;
      const shape = isTrue ? /** @type {import("./readings.js").Shape} */ (stage.trueSensors[s] ?? sensor) : sensor;
      drawReadings({ context, camera, ratio, theme, kind: isTrue ? "true" : "measured" }, shape, pose, values);
    });
    if (!isTrue) {
      if (options.particles) drawCloud(context, camera, frame.particles, theme);
      if (options.hypotheses) drawHypotheses(context, camera, frame.hypotheses, theme);
      if (options.ellipse) drawEllipse(context, camera, pose, Array.from(frame.covariances.subarray(6 * i, 6 * i + 6)), theme);
      drawBelievedParts(context, camera, robot.parts, frame.believedParts, theme);
    }
    drawRobot(context, camera, robot, poses, i, view, theme, isTrue && Boolean(frame.flags[i] & 1));
  }
}

/**
 * A cross where an event happened.
 * @extends {SceneLayer<import("./stage.js").Stage>}
 */
export class MarkLayer extends SceneLayer {
  get isShown() {
    const { mark, frame } = this.stage;
    return Boolean(super.isShown && mark && frame && frame.tick >= mark.tick);
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

/**
 * The paths of other futures, and where the robot was in each of them at this time.
 * @extends {ViewLayer<import("./stage.js").Stage>}
 */
export class FuturesLayer extends ViewLayer {
  get isShown() {
    return super.isShown && this.stage.futures.length > 0;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { stage, view, robot } = this;
    for (const future of stage.futures) {
      context.globalAlpha = 0.5;
      drawTrail(context, camera, view === "true" ? future.trueTrail : future.estimatedTrail, view, theme);
      const pose = poseAt(future, view, there(stage.frame).tick);
      if (pose && robot) {
        context.beginPath();
        trace(context, robot.footprint, pose[0], pose[1], pose[2]);
        context.strokeStyle = theme[view];
        context.lineWidth = 2 / camera.scale;
        context.stroke();
      }
      context.globalAlpha = 1;
    }
  }
}

/**
 * The names of other futures, at their robots or at the ends of their paths.
 * @extends {ViewLayer<import("./stage.js").Stage>}
 */
export class FutureNamesLayer extends ViewLayer {
  /** @type {"pane"} */
  space = "pane";

  get isShown() {
    return super.isShown && this.stage.futures.length > 0;
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    context.font = "650 13px system-ui, sans-serif";
    context.lineJoin = "round";
    context.lineWidth = 3;
    context.strokeStyle = theme.paper;
    context.fillStyle = theme[this.view];
    for (const future of this.stage.futures) {
      const pose = poseAt(future, this.view, there(this.stage.frame).tick) ?? future[this.view].at(-1);
      if (!pose) continue;
      const [x, y] = camera.toScreen(pose[0], pose[1]);
      const gap = 0.8 * (this.robot?.reach ?? 0) * camera.scale + 4;
      context.strokeText(future.name, x + gap, y + gap);
      context.fillText(future.name, x + gap, y + gap);
    }
  }
}

/**
 * The box that is being drawn around robots.
 * @extends {SceneLayer<import("./stage.js").Stage>}
 */
export class BoxLayer extends SceneLayer {
  get isShown() {
    return Boolean(this.stage.box);
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const [x0, y0, x1, y1] = there(this.stage.box);
    context.fillStyle = theme["estimated-fill"];
    context.strokeStyle = theme.estimated;
    context.lineWidth = 1.5 / camera.scale;
    context.beginPath();
    context.rect(x0, y0, x1 - x0, y1 - y0);
    context.fill();
    context.stroke();
  }
}
