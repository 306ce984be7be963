// The Simulator's window: elements, connection and what the one says to the other.

import { tell } from "../shared/dialogs.js";
import { leadBack } from "./back.js";
import { colourChip, fixed, h, say } from "../shared/dom.js";
import { Driving } from "./drive.js";
import { Events } from "./events.js";
import { Fleet } from "./fleet.js";
import { Futures } from "./futures.js";
import { Form } from "../shared/forms.js";
import { showKeys } from "./key_list.js";
import { listenToKeys } from "./keys.js";
import { BELIEFS, build } from "./layout.js";
import { Numbers } from "./numbers.js";
import { Plots } from "./plots.js";
import { FLAG, ROBOT, readFrame } from "./protocol.js";
import { isDrawn } from "./readings.js";
import { Record } from "./record.js";
import { Saving } from "./saving.js";
import { Replay } from "./replay.js";
import { readScene } from "../shared/scene.js";
import { Stage } from "./stage.js";
import { startTheme } from "../shared/theme.js";
import { TimeBar } from "./timebar.js";
import { Warnings } from "./warnings.js";

const TABLE_EVERY = 90; // milliseconds: faster nobody reads
const STATE_EVERY = 1000;
const LECTURE = "#lecture"; // ends the address of a window that is shown to a class
const LARGE = 1.8; // how much larger its lines and its type are

