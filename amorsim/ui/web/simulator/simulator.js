// The Simulator's window: elements, connection and what the one says to the other.

import { tell } from "../shared/dialogs.js";
import { listenToClicks } from "./clicks.js";
import { h, say } from "../shared/dom.js";
import { Driving } from "./drive.js";
import { Events } from "./events.js";
import { takeFrame } from "./frames.js";
import { Fleet } from "./fleet.js";
import { Futures } from "./futures.js";
import { Form } from "../shared/forms.js";
import { listenToKeys } from "./keys.js";
import { build } from "./layout.js";
import { Numbers } from "./numbers.js";
import { goTo, picked } from "./pointing.js";
import { Plots } from "./plots.js";
import { readFrame } from "./protocol.js";
import { Reader } from "./reader.js";
import { Record } from "./record.js";
import { Saving } from "./saving.js";
import { Replay } from "./replay.js";
import { readScene } from "../shared/scene.js";
import { Stage } from "./stage.js";
import { startTheme } from "../shared/theme.js";
import { TimeBar } from "./timebar.js";
import { Warnings } from "./warnings.js";

const TABLE_EVERY = 90; // milliseconds: faster nobody reads
const LARGE = 1.8; // how much larger its lines and its type are

export class Simulator {
  /** @param {HTMLElement} root
   * @param {(on: import("../shared/socket.js").Heard) => any} connect makes the connection: `Connection`, or what answers and plays in its place */
  constructor(root, connect) {
    this.root = root;
    /** What is simulated. @type {any} */
    this.scene = null;
    /** The newest frame, and one that came before its scene. @type {any} */
    this.newest = undefined;
    /** @type {ArrayBuffer | null} */
    this.early = null;
    /** The course of events, and the robot that is selected in it. @type {number | undefined} */
    this.epoch = undefined;
    this.selected = -1;
    /** @type {any} */
    this.robot = undefined;
    /** The moment in the past whose parameters the form shows, -1 for now. @type {number | undefined} */
    this.moment = undefined;
    /** How the simulation stands, as frames tell it. @type {number | undefined} */
    this.states = undefined;
    /** The same in full, as the server tells it. @type {any} */
    this.state = undefined;
    /** Whether this window has the controls. @type {boolean | undefined} */
    this.isMine = undefined;
    /** Its name with the server. */
    this.window = "";
    /** The frame that was not drawn yet. @type {number | undefined} */
    this.unacknowledged = undefined;
    this.toggleTheme = startTheme(root);
    const ask = (/** @type {any} */ command) => this.ask(command);
    this.stage = new Stage(root, {
      ask: (command) => this.connection.ask(command),
      picked: (pane, place) => picked(this, pane, place),
      option: (name, value) => this.showOption(name, value),
      boxed: (robots) => this.listRobots(robots),
      drawn: (frame, isNew, now, began) => this.drawn(frame, isNew, now, began),
    });
    this.timebar = new TimeBar(ask);
    this.driving = new Driving(ask, (text) => this.hint(text));
    this.replay = new Replay(ask, (event) => goTo(this, event));
    const change = (/** @type {object} */ command) => this.connection.ask({ ...command, robot: this.robot.name }).then((/** @type {any} */ said) => this.reader.readParametersSoon(said));
    this.form = new Form({
      ask: (/** @type {any} */ command) => this.connection.ask(command),
      set: (/** @type {string} */ path, /** @type {any} */ value) => change({ do: "set", path, value }),
      restore: (/** @type {string} */ path) => change({ do: "restore", path }),
      add: (/** @type {string} */ path, /** @type {any} */ value) => change({ do: "add", path, value }),
      remove: (/** @type {string} */ path) => change({ do: "remove", path }),
      noises: (/** @type {string} */ path, /** @type {any} */ value) => this.ask({ do: "noises", path, robot: this.robot.name, ...(value ? { value } : {}) }),
    });
    this.reader = new Reader(this);
    this.fleet = new Fleet((robot) => this.ask({ do: "select", robot }));
    this.futures = new Futures({ ask, changed: () => this.showFutures() });
    this.parts = build(this);
    root.replaceChildren(this.parts.element);
    this.numbers = new Numbers(this.parts.table, { plot: (key) => this.plots.choose(key), add: (key) => this.plots.add(key) });
    this.record = new Record(null);
    this.plots = new Plots(this.parts.plots, this.parts.plotHead, {
      changed: () => this.drawNumbers(),
      zoomed: (zoom) => this.stage.showTimes(zoom),
      fileName: () => this.saving.fileName,
    });
    this.events = new Events(this.parts.events, {
      go: (/** @type {import("./messages.d.ts").EventLine} */ event) => goTo(this, event),
      stack: (/** @type {import("./messages.d.ts").EventLine} */ event) => tell("What the controller raised", h("pre", { tabindex: "0" }, event.stack)),
    });
    this.stage.selection.listen((selection) => (this.parts.card.hidden = !selection.only));
    this.warnings = new Warnings(this.parts.banner, ask);
    this.saving = new Saving(this);
    /** [ms] @type {{draws: number[], intervals: number[]}} */
    this.timings = { draws: [], intervals: [] };
    listenToClicks(this);
    listenToKeys(this);
    this.connection = connect({
      frame: (/** @type {ArrayBuffer} */ buffer) => takeFrame(this, buffer),
      news: (/** @type {any} */ message) => this.newsCame(message),
      open: () => this.opened(),
      lost: (/** @type {number} */ attempts) => this.warnings.show({ status: "lost", attempts }),
    });
    for (const [name, value] of Object.entries(this.stage.options)) this.showOption(name, value);
  }

