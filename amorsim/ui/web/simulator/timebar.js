// The control of time: run, pause, step, reset, speed, and the time line over what was recorded.

import { clock, fixed, h, say, there } from "../shared/dom.js";
import { FLAG } from "./protocol.js";

/** The slider's places; the last, none, is as fast as possible. */
const SPEEDS = [0.1, 0.2, 0.5, 1, 2, 3, 5, 10, 20, 50, 100, null];

/** @type {Record<string, string>} */
const ICONS = {
  reset: "M5 12a7 7 0 1 0 2.2-5.1M5 4v4h4",
  run: "M8 5l11 7-11 7z",
  pause: "M8 5v14M16 5v14",
  step: "M6 5l9 7-9 7zM18 5v14",
};

/** @param {string} name */
function icon(name) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 24 24");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", ICONS[name]);
  svg.append(path);
  return svg;
}

export class TimeBar {
  /** @param {(command: any) => Promise<any>} ask sends a command of the protocol and shows what went wrong */
  constructor(ask) {
    this.ask = ask;
    this.state = {};
    this.isRecorded = false;
    this.isRunning = false;
    const button = (/** @type {string} */ name, /** @type {string} */ label, /** @type {() => void} */ does, extra = {}) =>
      h("button", { class: "icon", "aria-label": label, title: label, id: name, onclick: does, ...extra }, icon(name));
    this.reset = button("reset", "reset to the start", () => this.doReset());
    this.run = button("run", "run (Space)", () => this.toggle(), { class: "icon main" });
    this.step = button("step", "one step (.)", () => this.doStep());
    this.speed = h("input", {
      type: "range",
      id: "speed",
      min: "0",
      max: String(SPEEDS.length - 1),
      step: "1",
      value: "3",
      "aria-label": "speed",
      oninput: () => this.ask({ do: "speed", factor: SPEEDS[Number(this.speed.value)] }),
    });
    this.factor = h("output", { class: "factor", for: "speed" });
    this.achieved = h("span", { class: "achieved", title: "the factor that is reached" });
    this.line = h("input", {
      type: "range",
      id: "timeline",
      min: "0",
      max: "0",
      value: "0",
      step: "1",
      "aria-label": "time line",
      oninput: () => this.scrub(),
    });
    this.now = h("output", { class: "now", for: "timeline" });
    this.carryOn = h("button", { id: "continue", class: "main", onclick: () => this.doContinue() }, "continue here");
    this.toEnd = h("button", { id: "newest", onclick: () => this.ask({ do: "scrub", tick: null }) }, "back to the newest");
    this.element = h(
      "div",
      { class: "timebar", role: "group", "aria-label": "time" },
      this.reset,
      this.run,
      this.step,
      h("label", { class: "speed" }, h("span", { class: "caption" }, "speed"), this.speed),
      this.factor,
      this.achieved,
      (this.timeline = h("div", { class: "timeline" }, this.line)),
      this.now,
    );
    this.past = h(
      "div",
      { class: "past", role: "group", "aria-label": "the past is shown", hidden: true },
      (this.pastSaid = h("span", {})),
      this.carryOn,
      this.toEnd,
    );
  }

  toggle() {
    return this.ask({ do: this.isRunning ? "pause" : "run" });
  }

  /** Play a recorded run, whose events are marked: there is nothing to reset or to continue.
   * @param {HTMLElement} marks */
  setRecorded(marks) {
    this.isRecorded = true;
    this.timeline.append(marks);
    this.reset.setAttribute("aria-label", "to the start");
    this.reset.title = "to the start";
  }

  doStep() {
    return this.ask({ do: "step" });
  }

  doStepBack() {
    return this.isRecorded && this.frame ? this.ask({ do: "scrub", tick: Math.max(0, this.frame.tick - 1) }) : null;
  }

  doReset() {
    return this.ask(this.isRecorded ? { do: "scrub", tick: 0 } : { do: "reset" });
  }

  async doContinue() {
    await this.ask({ do: "continue", tick: there(this.frame).tick });
  }

  /** Show the moment that the time line points at; one request at a time, the newest place next. */
  async scrub() {
    if (this.scrubbing) return;
    this.scrubbing = true;
    let last;
    while (last !== this.line.value) {
      last = this.line.value;
      await this.ask({ do: "scrub", tick: Number(last) });
    }
    this.scrubbing = false;
  }

  /** @param {import("./messages.d.ts").Frame} frame
   * @param {import("../shared/scene.js").Scene} scene */
  show(frame, scene) {
    this.frame = frame;
    const isRunning = Boolean(frame.states & FLAG.running);
    const isPast = Boolean(frame.states & FLAG.scrubbed);
    if (isRunning !== this.isRunning) {
      this.isRunning = isRunning;
      const label = isRunning ? "pause (Space)" : "run (Space)";
      this.run.setAttribute("aria-label", label);
      this.run.title = label;
      this.run.replaceChildren(icon(isRunning ? "pause" : "run"));
    }
    const asked = Number.isFinite(frame.speed) ? `${+frame.speed.toFixed(2)}×` : "max";
    say(this.factor, asked);
    const place = SPEEDS.findIndex((speed) => (speed === null ? !Number.isFinite(frame.speed) : speed >= frame.speed - 1e-4));
    if (document.activeElement !== this.speed && place >= 0) this.speed.value = String(place);
    this.speed.setAttribute("aria-valuetext", asked === "max" ? "as fast as possible" : `${asked} of real time`);
    say(this.achieved, isRunning ? `reached ${reached(frame.achieved)}×` : "");
    const last = Math.max(frame.newest, Math.round(scene.duration / scene.dt));
    this.line.min = "0";
    this.line.max = String(last);
    this.line.style.setProperty("--recorded", String(frame.newest / Math.max(last, 1)));
    if (!this.scrubbing) this.line.value = String(frame.tick);
    const total = `${clock(frame.time)} / ${clock(Math.max(scene.duration, frame.newest * scene.dt))}`;
    say(this.now, total);
    this.line.setAttribute("aria-valuetext", `${fixed(frame.time, 1)} s`);
    this.past.hidden = !isPast;
    const left = frame.states & FLAG.posesOnly ? " (of this moment only poses are kept)" : "";
    const why = this.reason ? ` One cannot go on from here: ${this.reason}.` : "";
    say(this.pastSaid, `This is the past, ${fixed(frame.time, 1)} s${left}.${why}`);
  }

  /** Whether one can go on from the past moment that is shown, and why not.
   * @param {import("./messages.d.ts").State} state */
  setState(state) {
    this.reason = state.can_continue === false ? state.reason.replace(/\.$/, "") : "";
    this.carryOn.disabled = Boolean(this.reason);
    this.carryOn.title = this.reason || "simulate on from this moment; what came after it stays beside it";
  }
}

const reached = (/** @type {number} */ factor) => (factor >= 20 ? Math.round(factor) : factor.toFixed(1));
