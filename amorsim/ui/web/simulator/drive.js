// Driving by hand: keys and buttons held down make a twist, let go they stop; what a drive cannot do has no key.
// Below, each channel of the drive's own command as a slider.

import { brief, h, say, there } from "../shared/dom.js";

/** @type {Record<string, string>} */
const KEYS = {
  ArrowUp: "ahead", KeyW: "ahead", ArrowDown: "back", KeyS: "back", ArrowLeft: "left", KeyA: "left",
  ArrowRight: "right", KeyD: "right", KeyQ: "slideLeft", KeyE: "slideRight",
};
const BUTTONS = [
  ["slideLeft", "slide to the left (Q)", "⇤"], ["ahead", "ahead (W or ↑)", "▲"], ["slideRight", "slide to the right (E)", "⇥"],
  ["left", "turn left (A or ←)", "◀"], ["stop", "stop (X)", "■"], ["right", "turn right (D or →)", "▶"],
  ["back", "back (S or ↓)", "▼"],
];

const DIZZY = 3; // rad/s: faster nobody steers by hand

/** Whether keys typed here are meant for something else than driving.
 * @param {EventTarget | null} element */
export function takesKeys(element) {
  if (!(element instanceof HTMLElement)) return false;
  if (element.isContentEditable || ["INPUT", "SELECT", "TEXTAREA"].includes(element.tagName)) return true;
  return Boolean(element.closest("dialog"));
}

export class Driving {
  /** @param {(command: any) => Promise<any>} ask sends a command of the protocol and shows what went wrong
   * @param {(text: string) => void} hint */
  constructor(ask, hint) {
    this.ask = ask;
    this.hint = hint;
    this.held = new Set();
    this.share = 0.5;
    this.isByHand = false;
    this.isRunning = false;
    this.isOff = false; // whether there is nothing to drive: a recorded run
    this.switch = h("button", { id: "hand", "aria-pressed": "false", onclick: () => this.toggle() }, "drive by hand (M)");
    this.pace = h("input", {
      type: "range", id: "pace", min: "0.05", max: "1", step: "0.05", value: "0.5", "aria-label": "how fast to drive",
      oninput: () => {
        this.share = Number(this.pace.value);
        this.sayPace();
        if (this.held.size) this.send();
      },
    });
    this.paceSaid = h("output", { for: "pace", class: "factor" });
    this.buttons = new Map(BUTTONS.map(([name, label, sign]) => [name, this.button(name, label, sign)]));
    this.pad = h("div", { class: "pad", role: "group", "aria-label": "drive" }, [...this.buttons.values()]);
    this.channels = h("div", { class: "channels" });
    this.element = h(
      "div", { class: "driving" }, this.switch, h("label", { class: "pace" }, this.pace, this.paceSaid), this.pad,
      h("details", {}, h("summary", {}, "channel by channel"), this.channels),
    );
    this.listen();
  }