  // ------------------------------------------------------------------------------------------------- what comes in

  opened() {
    this.warnings.show({ status: "" });
    this.scene = null;
    this.loadScene();
  }

  async loadScene() {
    if (this.loading) return;
    this.loading = true;
    const said = await this.connection.ask({ do: "scene" });
    this.loading = false;
    if (!said.ok) return;
    this.scene = readScene(said.scene);
    this.selected = -1;
    this.epoch = undefined;
    say(this.parts.scenario, this.scene.scenario);
    this.parts.scenario.title = this.scene.scenario;
    document.title = `${this.scene.scenario} · amorsim`;
    this.parts.robot.replaceChildren(...this.scene.robots.map((/** @type {import("../shared/scene.js").Robot} */ robot, /** @type {number} */ i) => h("option", { value: String(i) }, robot.name)));
    this.stage.setScene(this.scene, (name) => this.image(name));
    this.fleet.setScene(this.scene);
    this.parts.fleet.hidden = this.scene.robots.length < 2;
    this.parts.arrangement.load(this.scene.scenario);
    if (this.scene.recorded) this.setRecorded();
    this.reader.readState();
    // A frame that came before its scene may be the last for long: while nothing moves there is no other.
    const { early } = this;
    this.early = null;
    if (early && readFrame(early, this.scene).version === this.scene.version) takeFrame(this, early);
  }

  /** Nothing of a recorded run can be changed, and it has a page of its own in the place of the errors. */
  setRecorded() {
    this.root.classList.add("recorded");
    document.title = `${this.scene.scenario}, recorded · amorsim`;
    this.driving.isOff = true;
    this.timebar.setRecorded(this.replay.marks);
    this.replay.show(this.scene);
    this.nameWorld();
  }

  /** @param {string} name */
  async image(name) {
    const said = await this.connection.ask({ do: "image", name });
    return said.ok ? `data:image/png;base64,${said.png}` : null;
  }

  /** A function that tells later whether the robot and the course of events are still those of now. */
  isStill() {
    const [epoch, selected] = [this.epoch, this.selected];
    return () => epoch === this.epoch && selected === this.selected;
  }

  showFutures() {
    this.plots.futures = this.stage.futures = this.futures.list;
    if (this.scene) this.stage.showTimes(this.plots.zoom);
    this.drawNumbers();
  }

  /** List the robots that a box was drawn around, or all; of a single robot there is no list.
   * @param {any} robots */
  listRobots(robots) {
    if (this.scene.robots.length < 2) return;
    this.fleet.only(robots?.length ? robots : null);
    if (this.fleet.element.hidden) this.toggleFleet();
  }

  toggleFleet() {
    if (this.scene.robots.length < 2) return;
    this.fleet.toggle();
    this.parts.fleet.setAttribute("aria-pressed", String(!this.fleet.element.hidden));
  }

