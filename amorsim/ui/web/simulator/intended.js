// What the robot intends: its path and what it compared in its last decision, each with a switch.

import { SceneLayer } from "../shared/world.js";
import { Asked } from "./asked.js";
import { drawArcs, drawPath, drawSearched, drawSectors, drawVelocities, drawWays } from "./intentions.js";

/** @typedef {import("../shared/layer.js").Brush} Brush */
/** @typedef {import("./messages.d.ts").Intended} Said */

const SWITCHES = [
  ["path", "path", "the path that it follows"],
  ["searched", "searched", "the places that its planner searched, the first the palest"],
  ["arcs", "arcs", "the arcs that it compared: the better, the darker; red it could not brake from"],
  ["blocked", "histogram", "directions that are blocked, red, and the direction that it took"],
  ["velocities", "velocities", "the others as it knows them, and the velocities that lead into them, red"],
];

/**
 * What was intended, as it came last, and the switches.
 * @extends {Asked<Said | null>}
 */
export class Intended extends Asked {
  /**
   * @param {(command: object) => Promise<any>} ask
   * @param {() => void} changed
   */
  constructor(ask, changed) {
    const look = async (/** @type {number} */ robot) => {
      const said = await ask({ do: "intended", robot });
      return { ok: said.ok, found: said.intended };
    };
    super(look, changed, { every: 120, label: "what is drawn of what it intends", switches: SWITCHES, nothing: null });
  }

  /** @override @param {string} name */
  has(name) {
    return Boolean(/** @type {any} */ (this.found)?.[name] || (name === "velocities" && this.found?.ways));
  }

  /** A controller has them from its start, or never. @override */
  isNever() {
    return !this.names.some((name) => this.has(name));
  }
}

/**
 * Draws it. Switches that are off are not drawn.
 * @extends {SceneLayer<import("./stage.js").Stage>}
 */
export class IntendedLayer extends SceneLayer {
  get isShown() {
    return super.isShown && Boolean(this.stage.intended.found);
  }

  /** @param {Brush} brush */
  draw({ context, camera, theme }) {
    const { found, shows } = this.stage.intended;
    if (!found) return;
    const { pose, searched, path, arcs, blocked, bearing, ways, velocities } = found;
    const reach = this.robot.reach;
    context.save();
    if (searched && shows.searched) drawSearched(context, camera, theme, searched);
    if (ways && shows.velocities) drawWays(context, camera, theme, pose, ways);
    if (arcs && shows.arcs) drawArcs(context, camera, theme, arcs);
    if (path && shows.path) drawPath(context, camera, theme, path);
    if (blocked && shows.blocked) drawSectors(context, camera, theme, pose, reach, blocked, bearing ?? []);
    if (velocities && shows.velocities) drawVelocities(context, camera, theme, pose, velocities);
    context.restore();
  }
}
