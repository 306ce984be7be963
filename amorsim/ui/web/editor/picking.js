// What of a document lies under the pointer.

import { NEAR } from "../shared/pick.js";
import { reach } from "../shared/footprint.js";
import { holds } from "./geometry.js";
import { startAt } from "./ghosts.js";

/** What lies at a point: the smallest body, or else a wall.
 * @param {import("./stage.js").EditStage} stage
 * @param {{x: number, y: number}} point
 * @returns {import("./stage.js").Chosen | null} */
export function thingAt(stage, { x, y }) {
  const near = NEAR / stage.camera.scale;
  const hit = stage.things
    .filter(({ kind, footprint, pose }) => pose && footprint && stage.isFree(kind) && (holds(footprint, pose, x, y) || Math.hypot(pose[0] - x, pose[1] - y) <= near))
    .sort((a, b) => reach(a.footprint) - reach(b.footprint));
  const small = hit.find(({ kind }) => kind !== "zone");
  if (small) return stage.chosenOf(small);
  const onPath = stage.things.find(
    (thing) => stage.isFree(thing.kind) && thing.places.some(({ points }) => points.some(([u, v]) => Math.hypot(u - x, v - y) <= near)),
  );
  if (onPath) return stage.chosenOf(onPath);
  const crowd = seriesAt(stage, x, y, near) ?? startAt(stage, x, y, near);
  if (crowd) return stage.chosenOf(crowd);
  const n = stage.isFree("wall") ? stage.walls.nearest(x, y, near) : -1;
  if (n >= 0) return stage.chosenWall(n);
  return hit.length ? stage.chosenOf(hit[0]) : null;
}

/** The table of many bodies, one of which lies at a point.
 * @param {import("./stage.js").EditStage} stage
 * @param {number} x
 * @param {number} y
 * @param {number} near */
function seriesAt(stage, x, y, near) {
  if (!stage.still || !stage.scene) return null;
  const { robots, obstacles } = stage.still;
  const { scene } = stage;
  const isAt = (/** @type {number[] | null} */ pose, /** @type {number} */ far) => pose && Math.hypot(pose[0] - x, pose[1] - y) <= Math.max(far, near);
  return stage.things.find(
    (thing) =>
      !thing.pose && stage.isFree(thing.kind) &&
      (thing.robots.some((i) => isAt(robots[i], scene.robots[i].reach)) || thing.obstacles.some((i) => isAt(obstacles[i], scene.obstacles[i].reach))),
  );
}
