// Other futures: courses of events that were left by going on from their past, beside the one that is played.

import { brief, fixed, h, say } from "../shared/dom.js";
import { nearest } from "../shared/series.js";
import { Record } from "./record.js";
import { Trail } from "./trail.js";

/**
 * @typedef {{
 *   number: number, name: string, since: number, newest: number, changes: string,
 *   ticks: number[], true: number[][], estimated: number[][],
 *   trueTrail: Trail, estimatedTrail: Trail, record: Record,
 * }} Future
 */

/** A, B, C … for 1, 2, 3 …
 * @param {number} number */
export const nameOf = (number) => (number <= 26 ? String.fromCharCode(64 + number) : String(number));

/** The place of a robot in a future at a tick, as [x, y, heading]; null before it parts from what is played, and after
 * its end.
 * @param {Future} future
 * @param {"true" | "estimated"} view
 * @param {number} tick */
export function poseAt(future, view, tick) {
  if (tick < future.since || tick > future.newest || !future.ticks.length) return null;
  return future[view][nearest(future.ticks, tick)];
}

export class Futures {
  /** @param {{ask(command: object): Promise<any>, changed(): void}} on `changed`: the list is another one */
  constructor(on) {
    this.on = on;
    this.element = h("ul", { class: "futures", "aria-label": "other futures", hidden: true });
    /** @type {Future[]} */
    this.list = [];
    /** Whether one of them can be played again. */
    this.canGoBack = false;
    this.dt = 1;
    /** @type {HTMLElement[]} */
    this.words = [];
  }

  clear() {
    this.list = [];
    this.build();
  }

  /**
   * Read those of a robot.
   * @param {any} robot
   * @param {number} dt seconds of a tick
   * @param {() => boolean} isStill whether the answer is still wanted when it comes
   */
  async read(robot, dt, isStill) {
    const said = await this.on.ask({ do: "futures", robot: robot.name, max_points: 3000 });
    if (!said.ok || !isStill()) return;
    this.dt = dt;
    this.canGoBack = said.can_go_back;
    this.list = said.others.map((/** @type {any} */ other) => {
      const record = new Record(robot);
      record.load(other, dt);
      const [trueTrail, estimatedTrail] = ["true", "estimated"].map((view) => {
        const trail = new Trail();
        const from = Math.max(0, nearest(other.ticks, other.since) - 1);
        trail.load(other.ticks.slice(from), other[view].slice(from));
        return trail;
      });
      const changes = other.changes.map((/** @type {import("./messages.d.ts").ChangedParameter} */ { path, value }) => `${inWords(path)} ${shown(value)}`).join(", ");
      return { ...other, name: nameOf(other.number), changes, record, trueTrail, estimatedTrail };
    });
    this.build();
  }

  build() {
    this.words = this.list.map(() => h("span", { class: "says" }));
    this.element.replaceChildren(
      ...this.list.map((future, n) =>
        h(
          "li",
          {},
          h("strong", {}, future.name),
          this.words[n],
          this.canGoBack
            ? h("button", { class: "tool", title: "play this one again, from its end", onclick: () => this.on.ask({ do: "go_back", number: future.number }) }, "take up")
            : null,
          h("button", { class: "tool", "aria-label": `forget ${future.name}`, title: "forget this one", onclick: () => this.forget(future) }, "×"),
        ),
      ),
    );
    this.element.hidden = !this.list.length;
    this.on.changed();
  }

  /** @param {Future} future */
  async forget(future) {
    const said = await this.on.ask({ do: "forget", number: future.number });
    if (!said.ok) return;
    this.list = this.list.filter((other) => other !== future);
    this.build();
  }

  /** Tell in numbers how each differs from what is played, at the moment that is shown.
   * @param {import("./messages.d.ts").Frame} frame */
  show(frame) {
    this.list.forEach((future, n) => say(this.words[n], this.describe(future, frame)));
  }

  /** @param {Future} future
   * @param {import("./messages.d.ts").Frame} frame */
  describe(future, frame) {
    const parted = `from ${fixed(future.since * this.dt, 1)} s`;
    const what = future.changes ? `${parted}, ${future.changes}` : parted;
    const i = frame.selected;
    const [truth, estimate] = [poseAt(future, "true", frame.tick), poseAt(future, "estimated", frame.tick)];
    if (!truth || !estimate) {
      return `${what}: ${frame.tick < future.since ? "the same up to here" : `ends at ${fixed(future.newest * this.dt, 1)} s`}`;
    }
    const off = Math.hypot(truth[0] - frame.truePoses[3 * i], truth[1] - frame.truePoses[3 * i + 1]);
    const error = Math.hypot(estimate[0] - truth[0], estimate[1] - truth[1]);
    const own = Math.hypot(frame.estimatedPoses[3 * i] - frame.truePoses[3 * i], frame.estimatedPoses[3 * i + 1] - frame.truePoses[3 * i + 1]);
    return `${what}: ${fixed(off, 3)} m away, its estimate ${fixed(error, 3)} m off (here ${fixed(own, 3)})`;
  }
}

/** A parameter by its path: "errors.drive.wheel_radius_left.scale" as "wheel radius left, scale". */
const inWords = (/** @type {string} */ path) => path.split(".").slice(-2).join(", ").replaceAll("_", " ");

const shown = (/** @type {any} */ value) => (typeof value === "object" && value !== null ? JSON.stringify(value) : brief(value));
