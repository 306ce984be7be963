// A recorded run in the Simulator's window: what is said of it, the choice of a replica, and its events on the time line.

import { h } from "../shared/dom.js";

const MOST_MARKS = 240; // places on the time line that have a mark of their own
const MOST_LINES = 6; // that a mark's title has

export class Replay {
  /** @param {(command: object) => Promise<any>} ask
   * @param {(event: any) => void} go
   */
  constructor(ask, go) {
    this.ask = ask;
    this.go = go;
    this.marks = h("div", { class: "marks", "aria-hidden": "true" }); // the list of events has the same for the keyboard
    this.replica = h("select", { id: "replica", onchange: () => this.choose() });
    this.chooser = h("div", { class: "replica", hidden: true }, h("label", { for: "replica" }, "replica"), this.replica);
    this.facts = h("dl", { class: "facts" });
    this.lacks = h("ul", { class: "lacks" });
    this.lacking = h("section", { hidden: true }, h("h3", {}, "Not shown"), this.lacks);
    this.element = h("div", { class: "about" }, this.chooser, this.facts, this.lacking);
    this.bins = new Map();
  }

  choose() {
    return this.ask({ do: "replica", number: Number(this.replica.value) });
  }

  /** Show what is said of a run.
   * @param {import("../shared/scene.js").Scene} scene */
  show(scene) {
    const { replica, replicas, facts, lacks } = scene.recorded;
    this.chooser.hidden = replicas.length < 2;
    this.replica.replaceChildren(...replicas.map((number) => h("option", { value: String(number) }, String(number))));
    this.replica.value = String(replica);
    this.facts.replaceChildren(...facts.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
    this.lacks.replaceChildren(...lacks.map((text) => h("li", {}, text)));
    this.lacking.hidden = !lacks.length;
    this.clear();
  }

  clear() {
    this.bins.clear();
    this.marks.replaceChildren();
  }

  /** Mark events on the time line, whose last tick is given; those that are close share a mark.
   * @param {any[]} events
   * @param {number} last */
  mark(events, last) {
    const bins = Math.min(MOST_MARKS, Math.max(last, 1));
    for (const event of events) {
      const bin = Math.round((event.tick / Math.max(last, 1)) * bins);
      let there = this.bins.get(bin);
      if (!there) {
        const element = h("i", { class: "mark", onclick: () => this.go(there.event) });
        element.style.setProperty("--at", String(Math.min(1, event.tick / Math.max(last, 1))));
        there = { event, element, lines: [] };
        this.bins.set(bin, there);
        this.marks.append(element);
      }
      there.lines.push(`${event.time.toFixed(1)} s: ${event.text}`);
      if (["collision", "fault"].includes(event.kind)) there.element.classList.add("serious");
      const more = there.lines.length - MOST_LINES;
      there.element.title = there.lines.slice(0, MOST_LINES).join("\n") + (more > 0 ? `\nand ${more} more` : "");
    }
  }
}
