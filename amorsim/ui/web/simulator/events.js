// What happened, newest first; a click goes to its moment and place.

import { h } from "../shared/dom.js";

const MOST = 300; // shown at once

export class Events {
  /** @param {HTMLElement} list
   * @param {{go: (event: import("./messages.d.ts").EventLine) => void, stack: (event: import("./messages.d.ts").EventLine) => void}} on */
  constructor(list, on) {
    this.list = list;
    this.on = on;
    this.next = 0; // the number of the last one
  }

  clear() {
    this.next = 0;
    this.list.replaceChildren();
  }

  /** Add events, in their order.
   * @param {import("./messages.d.ts").EventLine[]} events */
  add(events) {
    for (const event of events) {
      if (event.number <= this.next) continue;
      this.next = event.number;
      if (event.is_told) continue; // the line before names both bodies
      const serious = ["collision", "fault", "hang"].includes(event.kind);
      const go = h(
        "button",
        { class: "event", title: "go to this moment", onclick: () => this.on.go(event) },
        h("span", { class: "when" }, `${event.time.toFixed(1)} s`),
        h("span", { class: serious ? "what serious" : "what" }, event.text.replace(/[._](?=\w)/g, "$&\u200b")),
      );
      const stack = event.stack ? h("button", { class: "quiet", onclick: () => this.on.stack(event) }, "stack") : null;
      this.list.prepend(h("li", {}, go, stack));
    }
    while (this.list.children.length > MOST) this.list.lastChild?.remove();
  }
}
