// The line below the header: what went wrong with a controller, the simulation or the connection, and what to do.

import { tell } from "../shared/dialogs.js";
import { h } from "../shared/dom.js";
import { lostWords } from "../shared/socket.js";

/** @type {Record<string, string>} */
const WORDS = {
  lost: lostWords(0),
  compiling: "Kernels are being compiled, once after installing: some ten seconds. It goes on by itself.",
  restarting: "The simulation is being restarted …",
  gone: "The simulation's process has ended.",
  hang: "No sign of life from the simulation: a controller may hang.",
};

export class Warnings {
  /** @param {HTMLElement} banner
   * @param {(command: any) => Promise<any>} ask */
  constructor(banner, ask) {
    this.banner = banner;
    this.ask = ask;
    this.shown = "";
  }

  /** @param {any} state */
  show(state) {
    const fault = state.fault;
    const trouble = WORDS[state.status] !== undefined || state.status === "fault";
    const words = state.status === "lost" ? lostWords(state.attempts) : WORDS[state.status];
    let signature = trouble ? `${state.status} ${fault?.number ?? words}` : "";
    if (!trouble && state.changed) signature = "changed";
    if (!trouble && state.damage) signature = `damage ${state.damage}`;
    if (signature === this.shown) return;
    this.shown = signature;
    this.banner.hidden = !signature;
    this.banner.className = `banner ${trouble ? state.status : signature.split(" ")[0]}`;
    if (signature === "changed") this.offerReload();
    if (signature.startsWith("damage")) this.banner.replaceChildren(h("span", {}, state.damage));
    if (!trouble) return;
    const parts = [h("span", {}, fault && state.status !== "lost" ? fault.text : words)];
    if (fault?.stack) parts.push(h("button", { onclick: () => tell("Where it was", h("pre", { tabindex: "0" }, fault.stack)) }, "show the stack"));
    if (["fault", "hang", "gone"].includes(state.status)) {
      const without = fault?.robot ? [fault.robot] : [];
      const label = without.length ? `go on with ${fault.robot} driven by hand` : "restart";
      parts.push(h("button", { class: "main", onclick: () => this.ask({ do: "restart", without }) }, label));
      if (without.length) parts.push(h("button", { onclick: () => this.ask({ do: "restart", without: [] }) }, "restart with it"));
    }
    this.banner.replaceChildren(...parts);
  }

  /** The scenario's file has changed: offer to load it again, which ends this simulation. */
  offerReload() {
    const button = h("button", { class: "holders-only", title: "ends this simulation" }, "load again");
    button.addEventListener("click", async () => {
      button.disabled = true;
      const said = await this.ask({ do: "reload" });
      button.disabled = false;
      if (said.ok) location.replace(said.path);
    });
    this.banner.replaceChildren(h("span", {}, "The scenario's files have changed."), button);
  }
}
