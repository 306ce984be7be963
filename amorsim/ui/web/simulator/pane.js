// A pane: one canvas with its layers, its scale bar, and the pointer and keys on it. The Editor draws on the same one.

import { fixed, h, niceStep, say } from "../shared/dom.js";
import { drawCrowd } from "./crowd.js";
import {
  drawBelievedParts, drawEllipse, drawFloor, drawGrid, drawMap, drawMarks, drawObstacles, drawRobot, drawTrail,
} from "../shared/marks.js";
import { drawNames } from "./names.js";
import { drawReadings, isDrawn } from "./readings.js";

/** What a pane shows of the world (`true`) or of what the robot knows (`estimated`). */
export class Layer {
  constructor(kind) {
    this.kind = kind;
    this.hidden = new Set(); // names of sensors that are not drawn
  }

  shows(name) {
    return !this.hidden.has(name);
  }

  poses(frame) {
    return this.kind === "true" ? frame.truePoses : frame.estimatedPoses;
  }

  /** What stands still, and obstacles. */
  drawGround(context, camera, state) {
    const { scene, frame, theme } = state;
    const robot = scene.robots[frame.selected];
    if (this.kind === "true") {
      drawMap(context, camera, scene.map, state.pathOf(scene.map), state.picture(scene.map, theme.wall), theme.wall);
      drawFloor(context, camera, scene.floor, theme);
      drawObstacles(context, camera, scene.obstacles, frame.obstacles, theme);
    } else if (robot?.knowledge) {
      const [map, shade] = [robot.knowledge, theme["known-wall"]];
      drawMap(context, camera, map, state.pathOf(map), state.picture(map, shade), shade);
    }
    if (this.kind !== "true" && robot) drawMarks(context, camera, robot.landmarks, theme["known-wall"]);
  }

  draw(context, camera, state, ratio) {
    const { scene, frame, theme, options } = state;
    const isTrue = this.kind === "true";
    const i = frame.selected;
    const robot = scene.robots[i];
    const poses = this.poses(frame);
    // Where others are a robot knows from its readings alone, and those are drawn.
    if (isTrue) drawCrowd(context, camera, ratio, scene.robots, poses, i, theme);
    if (!robot) return;
    const pose = [poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]];
    if (options.trails) drawTrail(context, camera, isTrue ? state.trueTrail : state.estimatedTrail, this.kind, theme);
    robot.sensors.forEach((sensor, s) => {
      if (!isDrawn(sensor) || !this.shows(sensor.name) || !frame.sensors[s]) return;
      const values = isTrue ? frame.sensors[s].true : frame.sensors[s].measured;
      const shape = isTrue ? (state.trueSensors[s] ?? sensor) : sensor;
      drawReadings({ context, camera, theme, kind: isTrue ? "true" : "measured" }, shape, pose, values);
    });
    if (!isTrue && options.ellipse) {
      drawEllipse(context, camera, pose, Array.from(frame.covariances.subarray(6 * i, 6 * i + 6)), theme);
    }
    if (!isTrue) drawBelievedParts(context, camera, robot.parts, frame.believedParts, theme);
    drawRobot(context, camera, robot, poses, i, this.kind, theme, isTrue && frame.flags[i] & 1);
  }
}

export class Pane {
  /**
   * @param camera shared by all panes
   * @param layers drawn in order
   * @param on `{pick(pane, x, y), moved(pane, x, y)}`
   */
  constructor({ id, label, camera, layers, on }) {
    this.camera = camera;
    this.layers = layers;
    this.on = on;
    this.coordinates = h("output", { class: "coordinates", "aria-hidden": "true" });
    this.canvas = h("canvas", {
      id,
      tabindex: "0",
      role: "img",
      "aria-label": `${label}. Drag or Shift and arrows pan, plus and minus zoom, 0 shows all, F follows, Enter tells what is in the middle.`,
    });
    this.note = h("output", { class: "note", "aria-hidden": "true" }); // what the table tells, too
    this.lack = h("p", { class: "lack", role: "status" }); // why there is less to see than one might expect
    this.element = h("div", { class: "pane" }, this.canvas, this.lack, this.coordinates, this.note);
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.listen();
  }

