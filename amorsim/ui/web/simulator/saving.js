// What of the window is kept: the run, the scenario with its present parameters, a picture, a film.

import { Film, VIDEO, Video, download, savePicture } from "../shared/capture.js";
import { askName } from "../shared/dialogs.js";
import { say } from "../shared/dom.js";

export class Saving {
  /** @param {import("./simulator.js").Simulator} simulator */
  constructor(simulator) {
    this.simulator = simulator;
    /** @type {Film | Video | null} */
    this.film = null; // while one is recorded
  }

  /** The list of what can be saved stands below its button, and closes when one is chosen. */
  listen() {
    const { save, saveList } = this.simulator.parts;
    saveList.addEventListener("toggle", () => {
      const { right, bottom } = save.getBoundingClientRect();
      saveList.style.inset = `${bottom + 4}px ${Math.max(8, innerWidth - right)}px auto auto`;
    });
    saveList.addEventListener("click", () => saveList.hidePopover());
  }

  get fileName() {
    const { scene, newest } = this.simulator;
    return `${scene?.scenario.replace(/\.[a-z]+$/, "") ?? "amorsim"}-${(newest?.time ?? 0).toFixed(1)}s`;
  }

  async run() {
    const { simulator } = this;
    const places = await simulator.ask({ do: "places" });
    if (!places.ok) return;
    askName("Save the run", "folder", places.run, `As \`amorsim run\` leaves it, in ${places.project}`, async (name) => {
      const said = await simulator.connection.ask({ do: "save_run", name: name || null });
      if (said.ok) simulator.hint(`Saved as ${said.folder}.${said.same === false ? " It does not run the same again." : ""}`);
      return said;
    });
  }

  async scenario() {
    const { simulator } = this;
    const places = await simulator.ask({ do: "places" });
    if (!places.ok) return;
    askName("Save as a scenario", "file", places.scenario, `With the parameters as they are now, in ${places.project}`, async (file) => {
      const said = await simulator.connection.ask({ do: "save_scenario", name: file });
      if (said.ok) simulator.hint(`Saved as ${said.file}.`);
      return said;
    });
  }

  /** The run as one file that plays by itself. */
  async page() {
    const { simulator } = this;
    simulator.parts.page.disabled = true;
    simulator.hint("The page is being made.");
    const said = await simulator.ask({ do: "page" });
    simulator.parts.page.disabled = false;
    if (!said.ok) return;
    download(new Blob([said.page], { type: "text/html" }), `${this.fileName}.html`);
    simulator.hint("The page is among your downloads: it plays in any browser, without amorsim.");
  }

  picture() {
    const { stage } = this.simulator;
    return savePicture(stage.canvases, stage.theme, this.fileName);
  }

  /** Called after each drawing.
   * @param {number} now */
  look(now) {
    this.film?.look(now);
  }

  /** Begin to record the view, or end and keep it.
   * @param {"film" | "video"} kind */
  async toggle(kind) {
    const { stage, parts } = this.simulator;
    const { button, name, ending } =
      kind === "film"
        ? { button: parts.film, name: "GIF", ending: "gif" }
        : { button: parts.video, name: "video", ending: VIDEO?.startsWith("video/mp4") ? "mp4" : "webm" };
    const taken = this.film;
    button.setAttribute("aria-pressed", String(!taken));
    say(button, taken ? name : `stop ${name}`);
    if (taken) parts.saveList.append(parts.film, parts.video); // in their order
    else parts.save.before(button); // in sight until it is pressed again
    (kind === "film" ? parts.video : parts.film).disabled = !taken;
    if (!taken) {
      this.film = new (kind === "film" ? Film : Video)(stage.canvases, () => stage.theme);
      return;
    }
    this.film = null;
    if (taken.last < 0) {
      this.simulator.hint("Nothing was drawn meanwhile.");
      return;
    }
    this.simulator.hint(`The ${name} is being made.`);
    try {
      download(await taken.finish(), `${this.fileName}.${ending}`);
    } catch (problem) {
      this.simulator.hint(problem instanceof Error ? problem.message : String(problem));
    }
  }
}