  /** @param {string} name
   * @param {string} label
   * @param {string} sign */
  button(name, label, sign) {
    const held = h("button", { class: `drive-${name}`, "aria-label": label, title: label }, sign);
    if (name === "stop") {
      held.addEventListener("click", () => this.stop());
      return held;
    }
    held.addEventListener("pointerdown", (event) => {
      held.setPointerCapture(event.pointerId);
      this.press(name);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"]) held.addEventListener(end, () => this.release(name));
    held.addEventListener("keydown", (event) => {
      if (!event.repeat && (event.key === " " || event.key === "Enter")) {
        event.preventDefault();
        event.stopPropagation();
        this.press(name);
      }
    });
    held.addEventListener("keyup", (event) => {
      if (event.key === " " || event.key === "Enter") this.release(name);
    });
    held.addEventListener("blur", () => this.release(name));
    return held;
  }

  listen() {
    window.addEventListener("keydown", (event) => {
      const move = KEYS[event.code];
      if (!move || this.isOff || event.shiftKey || event.ctrlKey || event.altKey || event.metaKey || takesKeys(event.target)) return;
      if (!this.isByHand) {
        if (!event.repeat) this.hint("Press M to drive this robot by hand.");
        return;
      }
      event.preventDefault();
      if (event.repeat) return;
      if (!this.isRunning) this.hint("Paused: press Space to run.");
      this.press(move);
    });
    window.addEventListener("keyup", (event) => KEYS[event.code] && this.release(KEYS[event.code]));
    // Who has lost the keyboard never hears of a key let go: stop at once.
    const letGo = () => this.held.size && this.stop();
    window.addEventListener("blur", letGo);
    window.addEventListener("pagehide", letGo);
    document.addEventListener("visibilitychange", () => document.hidden && letGo());
    document.addEventListener("focusin", (event) => takesKeys(event.target) && event.target !== this.pace && letGo());
  }

  /** @param {import("../shared/scene.js").Robot} robot */
  setRobot(robot) {
    if (this.held.size) this.stop();
    this.robot = robot;
    const [, left] = robot.twist;
    for (const name of ["slideLeft", "slideRight"]) there(this.buttons.get(name)).hidden = !(left > 0);
    this.sayPace();
    const values = robot.channels.map(() => 0);
    this.sliders = robot.channels.map((channel, c) => {
      const degrees = channel.unit.startsWith("rad");
      const factor = degrees ? 180 / Math.PI : 1;
      const unit = degrees ? channel.unit.replace("rad", "°") : channel.unit;
      // A channel without bounds of its own gets room for one turn a second each way.
      const [low, high] = [channel.low ?? -2 * Math.PI, channel.high ?? 2 * Math.PI];
      const said = h("output", { class: "factor" }, `0 ${unit}`);
      const slider = h("input", {
        type: "range", min: String(low), max: String(high), step: String((high - low) / 200), value: "0",
        "aria-label": channel.name.replaceAll("_", " "),
        oninput: () => {
          values[c] = Number(slider.value);
          say(said, `${brief(Math.round(values[c] * factor * 10) / 10)} ${unit}`);
          this.ask({ do: "command", robot: there(this.robot).name, channels: [...values] });
        },
      });
      const zero = () => {
        values[c] = 0;
        slider.value = "0";
        say(said, `0 ${unit}`);
      };
      return { zero, slider, element: h("label", { class: "channel" }, h("span", {}, channel.name.replaceAll("_", " ")), slider, said) };
    });
    this.channels.replaceChildren(...this.sliders.map(({ element }) => element));
    this.setByHand(false);
  }

  sayPace() {
    if (this.robot) say(this.paceSaid, `${(this.share * this.robot.twist[0]).toFixed(2)} m/s`);
  }

  /** @param {boolean} isByHand */
  setByHand(isByHand) {
    this.isByHand = isByHand;
    this.switch.setAttribute("aria-pressed", String(isByHand));
    say(this.switch, isByHand ? "driven by hand: give back (M)" : "drive by hand (M)");
    this.element.classList.toggle("by-hand", isByHand);
    for (const button of this.buttons.values()) button.disabled = !isByHand;
    for (const { slider } of this.sliders ?? []) slider.disabled = !isByHand;
  }

  async toggle() {
    if (!this.robot || this.isOff) return;
    const to = this.isByHand ? "controller" : "hand";
    const said = await this.ask({ do: "hand_over", robot: there(this.robot).name, to });
    if (said.ok) this.setByHand(to === "hand");
  }

  /** @param {string} name */
  press(name) {
    if (!this.isByHand || this.held.has(name)) return;
    this.held.add(name);
    this.send();
  }

  /** @param {string} name */
  release(name) {
    if (this.held.delete(name)) this.send();
  }

  stop() {
    this.held.clear();
    this.sliders?.forEach((channel) => channel.zero());
    this.showHeld();
    return this.ask({ do: "stop", robot: there(this.robot).name });
  }

  send() {
    this.showHeld();
    if (!this.held.size) return this.stop();
    const [forward, left, fastest] = there(this.robot).twist;
    const turn = Math.min(fastest, DIZZY);
    const both = (/** @type {string} */ a, /** @type {string} */ b) => (this.held.has(a) ? 1 : 0) - (this.held.has(b) ? 1 : 0);
    const back = both("ahead", "back") < 0;
    return this.ask({
      do: "drive",
      robot: there(this.robot).name,
      forward: this.share * forward * both("ahead", "back"),
      left: this.share * left * both("slideLeft", "slideRight"),
      // A car that backs turns its nose the other way: so does everybody who reverses with the wheel held left.
      turn: this.share * turn * both("left", "right") * (back ? -1 : 1),
    });
  }

  showHeld() {
    for (const [name, button] of this.buttons) button.classList.toggle("held", this.held.has(name));
  }
}
