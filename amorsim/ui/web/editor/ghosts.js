// Where those start that are placed at random: the starts that a run with this seed draws, and moving where they are drawn.

import { trace } from "../shared/footprint.js";
import { SceneLayer } from "../shared/world.js";
import { footOn, round } from "./geometry.js";
import { legs } from "./grips.js";

/** The bodies of a thing that the file gives no place.
 * @param {import("./stage.js").EditStage} stage
 * @param {import("./stage.js").Thing} thing */
function unplaced({ still, scene }, { robots, obstacles }) {
  if (!still || !scene) return [];
  return [
    ...robots.filter((i) => still.robots[i] === null).map((i) => scene.robots[i]),
    ...obstacles.filter((i) => still.obstacles[i] === null).map((i) => scene.obstacles[i]),
  ];
}

/** Asks where a run would let them start, and has that drawn; nothing is drawn where the scenario has faults. */
export class Ghosts {
  /** @param {import("./editor.js").EditorPage} page */
  constructor(page) {
    this.page = page;
    this.isAsking = false;
    this.isChanged = false; // since it was asked
  }

  async ask() {
    const { stage, connection } = this.page;
    this.isChanged = true;
    if (this.isAsking) return;
    this.isAsking = true;
    while (this.isChanged && connection.isOpen) {
      this.isChanged = false;
      const some = stage.things.some((thing) => unplaced(stage, thing).length);
      const said = some ? await connection.ask({ do: "starts" }) : { ok: false };
      stage.ghosts = new Map(said.ok ? Object.entries(said.starts) : []);
      if (some) stage.touch();
    }
    this.isAsking = false;
  }
}

/** The ghosts of a thing: bodies, and where each would start.
 * @param {import("./stage.js").EditStage} stage
 * @param {import("./stage.js").Thing} thing */
function ghostsOf(stage, thing) {
  if (!stage.ghosts.size || stage.hidden.has(thing.kind)) return [];
  return unplaced(stage, thing).flatMap((body) => {
    const pose = stage.ghosts.get(body.name);
    return pose ? [{ body, pose }] : [];
  });
}

/** The thing one of whose ghosts lies at a point, or whose box has an edge there.
 * @param {import("./stage.js").EditStage} stage
 * @param {number} x
 * @param {number} y
 * @param {number} near */
export function startAt(stage, x, y, near) {
  const isNear = (/** @type {{a: number[], b: number[]}} */ { a, b }) => {
    const [u, v] = footOn([...a, ...b], x, y);
    return Math.hypot(u - x, v - y) <= near;
  };
  return stage.things.find(
    (thing) =>
      stage.isFree(thing.kind) &&
      (ghostsOf(stage, thing).some(({ body, pose }) => Math.hypot(pose[0] - x, pose[1] - y) <= Math.max(body.reach, near)) ||
        thing.places.some((place) => place.kind === "box" && legs(place).some(isNear))),
  );
}

/** The places from which many start, that can be moved: a box, the first of a grid, each pose of a list.
 * @param {import("./stage.js").Thing} thing */
export const startsOf = (thing) => (thing.pose ? [] : thing.places.filter(({ path }) => path.startsWith(`${thing.path}.start.`)));

/** A place that lies elsewhere by so much [m].
 * @param {import("./grips.js").PlaceOf} place */
export const shifted = ({ points }, /** @type {number} */ right, /** @type {number} */ up) => points.map(([x, y]) => [round(x + right), round(y + up)]);

/** What the document has to say for a place to have these points.
 * @param {import("./grips.js").PlaceOf} place
 * @param {number[][]} points */
export const placeChange = ({ path, kind }, points) =>
  kind === "box" ? { op: "set", path, value: points.flat() } : { op: "point", path, number: 0, value: points[0] };

/**
 * The ghosts of all things whose starts are drawn at random; not while their box is dragged.
 * @extends {SceneLayer<import("./stage.js").EditStage>}
 */
export class GhostsLayer extends SceneLayer {
  get isShown() {
    return super.isShown && this.stage.ghosts.size > 0 && !this.stage.carried;
  }

  /** @param {import("../shared/layer.js").Brush} brush */
  draw({ context, camera, theme }) {
    const { stage } = this;
    const chosen = new Set(stage.chosenOnes.map(({ path }) => path));
    context.lineWidth = 1.2 / camera.scale;
    for (const thing of stage.things) {
      if (thing.places.some(({ path }) => stage.bent.has(path))) continue;
      const ghosts = ghostsOf(stage, thing);
      if (!ghosts.length) continue;
      context.strokeStyle = context.fillStyle = chosen.has(thing.path) ? theme.estimated : thing.kind === "robot" ? theme.true : theme.soft;
      context.beginPath();
      for (const { body, pose } of ghosts) trace(context, body.footprint, pose[0], pose[1], pose[2]);
      context.globalAlpha = 0.12;
      context.fill();
      context.globalAlpha = 0.7;
      if (thing.kind === "robot") {
        for (const { body, pose: [x, y, heading] } of ghosts) {
          context.moveTo(x, y);
          context.lineTo(x + body.reach * Math.cos(heading), y + body.reach * Math.sin(heading));
        }
      }
      context.stroke();
      context.globalAlpha = 1;
    }
  }
}