export class Simulator {
  /** @param {HTMLElement} root
   * @param {(on: object) => any} connect makes the connection: `Connection`, or what answers and plays in its place */
  constructor(root, connect) {
    this.root = root;
    this.toggleTheme = startTheme(root);
    const ask = (command) => this.ask(command);
    this.stage = new Stage(root, {
      ask: (command) => this.connection.ask(command),
      picked: (pane, place) => this.picked(pane, place),
      option: (name, value) => this.showOption(name, value),
      boxed: (robots) => this.listRobots(robots),
      drawn: (...what) => this.drawn(...what),
    });
    this.timebar = new TimeBar(ask);
    this.driving = new Driving(ask, (text) => this.hint(text));
    this.replay = new Replay(ask, (event) => this.go(event));
    const change = (command) => this.connection.ask({ ...command, robot: this.robot.name }).then((said) => this.formSaid(said));
    this.form = new Form({
      ask: (command) => this.connection.ask(command),
      set: (path, value) => change({ do: "set", path, value }),
      restore: (path) => change({ do: "restore", path }),
      add: (path, value) => change({ do: "add", path, value }),
      remove: (path) => change({ do: "remove", path }),
      noises: (path, value) => this.ask({ do: "noises", path, robot: this.robot.name, ...(value ? { value } : {}) }),
    });
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
      go: (event) => this.go(event),
      stack: (event) => tell("What the controller raised", h("pre", { tabindex: "0" }, event.stack)),
    });
    this.stage.selection.listen((selection) => (this.parts.card.hidden = !selection.only));
    this.warnings = new Warnings(this.parts.banner, ask);
    this.saving = new Saving(this);
    this.timings = { draws: [], intervals: [] };
    this.listen();
    this.connection = connect({
      frame: (buffer) => this.frameCame(buffer),
      news: (message) => this.newsCame(message),
      open: () => this.opened(),
      lost: (attempts) => this.warnings.show({ status: "lost", attempts }),
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
    this.parts.robot.replaceChildren(...this.scene.robots.map((robot, i) => h("option", { value: String(i) }, robot.name)));
    this.stage.setScene(this.scene, (name) => this.image(name));
    this.fleet.setScene(this.scene);
    this.parts.fleet.hidden = this.scene.robots.length < 2;
    this.parts.arrangement.load(this.scene.scenario);
    if (this.scene.recorded) this.setRecorded();
    this.askState();
    // A frame that came before its scene may be the last for long: while nothing moves there is no other.
    const { early } = this;
    this.early = null;
    if (early && readFrame(early, this.scene).version === this.scene.version) this.frameCame(early);
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

  async image(name) {
    const said = await this.connection.ask({ do: "image", name });
    return said.ok ? `data:image/png;base64,${said.png}` : null;
  }

  frameCame(buffer) {
    const frame = readFrame(buffer, this.scene);
    this.newest = frame;
    if (!this.scene || frame.version !== this.scene.version) {
      this.early = buffer;
      this.loadScene();
      this.connection.drawn(frame.number);
      return;
    }
    if (frame.epoch !== this.epoch || frame.selected !== this.selected) this.turn(frame);
    this.stage.setFrame(frame);
    this.showBeliefs(frame);
    const isRecorded = Boolean(this.scene.recorded);
    if (!isRecorded && !(frame.states & (FLAG.scrubbed | FLAG.posesOnly))) this.record.add(frame);
    this.timebar.show(frame, this.scene);
    if (!isRecorded) this.showPast(frame);
    this.driving.isRunning = Boolean(frame.states & FLAG.running);
    if (!isRecorded) this.driving.setByHand(Boolean(frame.flags[frame.selected] & ROBOT.byHand));
    this.unacknowledged = frame.number;
    if (frame.events > this.events.next && !this.readingEvents) this.readEvents();
    if (frame.states !== this.states) {
      this.askState();
      if (frame.states & FLAG.ended) this.hint(isRecorded ? "This is the end of the recording." : "The scenario's duration is over; run continues beyond it.");
      if (frame.states & FLAG.running) this.hint(""); // no need to say how to run it
      if (this.states === undefined && !frame.tick && !(frame.states & FLAG.running)) this.hint("Press Space to run, ? for all keys.");
    }
    this.states = frame.states;
  }

  /** In the past the form shows the values of that moment, and nothing can be set before one goes on from there. */
  showPast(frame) {
    const isPast = Boolean(frame.states & FLAG.scrubbed);
    const moment = isPast ? frame.tick : -1;
    if (moment === this.moment) return;
    this.moment = moment;
    this.form.forget();
    this.form.element.inert = isPast;
    this.parts.formNote.hidden = !isPast;
    const whose = frame.states & FLAG.posesOnly ? "The newest values: of this moment only poses are kept" : `The values at ${fixed(frame.time, 1)} s`;
    say(this.parts.formNote, isPast ? `${whose}. To change them, continue here.` : "");
    this.formSaid();
  }

  /** Another robot, or another course of events: what was kept of the one before goes, its history comes. */
  turn(frame) {
    const isOther = frame.selected !== this.selected;
    if (frame.epoch !== this.epoch) {
      this.events.clear();
      this.replay.clear();
      this.stage.mark = null; // in this course of events it has not happened
    }
    this.epoch = frame.epoch;
    this.selected = frame.selected;
    this.robot = this.scene.robots[frame.selected];
    this.stage.clearTrails();
    this.stage.trueSensors = [];
    if (isOther && this.robot) this.showRobot();
    this.record.clear();
    this.readHistory();
    if (!this.scene.recorded) {
      this.readParameters();
      this.futures.read(this.robot, this.scene.dt, this.isStill());
    }
    this.readEvents();
  }

  showRobot() {
    this.parts.robot.value = String(this.selected);
    const chip = () => (this.robot.colour ? colourChip(this.robot.colour) : null);
    this.parts.errorsTitle.replaceChildren(...[chip(), `Errors of ${this.robot.name}`].filter(Boolean));
    this.parts.numbersTitle.replaceChildren(...[chip(), this.robot.name].filter(Boolean));
    this.parts.plotTitle.replaceChildren(...[chip(), "Over time"].filter(Boolean));
    const lack = this.robot.knowledge ? "" : `${this.robot.name} has no map (robots.knowledge.map)`;
    say(this.stage.control.lack, lack);
    this.record = new Record(this.robot);
    this.futures.clear();
    this.numbers.setQuantities(this.record.quantities);
    this.plots.setRecord(this.record);
    this.driving.setRobot(this.robot);
    const ranges = this.robot.sensors.filter(isDrawn);
    this.parts.sensors.replaceChildren(
      ...ranges.map((sensor) => {
        const button = h("button", { class: "tool", "aria-pressed": String(!this.stage.hidden.has(sensor.name)) }, sensor.name);
        button.addEventListener("click", () => {
          const { hidden } = this.stage;
          const shows = hidden.delete(sensor.name);
          if (!shows) hidden.add(sensor.name);
          button.setAttribute("aria-pressed", String(shows));
          this.stage.redraw();
        });
        return button;
      }),
    );
  }

  /** Switches for what the selected robot's estimator believes, where it believes any. */
  showBeliefs(frame) {
    for (const [name, count] of BELIEFS) {
      const button = this.parts.tools.get(name);
      if (!frame[count]) button.remove();
      else if (!button.isConnected) this.parts.sensors.append(button);
    }
  }

  async readHistory() {
    const isStill = this.isStill();
    const said = await this.connection.ask({ do: "history", robot: this.robot.name, max_points: 3000 });
    if (!said.ok || !isStill()) return;
    said.true = said.true.map((pose) => pose.map((value) => value ?? NaN)); // of a log nothing true is known
    this.stage.trueTrail.load(said.ticks, said.true);
    this.stage.estimatedTrail.load(said.ticks, said.estimated);
    this.record.load(said, this.scene.dt);
    this.stage.redraw();
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

  /** List the robots that a box was drawn around, or all; of a single robot there is no list. */
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

  async readParameters() {
    const robot = this.robot;
    const said = await this.connection.ask({ do: "parameters", robot: robot.name });
    if (!said.ok || robot !== this.robot) return;
    this.form.show(said.parameters, said);
    this.stage.trueSensors = said.sensors;
    this.stage.redraw();
  }

  async readEvents() {
    this.readingEvents = true;
    const said = await this.connection.ask({ do: "events", after: this.events.next });
    this.readingEvents = false;
    if (!said.ok) return;
    const isOfNow = said.epoch === undefined || said.epoch === this.epoch;
    if (isOfNow) this.addEvents(said.events);
    // What came while it was asked, or belongs to another course of events by now, no later frame may announce.
    if (this.newest.events > this.events.next) setTimeout(() => !this.readingEvents && this.readEvents(), TABLE_EVERY);
  }

  addEvents(events) {
    if (this.scene.recorded) this.replay.mark(events.filter((event) => event.number > this.events.next), Number(this.timebar.line.max));
    this.events.add(events);
    if (events.some((event) => /parameter|restore/.test(event.kind))) this.readParameters();
  }

  async askState() {
    const state = await this.connection.ask({ do: "state" });
    if (!state.ok) return;
    if (state.moved) {
      location.replace(state.moved);
      return;
    }
    this.state = state;
    this.timebar.setState(state);
    this.warnings.show(state);
    this.showControls();
  }

  newsCame(message) {
    if (message.window) this.window = message.window;
  }

  // ------------------------------------------------------------------------------------------------ what goes out

  /** Say a command; what went wrong is shown. */
  async ask(command) {
    const said = await this.connection.ask(command);
    if (!said.ok) this.hint(said.error);
    return said;
  }

  async restoreAll() {
    const said = await this.ask({ do: "restore", robot: this.robot.name });
    if (said.ok) this.form.forget();
    this.formSaid(said);
  }

  formSaid(said) {
    clearTimeout(this.parametersSoon);
    this.parametersSoon = setTimeout(() => this.readParameters(), 120);
    return said;
  }

  async go(event) {
    if (event.point) {
      this.stage.mark = { point: event.point, tick: event.tick };
      this.stage.setOption("follow", false);
      this.stage.camera.centre(...event.point);
    }
    const index = this.scene.robots.findIndex((robot) => robot.name === event.robot);
    if (index >= 0 && index !== this.selected) await this.ask({ do: "select", robot: index });
    if (this.newest.tick !== event.tick) await this.ask({ do: "scrub", tick: event.tick });
  }

  /** Something was pointed at, or nothing: tell what it is, and turn to a robot. */
  picked(pane, { left, top }) {
    const found = this.stage.selection.only;
    if (!found) return;
    this.parts.card.replaceChildren(h("strong", {}, found.title), ...found.lines.map((line) => h("div", {}, line)));
    const box = pane.canvas.getBoundingClientRect();
    const { magnify } = pane;
    this.parts.card.style.left = `${Math.min(box.left + left * magnify + 14, innerWidth - 330)}px`;
    this.parts.card.style.top = `${Math.min(box.top + top * magnify + 14, innerHeight - 150)}px`;
    if (found.robot !== undefined && found.robot !== this.selected) this.ask({ do: "select", robot: found.robot });
  }

  nextRobot(step) {
    if (!this.scene || this.scene.robots.length < 2) return;
    const count = this.scene.robots.length;
    this.ask({ do: "select", robot: (this.selected + step + count) % count });
  }

  // --------------------------------------------------------------------------------------------------- what is shown

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

  showControls() {
    const { holder, asking = [] } = this.state;
    const isMine = holder === this.window;
    if (this.isMine !== undefined && isMine !== this.isMine) {
      if (isMine) this.hint("You have the controls now.");
      else this.hint(holder ? "Another window has the controls now. You watch." : "You do not have the controls any more.");
    }
    this.isMine = isMine;
    this.root.classList.toggle("watching", !this.isMine);
    const { reset, run, step, speed, line, toEnd } = this.timebar;
    for (const one of [reset, run, step, speed, line, toEnd, this.driving.switch]) one.disabled = !this.isMine;
    if (!this.isMine) this.timebar.carryOn.disabled = true;
    this.parts.controls.hidden = this.isMine && !asking.length;
    let words = "another window asks: give it the controls";
    if (!this.isMine) words = holder ? "you watch: ask for the controls" : "take the controls";
    if (asking.includes(this.window)) words = "you watch: asked for the controls";
    say(this.parts.controls, words);
  }

  get isLecture() {
    return this.root.classList.contains("lecture");
  }

  /** Two panes and a plot, large, for a class to see from the last row. */
  setLecture(isOn) {
    this.root.classList.toggle("lecture", isOn);
    this.parts.lecture.setAttribute("aria-pressed", String(isOn));
    const { robot, control } = this.stage;
    robot.magnify = control.magnify = isOn ? LARGE : 1;
    this.plots.setMagnify(isOn ? LARGE : 1);
    this.stage.resize();
    this.drawNumbers();
  }

  hint(text) {
    say(this.parts.hint, text ?? "");
    clearTimeout(this.hintGone);
    this.hintGone = setTimeout(() => say(this.parts.hint, ""), 5000);
  }

  // ---------------------------------------------------------------------------------------------------- what is clicked

  listen() {
    const { parts, stage } = this;
    for (const [name, button] of parts.tools) button.addEventListener("click", () => stage.setOption(name, !stage.options[name]));
    parts.zoom.in.addEventListener("click", () => stage.camera.zoom(1.3));
    parts.zoom.out.addEventListener("click", () => stage.camera.zoom(1 / 1.3));
    parts.zoom.fit.addEventListener("click", () => stage.fit());
    parts.robot.addEventListener("change", () => this.ask({ do: "select", robot: Number(parts.robot.value) }));
    parts.fleet.addEventListener("click", () => this.toggleFleet());
    parts.asAtFirst.addEventListener("click", () => parts.arrangement.reset());
    parts.theme.addEventListener("click", () => this.toggleTheme());
    parts.lecture.addEventListener("click", () => this.setLecture(!this.isLecture));
    if (location.hash === LECTURE) this.setLecture(true);
    parts.keys.addEventListener("click", () => showKeys(this.timebar.isRecorded));
    parts.asInFile.addEventListener("click", () => this.restoreAll());
    parts.controls.addEventListener("click", () => this.askControls());
    leadBack(parts.editor);
    parts.saveRun.addEventListener("click", () => this.saving.run());
    parts.page.addEventListener("click", () => this.saving.page());
    parts.saveScenario.addEventListener("click", () => this.saving.scenario());
    parts.picture.addEventListener("click", () => this.saving.picture());
    parts.film.addEventListener("click", () => this.saving.toggle("film"));
    parts.video.addEventListener("click", () => this.saving.toggle("video"));
    listenToKeys(this);
    setInterval(() => !document.hidden && this.connection.isOpen && this.askState(), STATE_EVERY);
  }

  askControls() {
    return this.ask({ do: "controls", want: this.isMine ? "give" : "ask", to: this.isMine ? this.state.asking[0] : undefined }).then(() => this.askState());
  }
}
