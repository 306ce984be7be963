// Layers of the Editor's canvas under its marks: paths and other points in the world, and what sensors see.

import { toWorld } from "../simulator/mounts.js";
import { SceneLayer } from "../shared/world.js";
import { legs } from "./grips.js";

const MOST_BEAMS = 720;

/**
 * Paths, goals and boxes of all things, dashed: those that are being dragged, or all others.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class PlacesLayer extends SceneLayer {
  /** @param {import("./stage.js").EditStage} stage
   * @param {boolean} isDragged */
  constructor(stage, isDragged) {
    super(stage);
    this.isDragged = isDragged;
  }

  get isShown() {
    return this.isDragged ? this.stage.bent.size > 0 : this.stage.things.some(({ places }) => places.length);
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { stage } = this;
    const px = 1 / camera.scale;
    const chosen = new Set(stage.chosenOnes.map(({ path }) => path));
    for (const thing of stage.things) {
      if (!thing.places.length || stage.hidden.has(thing.kind)) continue;
      context.strokeStyle = context.fillStyle = chosen.has(thing.path) ? theme.estimated : theme.soft;
      context.lineWidth = 1.5 * px;
      for (const place of stage.placesOf(thing)) {
        if (stage.bent.has(place.path) !== this.isDragged) continue;
        context.setLineDash([7 * px, 5 * px]);
        context.beginPath();
        for (const { a, b } of legs(place)) {
          context.moveTo(a[0], a[1]);
          context.lineTo(b[0], b[1]);
        }
        context.stroke();
        context.setLineDash([]);
        context.beginPath();
        for (const [x, y] of place.points) {
          context.moveTo(x + 3 * px, y);
          context.arc(x, y, 3 * px, 0, 2 * Math.PI);
        }
        context.fill();
      }
    }
  }
}

/**
 * The fields of view of the robot that is selected: while it, or one of its sensors, is dragged, or else.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class ViewsLayer extends SceneLayer {
  /** @param {import("./stage.js").EditStage} stage
   * @param {boolean} isDragged */
  constructor(stage, isDragged) {
    super(stage);
    this.isDragged = isDragged;
  }

  get isShown() {
    const [thing, ...others] = this.stage.chosenThings;
    if (!super.isShown || !thing || others.length || thing.robots.length !== 1) return false;
    return (this.stage.moved.has(thing.path) || this.stage.mounted.size > 0) === this.isDragged;
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { stage } = this;
    const [thing] = stage.chosenThings;
    const pose = stage.poseOf(thing);
    const robot = stage.scene?.robots[thing.robots[0]];
    if (!pose || !robot) return;
    for (const own of robot.sensors) {
      const sensor = stretched(own, stage.stretched);
      const isChosen = sensor.name === stage.sensor;
      const before = thing.mounts.find((one) => one.sensor === sensor.name)?.pose;
      const now = stage.mountOf(thing, sensor.name);
      context.beginPath();
      for (const mount of sensor.mounts) trace(context, sensor, placed(pose, moved(mount, before, now)), sensor.mounts.indexOf(mount));
      context.globalAlpha = isChosen ? 1 : 0.6;
      context.fillStyle = theme["measured-fill"];
      context.fill();
      if (isChosen) {
        context.strokeStyle = theme.measured;
        context.lineWidth = 1.2 / camera.scale;
        context.stroke();
      }
      context.globalAlpha = 1;
    }
  }
}

/** A mount of a sensor whose own one was dragged from one place to another.
 * @param {number[]} mount
 * @param {number[] | undefined} before
 * @param {number[] | null | undefined} now
 * @returns {number[]} */
function moved(mount, before, now) {
  if (!before || !now || before === now) return mount;
  const turn = now[2] - before[2];
  const [dx, dy] = [mount[0] - before[0], mount[1] - before[1]];
  const [c, s] = [Math.cos(turn), Math.sin(turn)];
  return [now[0] + dx * c - dy * s, now[1] + dx * s + dy * c, mount[2] + turn];
}

/** A sensor whose view is being stretched.
 * @param {import("../simulator/messages.d.ts").SensorShape} sensor
 * @param {{sensor: string, range: number, angle: number} | null} by
 * @returns {import("../simulator/messages.d.ts").SensorShape} */
function stretched(sensor, by) {
  if (by?.sensor !== sensor.name) return sensor;
  const bearings = sensor.mounts.length > 1 ? sensor.bearings : (sensor.bearings?.map((bearing) => bearing * by.angle) ?? null);
  const half = sensor.half_angle && sensor.half_angle * by.angle;
  const { drawing } = sensor;
  return {
    ...sensor, bearings, half_angle: half, range_max: sensor.range_max && sensor.range_max * by.range,
    drawing: drawing && { ...drawing, reach: drawing.reach && drawing.reach * by.range, half_angle: drawing.half_angle && drawing.half_angle * by.angle },
  };
}

/** @param {import("../simulator/mounts.js").Pose} pose
 * @param {number[]} mount */
function placed(pose, mount) {
  const [x, y] = toWorld(pose, mount[0], mount[1]);
  return [x, y, pose[2] + mount[2]];
}

/** What a sensor sees from one of its mounts: a cone, or the sector of its beams.
 * @param {number[]} mount
 * @param {CanvasRenderingContext2D} context
 * @param {import("../simulator/messages.d.ts").SensorShape} sensor
 * @param {number} n */
function trace(context, sensor, mount, n) {
  const [x, y, heading] = mount;
  const far = sensor.range_max ?? sensor.drawing?.reach;
  if (!far || !Number.isFinite(far)) return;
  const bearings = sensor.bearings?.slice(0, MOST_BEAMS) ?? [];
  const own = sensor.mounts.length > 1 ? [bearings[n] ?? 0] : bearings.length ? bearings : [0];
  const half = sensor.half_angle ?? sensor.drawing?.half_angle ?? 0;
  const [low, high] = [Math.min(...own) - half, Math.max(...own) + half];
  context.moveTo(x, y);
  if (high - low < 1e-6) context.lineTo(x + far * Math.cos(heading + low), y + far * Math.sin(heading + low));
  else if (high - low >= 2 * Math.PI - 0.02) {
    context.moveTo(x + far, y);
    context.arc(x, y, far, 0, 2 * Math.PI);
  } else context.arc(x, y, far, heading + low, heading + high);
  context.closePath();
}
