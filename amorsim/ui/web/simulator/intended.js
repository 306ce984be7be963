// What the robot intends: its path and what it compared in its last decision, each with a switch.

import { h } from "../shared/dom.js";
import { SceneLayer } from "../shared/world.js";
import { drawArcs, drawPath, drawSearched, drawSectors, drawVelocities, drawWays } from "./intentions.js";

/** @typedef {import("../shared/layer.js").Brush} Brush */
/** @typedef {import("./wire.js").Intended} Said */

const SWITCHES = [
  ["path", "path", "the path that it follows"],
  ["searched", "searched", "the places that its planner searched, the first the palest"],
  ["arcs", "arcs", "the arcs that it compared: the better, the darker; red it could not brake from"],
  ["blocked", "histogram", "directions that are blocked, red, and the direction that it took"],
  ["velocities", "velocities", "the others as it knows them, and the velocities that lead into them, red"],
];
const EVERY = 120; // milliseconds between two looks

/** What was intended, as it came last, and the switches. */
export class Intended {
  /**
   * @param {(command: object) => Promise<any>} ask
   * @param {() => void} changed
   */
  constructor(ask, changed) {
    this.ask = ask;
    this.changed = changed;
    /** @type {Said | null} */
    this.found = null;
    this.key = "";
    this.element = h("div", { class: "tools", role: "group", "aria-label": "what is drawn of what it intends", hidden: true });
    this.shows = Object.fromEntries(SWITCHES.map(([name]) => [name, true]));
    this.buttons = new Map(
      SWITCHES.map(([name, label, title]) => {
        const button = h("button", { class: "tool", "aria-pressed": "true", title, onclick: () => this.toggle(name) }, label);
        return [name, button];
      }),
    );
    setInterval(() => this.look(), EVERY);
  }

  toggle(name) {
    this.shows[name] = !this.shows[name];
    this.buttons.get(name).setAttribute("aria-pressed", String(this.shows[name]));
    this.changed();
  }

  /** The frame that is shown now; another robot's intentions are not this one's.
   * @param {{epoch: number, tick: number, selected: number}} frame */
  setFrame(frame) {
    this.frame = frame;
    if (frame.selected === this.robot) return;
    this.robot = frame.selected;
    this.set(null);
    this.isDone = false; // of this robot nothing is known yet
  }

  /** Whether the robot has what a switch shows. */
  has(name) {
    return Boolean(this.found?.[name] || (name === "velocities" && this.found?.ways));
  }

  /** Ask what was intended, if that is another moment than the last time and any of it is drawn. */
  async look() {
    if (!this.frame || this.isAsking || this.isDone || document.hidden) return;
    if (this.found && !SWITCHES.some(([name]) => this.has(name) && this.shows[name])) return;
    const { epoch, tick, selected } = this.frame;
    const key = `${epoch} ${tick} ${selected}`;
    if (key === this.key) return;
    this.isAsking = true;
    const said = await this.ask({ do: "intended", robot: selected });
    this.isAsking = false;
    if (!said.ok || selected !== this.robot) return;
    this.key = key;
    this.set(said.intended);
    this.isDone = !SWITCHES.some(([name]) => this.has(name)); // a controller has them from its start, or never
  }

  /** @param {Said | null} found */
  set(found) {
    this.found = found;
    const shown = SWITCHES.filter(([name]) => this.has(name)).map(([name]) => this.buttons.get(name));
    if (shown.length !== this.element.childElementCount) this.element.replaceChildren(...shown);
    this.element.hidden = !shown.length;
    this.changed();
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
