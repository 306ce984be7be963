// The page of a scenario with faults: what is wrong, and what can be drawn. It goes on to the simulation once the file
// is mended.

import { h, say } from "../shared/dom.js";
import { Connection, lostWords } from "../shared/socket.js";
import { StillStage } from "../shared/still.js";
import { startTheme } from "../shared/theme.js";
import { faultList } from "./list.js";

const STARTING = "No faults any more. The simulation is being started; this page goes on to it by itself.";

/** @typedef {import("../simulator/messages.d.ts").FaultyFile} FaultyFile */

export class FaultsPage {
  /** @param {HTMLElement} root */
  constructor(root) {
    this.toggleTheme = startTheme(root);
    this.stage = new StillStage(root, { id: "pane", label: "What can be drawn of the scenario", picked: (place) => this.picked(place) });
    this.file = h("span", { class: "file" });
    this.back = h("a", { class: "back", hidden: true }, "back to the simulation of the file as it was");
    this.count = h("h2", { id: "faults-title" }, "Faults");
    this.list = h("div", { class: "scroll", tabindex: "0", role: "group", "aria-labelledby": "faults-title" });
    this.status = h("div", { class: "banner", role: "status", "aria-live": "polite", hidden: true });
    this.lack = h("p", { class: "lack", role: "status" });
    this.card = h("div", { class: "card", role: "status", hidden: true });
    this.theme = h("button", { class: "icon", "aria-label": "light or dark (L)", title: "light or dark (L)" }, "◐");
    this.out = h("button", { class: "tool", "aria-label": "zoom out (−)", title: "zoom out (−)" }, "−");
    this.in = h("button", { class: "tool", "aria-label": "zoom in (+)", title: "zoom in (+)" }, "+");
    this.all = h("button", { class: "tool", "aria-label": "see all (0)", title: "see all (0)" }, "all");
    this.build(root);
    this.stage.selection.listen((selection) => (this.card.hidden = !selection.only));
    this.listen();
    this.connection = new Connection({
      frame: () => {},
      news: () => {},
      open: () => this.follow(),
      lost: (/** @type {number} */ attempts) => this.tell(lostWords(attempts)),
    });
  }

  /** @param {HTMLElement} root */
  build(root) {
    this.stage.pane.element.append(this.lack);
    root.replaceChildren(
      h(
        "div",
        { class: "window" },
        h("header", { class: "bar" }, h("h1", {}, "amorsim"), this.file, this.back, h("span", { class: "space" }), this.theme),
        this.status,
        h(
          "div",
          { class: "panels" },
          h(
            "section",
            { class: "panel faults", "aria-labelledby": "faults-title" },
            h("div", { class: "head" }, this.count, h("span", { class: "note" }, "save the mended file: this page follows it")),
            this.list,
          ),
          h(
            "section",
            { class: "panel drawn", "aria-labelledby": "drawn-title" },
            h(
              "div",
              { class: "head" },
              h("h2", { id: "drawn-title" }, "What can be drawn"),
              h("div", { class: "tools", role: "group", "aria-label": "view" }, this.out, this.in, this.all),
            ),
            this.stage.pane.element,
          ),
        ),
        this.card,
      ),
    );
  }

  listen() {
    const { stage } = this;
    const { camera } = stage;
    this.theme.addEventListener("click", () => this.toggleTheme());
    this.out.addEventListener("click", () => camera.zoom(1 / 1.3));
    this.in.addEventListener("click", () => camera.zoom(1.3));
    this.all.addEventListener("click", () => stage.fit());
    /** @type {Record<string, (() => void) | undefined>} */
    const plain = {
      "+": () => camera.zoom(1.3),
      "=": () => camera.zoom(1.3),
      "-": () => camera.zoom(1 / 1.3),
      0: () => stage.fit(),
      g: () => {
        stage.options.grid = !stage.options.grid;
        stage.redraw();
      },
      l: () => this.toggleTheme(),
      Escape: () => stage.selection.clear(),
    };
    /** @type {Record<string, (() => void) | undefined>} */
    const shifted = {
      ArrowLeft: () => camera.pan(60, 0),
      ArrowRight: () => camera.pan(-60, 0),
      ArrowUp: () => camera.pan(0, 60),
      ArrowDown: () => camera.pan(0, -60),
    };
    globalThis.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      const does = (event.shiftKey && shifted[event.key]) || plain[event.key];
      if (!does) return;
      event.preventDefault();
      does();
    });
  }

  /** Show how the file stands, and again whenever that has changed, for as long as the connection holds. */
  async follow() {
    this.tell("");
    let number = 0;
    while (this.connection.isOpen) {
      const said = await this.connection.ask({ do: "document", after: number });
      if (!said.ok) break;
      number = said.number;
      this.show(said);
    }
  }

  /** @param {FaultyFile} said */
  show(said) {
    if (said.status === "open") {
      location.replace(said.path);
      return;
    }
    this.said = said;
    const { faults, file, still } = said;
    document.title = `${file} · amorsim`;
    say(this.file, file);
    this.file.title = file;
    this.back.hidden = !said.path;
    this.back.href = said.path;
    say(this.count, faults.length === 1 ? "1 fault" : `${faults.length || "No"} faults`);
    this.tell(said.status === "starting" ? STARTING : "");
    this.list.replaceChildren(faultList(faults, file));
    this.stage.show(still, (name) => this.image(name));
    say(this.lack, said.status === "reading" ? "the drawing follows; after installing, this takes a minute once" : lackOf(still));
  }

  /** @param {string} name */
  async image(name) {
    const said = await this.connection.ask({ do: "image", name });
    return said.ok ? `data:image/png;base64,${said.png}` : null;
  }

  /** @param {string} text */
  tell(text) {
    say(this.status, text);
    this.status.hidden = !text;
  }

  /** @param {import("../shared/tool.js").Place} place */
  picked({ left, top }) {
    const found = this.stage.selection.only;
    if (!found) return;
    this.card.replaceChildren(h("strong", {}, found.title), ...found.lines.map((line) => h("div", {}, line)));
    const box = this.stage.pane.canvas.getBoundingClientRect();
    this.card.style.left = `${Math.min(box.left + left + 14, innerWidth - 330)}px`;
    this.card.style.top = `${Math.min(box.top + top + 14, innerHeight - 150)}px`;
  }
}

/** Why there is less to see than one might expect.
 * @param {import("../simulator/messages.d.ts").Still | null} still */
function lackOf(still) {
  if (!still) return "nothing of this file can be drawn";
  const lacks = still.scene.map === null ? ["no map can be read"] : [];
  const placeless = still.robots.filter((pose) => !pose).length;
  const robots = placeless === 1 ? "1 robot gets its place" : `${placeless} robots get their places`;
  if (placeless) lacks.push(`${robots} when the simulation starts`);
  return lacks.join("; ");
}

const root = /** @type {HTMLElement & {faults?: FaultsPage}} */ (document.querySelector(".amorsim"));
root.faults = new FaultsPage(root);
