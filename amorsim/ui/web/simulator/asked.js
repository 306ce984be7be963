// What is known of the robot that is looked at, asked for again and again: its parts, each with a switch.

import { h, there } from "../shared/dom.js";

/**
 * @template Found
 */
export class Asked {
  /**
   * @param {(robot: number) => Promise<{ok: boolean, found?: Found}>} ask
   * @param {() => void} changed
   * @param {{every: number, label: string, switches: string[][], nothing: Found}} what `every` [ms] it is asked; of each
   *   switch the part's name, its label and its title; `nothing` is found before there is an answer
   */
  constructor(ask, changed, { every, label, switches, nothing }) {
    this.ask = ask;
    this.changed = changed;
    this.nothing = nothing;
    this.found = nothing;
    this.key = "";
    this.robot = -1;
    this.names = switches.map(([name]) => name);
    this.element = h("div", { class: "tools", role: "group", "aria-label": label, hidden: true });
    /** @type {Record<string, boolean>} */
    this.shows = Object.fromEntries(this.names.map((name) => [name, true]));
    this.buttons = new Map(
      switches.map(([name, words, title]) => {
        const button = h("button", { class: "tool", "aria-pressed": "true", title, onclick: () => this.toggle(name) }, words);
        return [name, button];
      }),
    );
    setInterval(() => this.look(), every);
  }

  /** @param {string} name */
  toggle(name) {
    this.shows[name] = !this.shows[name];
    there(this.buttons.get(name)).setAttribute("aria-pressed", String(this.shows[name]));
    this.changed();
  }

  /** The frame that is shown now; what is known of another robot is not this one's.
   * @param {{epoch: number, tick: number, selected: number}} frame */
  setFrame(frame) {
    this.frame = frame;
    if (frame.selected === this.robot) return;
    this.robot = frame.selected;
    this.set(this.nothing);
    this.isDone = false; // of this robot nothing is known yet
  }

  /** Whether the robot has what a switch shows.
   * @param {string} _name
   * @returns {boolean} */
  has(_name) {
    return false;
  }

  /** Whether an answer says that the robot never has any of it.
   * @param {Found} _found
   * @returns {boolean} */
  isNever(_found) {
    return false;
  }

  /** Ask, if that is another moment than the last time and any of it is drawn. */
  async look() {
    if (!this.frame || this.isAsking || this.isDone || document.hidden) return;
    const had = this.names.filter((name) => this.has(name));
    if (had.length && !had.some((name) => this.shows[name])) return;
    const { epoch, tick, selected } = this.frame;
    const key = `${epoch} ${tick} ${selected}`;
    if (key === this.key) return;
    this.isAsking = true;
    const said = await this.ask(selected);
    this.isAsking = false;
    const { found } = said;
    if (!said.ok || found === undefined || selected !== this.robot) return;
    this.key = key;
    this.set(found);
    this.isDone = this.isNever(found);
  }

  /** @param {Found} found */
  set(found) {
    this.found = found;
    const shown = this.names.filter((name) => this.has(name)).map((name) => there(this.buttons.get(name)));
    if (shown.length !== this.element.childElementCount) this.element.replaceChildren(...shown);
    this.element.hidden = !shown.length;
    this.changed();
  }
}