  /** @param {any} message */
  newsCame(message) {
    if (message.window) this.window = message.window;
  }

  // ------------------------------------------------------------------------------------------------ what goes out

  /** Say a command; what went wrong is shown.
   * @param {any} command */
  async ask(command) {
    const said = await this.connection.ask(command);
    if (!said.ok) this.hint(said.error);
    return said;
  }

  async restoreAll() {
    const said = await this.ask({ do: "restore", robot: this.robot.name });
    if (said.ok) this.form.forget();
    this.reader.readParametersSoon(said);
  }

  /** @param {number} step */
  nextRobot(step) {
    if (!this.scene || this.scene.robots.length < 2) return;
    const count = this.scene.robots.length;
    this.ask({ do: "select", robot: (this.selected + step + count) % count });
  }

  // --------------------------------------------------------------------------------------------------- what is shown

  /** @param {import("./messages.d.ts").Frame | undefined} frame
   * @param {boolean} isNew
   * @param {number} now
   * @param {number} began */
  drawn(frame, isNew, now, began) {
    if (!frame) return;
    if (now - (this.tableAt ?? 0) > TABLE_EVERY || !isNew) {
      this.tableAt = now;
      if (isNew) this.showNumbers(frame);
      this.drawNumbers();
    }
    this.saving.look(now);
    if (!isNew) return;
    this.connection.drawn(this.unacknowledged);
    this.timings.draws.push(performance.now() - began);
    if (this.drawnAt !== undefined) this.timings.intervals.push(now - this.drawnAt);
    this.drawnAt = now;
    for (const list of Object.values(this.timings)) if (list.length > 3000) list.splice(0, 1500);
    // What comes between two looks at the table must be shown at the end, too.
    clearTimeout(this.tableSoon);
    this.tableSoon = setTimeout(() => {
      this.showNumbers(frame);
      this.drawNumbers();
    }, 2 * TABLE_EVERY);
  }

  /** @param {import("./messages.d.ts").Frame} frame */
  showNumbers(frame) {
    this.numbers.show(frame);
    this.futures.show(frame);
    this.fleet.show(frame);
    say(this.stage.control.note, this.numbers.velocities(frame));
  }

  drawNumbers() {
    this.numbers.mark(this.plots.keys);
    if (this.stage.frame) this.plots.draw(this.stage.theme, this.stage.frame);
  }

  /** @param {string} name
   * @param {boolean} value */
  showOption(name, value) {
    this.parts.tools.get(name)?.setAttribute("aria-pressed", String(value));
    if (name !== "overlay") return;
    this.parts.element.classList.toggle("overlaid", value);
    const { knownTools } = this.parts; // they go where what they switch is seen
    (value ? this.parts.robotHead : this.parts.controlHead).append(knownTools);
    (value ? this.stage.robot : this.stage.control).element.append(this.fleet.element);
    this.nameWorld();
  }

  /** The head of the left pane; of a log nothing true is known. */
  nameWorld() {
    const [name, note] = this.scene?.recorded?.log ? ["Map", "at the end of the log"] : ["Robot", "what is true"];
    const isBoth = this.stage.options.overlay;
    say(this.parts.robotName, isBoth ? `${name} and Control` : name);
    say(this.parts.robotNote, isBoth ? `${note}, and over it what it knows` : note);
  }

  get isLecture() {
    return this.root.classList.contains("lecture");
  }

  /** Two panes and a plot, large, for a class to see from the last row.
   * @param {boolean} isOn */
  setLecture(isOn) {
    this.root.classList.toggle("lecture", isOn);
    this.parts.lecture.setAttribute("aria-pressed", String(isOn));
    const { robot, control } = this.stage;
    robot.magnify = control.magnify = isOn ? LARGE : 1;
    this.plots.setMagnify(isOn ? LARGE : 1);
    this.stage.resize();
    this.drawNumbers();
  }

  /** @param {string | undefined} text */
  hint(text) {
    say(this.parts.hint, text ?? "");
    clearTimeout(this.hintGone);
    this.hintGone = setTimeout(() => say(this.parts.hint, ""), 5000);
  }
}
