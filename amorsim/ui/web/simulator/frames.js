// Frames, as they come from the server: each is shown, and tells when something else has to be read.

import { fixed, say } from "../shared/dom.js";
import { FLAG, ROBOT, readFrame } from "./protocol.js";
import { showBeliefs, showRobot } from "./robot_head.js";

/** @typedef {import("./simulator.js").Simulator} Simulator */

/** Show a frame, once its scene is there.
 * @param {Simulator} simulator
 * @param {ArrayBuffer} buffer */
export function takeFrame(simulator, buffer) {
  const frame = readFrame(buffer, simulator.scene);
  simulator.newest = frame;
  if (!simulator.scene || frame.version !== simulator.scene.version) {
    simulator.early = buffer;
    simulator.loadScene();
    simulator.connection.drawn(frame.number);
    return;
  }
  if (frame.epoch !== simulator.epoch || frame.selected !== simulator.selected) turn(simulator, frame);
  simulator.stage.setFrame(frame);
  showBeliefs(simulator, frame);
  const isRecorded = Boolean(simulator.scene.recorded);
  if (!isRecorded && !(frame.states & (FLAG.scrubbed | FLAG.posesOnly))) simulator.record.add(frame);
  simulator.timebar.show(frame, simulator.scene);
  if (!isRecorded) showPast(simulator, frame);
  simulator.driving.isRunning = Boolean(frame.states & FLAG.running);
  if (!isRecorded) simulator.driving.setByHand(Boolean(frame.flags[frame.selected] & ROBOT.byHand));
  simulator.unacknowledged = frame.number;
  if (frame.events > simulator.events.next && !simulator.reader.readingEvents) simulator.reader.readEvents();
  if (frame.states !== simulator.states) {
    simulator.reader.readState();
    if (frame.states & FLAG.ended) simulator.hint(isRecorded ? "This is the end of the recording." : "The scenario's duration is over; run continues beyond it.");
    if (frame.states & FLAG.running) simulator.hint(""); // no need to say how to run it
    if (simulator.states === undefined && !frame.tick && !(frame.states & FLAG.running)) simulator.hint("Press Space to run, ? for all keys.");
  }
  simulator.states = frame.states;
}

/** In the past the form shows the values of that moment, and nothing can be set before one goes on from there.
 * @param {Simulator} simulator
 * @param {any} frame */
function showPast(simulator, frame) {
  const isPast = Boolean(frame.states & FLAG.scrubbed);
  const moment = isPast ? frame.tick : -1;
  if (moment === simulator.moment) return;
  simulator.moment = moment;
  simulator.form.forget();
  simulator.form.element.inert = isPast;
  simulator.parts.formNote.hidden = !isPast;
  const whose = frame.states & FLAG.posesOnly ? "The newest values: of this moment only poses are kept" : `The values at ${fixed(frame.time, 1)} s`;
  say(simulator.parts.formNote, isPast ? `${whose}. To change them, continue here.` : "");
  simulator.reader.readParametersSoon({ ok: true });
}

/** Another robot, or another course of events: what was kept of the one before goes, its history comes.
 * @param {Simulator} simulator
 * @param {any} frame */
function turn(simulator, frame) {
  const isOther = frame.selected !== simulator.selected;
  if (frame.epoch !== simulator.epoch) {
    simulator.events.clear();
    simulator.replay.clear();
    simulator.stage.mark = null; // in this course of events it has not happened
  }
  simulator.epoch = frame.epoch;
  simulator.selected = frame.selected;
  simulator.robot = simulator.scene.robots[frame.selected];
  simulator.stage.clearTrails();
  simulator.stage.trueSensors = [];
  if (isOther && simulator.robot) showRobot(simulator);
  simulator.record.clear();
  simulator.reader.readHistory();
  if (!simulator.scene.recorded) {
    simulator.reader.readParameters();
    simulator.futures.read(simulator.robot, simulator.scene.dt, simulator.isStill());
  }
  simulator.reader.readEvents();
}
