// What is asked of the server once something has changed: history, parameters, events, the simulation's state.

import { showControls } from "./controls.js";

const EVENTS_EVERY = 90; // milliseconds, at least
const PARAMETERS_AFTER = 120; // milliseconds: many changes at once are read once

export class Reader {
  /** @param {import("./simulator.js").Simulator} simulator */
  constructor(simulator) {
    this.simulator = simulator;
    this.readingEvents = false;
    /** @type {number | undefined} */
    this.parametersSoon = undefined;
  }

  async readHistory() {
    const { simulator } = this;
    const isStill = simulator.isStill();
    const said = await simulator.connection.ask({ do: "history", robot: simulator.robot.name, max_points: 3000 });
    if (!said.ok || !isStill()) return;
    said.true = said.true.map((/** @type {(number | null)[]} */ pose) => pose.map((value) => value ?? NaN)); // of a log nothing true is known
    simulator.stage.trueTrail.load(said.ticks, said.true);
    simulator.stage.estimatedTrail.load(said.ticks, said.estimated);
    simulator.record.load(said, simulator.scene.dt);
    simulator.stage.redraw();
  }

  async readParameters() {
    const { simulator } = this;
    const robot = simulator.robot;
    const said = await simulator.connection.ask({ do: "parameters", robot: robot.name });
    if (!said.ok || robot !== simulator.robot) return;
    simulator.form.show(said.parameters, said);
    simulator.stage.trueSensors = said.sensors;
    simulator.stage.redraw();
  }

  async readEvents() {
    const { simulator } = this;
    this.readingEvents = true;
    const said = await simulator.connection.ask({ do: "events", after: simulator.events.next });
    this.readingEvents = false;
    if (!said.ok) return;
    const isOfNow = said.epoch === undefined || said.epoch === simulator.epoch;
    if (isOfNow) this.addEvents(said.events);
    // What came while it was asked, or belongs to another course of events by now, no later frame may announce.
    if (simulator.newest.events > simulator.events.next) setTimeout(() => !this.readingEvents && this.readEvents(), EVENTS_EVERY);
  }

  /** @param {import("./messages.d.ts").EventLine[]} events */
  addEvents(events) {
    const { simulator } = this;
    if (simulator.scene.recorded) simulator.replay.mark(events.filter((event) => event.number > simulator.events.next), Number(simulator.timebar.line.max));
    simulator.events.add(events);
    if (events.some((event) => /parameter|restore/.test(event.kind))) this.readParameters();
  }

  async readState() {
    const { simulator } = this;
    const state = await simulator.connection.ask({ do: "state" });
    if (!state.ok) return;
    if (state.moved) {
      location.replace(state.moved);
      return;
    }
    simulator.state = state;
    simulator.timebar.setState(state);
    simulator.warnings.show(state);
    showControls(simulator);
  }

  /** @param {any} said */
  readParametersSoon(said) {
    clearTimeout(this.parametersSoon);
    this.parametersSoon = setTimeout(() => this.readParameters(), PARAMETERS_AFTER);
    return said;
  }
}