  resize() {
    this.ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.element;
    const [width, height] = [Math.round(clientWidth * this.ratio), Math.round(clientHeight * this.ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    return [clientWidth, clientHeight];
  }

  draw(state) {
    const { context, camera } = this;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = state.theme.paper;
    context.fillRect(0, 0, this.canvas.width, this.canvas.height);
    camera.apply(context, this.ratio);
    if (state.options.grid) drawGrid(context, camera, niceStep(40 / camera.scale), state.theme.grid);
    if (state.scene && state.frame) {
      // What is known lies under what is true, so that an overlay shows both.
      for (const layer of [...this.layers].reverse()) layer.drawGround(context, camera, state);
      for (const layer of this.layers) layer.draw(context, camera, state, this.ratio);
      if (state.mark && state.frame.tick >= state.mark.tick) this.drawMark(state);
    }
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    if (state.scene && state.frame) {
      const [layer] = this.layers;
      const isAlone = layer.kind !== "true"; // of the others it knows nothing
      drawNames(context, camera, state.scene.robots, layer.poses(state.frame), state.frame.selected, isAlone, state.theme);
    }
    this.drawScale(state.theme);
    if (this.canvas.matches(":focus-visible")) this.drawMiddle(state.theme);
  }

  /** A cross where an event happened. */
  drawMark({ mark, theme }) {
    const [x, y] = mark.point;
    const size = 9 / this.camera.scale;
    const { context } = this;
    context.strokeStyle = theme.danger;
    context.lineWidth = 2.5 / this.camera.scale;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(x - size, y - side * size);
      context.lineTo(x + size, y + side * size);
    }
    context.stroke();
  }

  drawMiddle(theme) {
    const { context, camera } = this;
    const [x, y] = [camera.width / 2, camera.height / 2];
    context.strokeStyle = theme.ink;
    context.lineWidth = 1;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(x + 4 * side, y);
      context.lineTo(x + 11 * side, y);
      context.moveTo(x, y + 4 * side);
      context.lineTo(x, y + 11 * side);
    }
    context.stroke();
  }

  drawScale(theme) {
    const { context, camera } = this;
    const length = niceStep(50 / camera.scale);
    const wide = length * camera.scale;
    const [left, base] = [12.5, camera.height - 12.5];
    const text = length >= 1 ? `${length} m` : `${Math.round(length * 1000)} mm`;
    context.font = "12px system-ui, sans-serif";
    context.globalAlpha = 0.8;
    context.fillStyle = theme.paper;
    context.fillRect(left - 6, base - 12, wide + context.measureText(text).width + 18, 18);
    context.globalAlpha = 1;
    context.strokeStyle = theme.soft;
    context.fillStyle = theme.soft;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(left, base - 4);
    context.lineTo(left, base);
    context.lineTo(left + wide, base);
    context.lineTo(left + wide, base - 4);
    context.stroke();
    context.fillText(text, left + wide + 6, base);
  }

  listen() {
    const { canvas, camera } = this;
    let from = null;
    let moved = 0;
    const where = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 && event.button !== 1) return;
      from = [event.clientX, event.clientY];
      moved = 0;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      const [x, y] = camera.toWorld(...where(event));
      say(this.coordinates, `${fixed(x, 2)}, ${fixed(y, 2)} m`);
      if (!from) return;
      const [right, down] = [event.clientX - from[0], event.clientY - from[1]];
      moved += Math.abs(right) + Math.abs(down);
      from = [event.clientX, event.clientY];
      if (moved > 4) {
        this.on.panned?.();
        camera.pan(right, down);
      }
    });
    canvas.addEventListener("pointerup", (event) => {
      if (from && moved <= 4 && event.button === 0) {
        const [left, top] = where(event);
        this.on.pick?.(this, ...camera.toWorld(left, top), left, top);
      }
      from = null;
    });
    canvas.addEventListener("pointerleave", () => say(this.coordinates, ""));
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        camera.zoom(Math.exp(-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 120) * 0.0015), ...where(event));
      },
      { passive: false },
    );
    // By keyboard, what is in the middle is what is pointed at.
    canvas.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      this.on.pick?.(this, camera.x, camera.y, camera.width / 2, camera.height / 2);
    });
    for (const change of ["focus", "blur"]) canvas.addEventListener(change, () => camera.changed());
    canvas.addEventListener("dblclick", () => this.on.fit?.());
  }
}
