// The Simulator's page in a notebook: its connection is the notebook's, by messages to the window around this one.

import { Simulator } from "./simulator.js";

/** Stands in for the connection with a server (see `shared/socket.js`). */
class NotebookConnection {
  /** @param {{frame(buffer: ArrayBuffer): void, news(message: any): void, open(): void}} on */
  constructor(on) {
    this.isOpen = true;
    this.waiting = new Map();
    this.next = 1;
    addEventListener("message", ({ source, data }) => {
      if (source !== parent) return;
      if (data.frame) on.frame(data.frame);
      else if (data.dark !== undefined) {
        document.documentElement.dataset.around = data.dark ? "dark" : "light";
        document.documentElement.dispatchEvent(new Event("around"));
      } else if (data.answer === undefined) {
        on.news(data);
        on.open();
      } else {
        this.waiting.get(data.answer)?.(data.said);
        this.waiting.delete(data.answer);
      }
    });
    this.tell({ is: "open" });
  }

  /** @param {object} message */
  tell(message) {
    parent.postMessage(message, "*");
  }

  /** @param {object} command */
  ask(command) {
    const id = this.next++;
    return new Promise((answer) => {
      this.waiting.set(id, answer);
      this.tell({ command: { id, ...command } });
    });
  }

  /** @param {number} number */
  drawn(number) {
    this.tell({ drawn: number });
  }

  close() {}
}

const root = /** @type {HTMLElement & {simulator?: Simulator}} */ (document.querySelector(".amorsim"));
document.documentElement.classList.add("without-server");
root.simulator = new Simulator(root, (on) => new NotebookConnection(on));
