// A recorded run that the page itself holds. It stands in for the connection with a server: it answers the commands that
// look at a recorded run or move in its time, and sends frames.

import { Table } from "./packed.js";
import { FLAG, writeFrame } from "./protocol.js";
import { BLOCKS } from "./wire.js";

const LONGEST = 0.25; // seconds of real time that one picture may make up for: a tab in the background stands still
const MOST_OF_PATH = 2000; // places of it
const OF_BODIES = ["truePoses", "estimatedPoses", "covariances", "obstacles", "flags"];
const CLOUDS = ["particles", "hypotheses"];
const OF_ROBOT = BLOCKS.map(([name]) => name).filter((name) => ![...OF_BODIES, ...CLOUDS].includes(name));

const inPython = (/** @type {string} */ name) => name.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);

/** The last place whose tick is at most `tick`; -1 where there is none.
 * @param {number} tick
 * @param {number} count
 * @param {(place: number) => number} tickAt */
function lastAt(tick, count, tickAt) {
  let [low, high] = [0, count];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (tickAt(middle) <= tick) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}

export class RecordedRun {
  /**
   * @param {{frame(buffer: ArrayBuffer): void, open(): void}} on
   * @param {{head: any, bytes: Uint8Array}} contents
   */
  constructor(on, { head, bytes }) {
    this.on = on;
    this.head = head;
    this.bytes = bytes;
    this.ticks = head.ticks;
    this.dt = head.scene.dt;
    this.tables = new Map();
    this.robot = 0;
    this.place = 0; // of the moment that is shown
    this.speed = 1;
    this.number = 0;
    this.isRunning = false;
    this.time = 0; // [s] of the run, as it plays
    /** When it began to play, and the time then. @type {{now: number, time: number} | null} */
    this.since = null;
    this.isOpen = true;
    /** @type {Record<string, ((command: any) => any) | undefined>} */
    this.doing = {
      scene: () => ({ scene: head.scene }),
      image: (/** @type {any} */ { name }) => ({ png: head.images[name] }),
      state: () => this.state(),
      history: (/** @type {any} */ { robot }) => this.history(this.numberOf(robot)),
      events: (/** @type {any} */ { after }) => ({ epoch: head.epoch, events: head.events.slice(after ?? 0), next: head.events.length }),
      mapped: (/** @type {any} */ { robot }) => ({ mapped: this.believed("mapped", this.numberOf(robot)) }),
      intended: (/** @type {any} */ { robot }) => ({ intended: this.believed("intended", this.numberOf(robot))[0] ?? {} }),
      select: (/** @type {any} */ { robot }) => this.show(this.place, this.numberOf(robot)),
      run: () => this.run(),
      pause: () => this.pause(),
      step: () => this.move(this.place + 1),
      scrub: (/** @type {any} */ { tick }) => this.move(lastAt(tick ?? head.newest, this.ticks.length, (place) => this.ticks[place])),
      speed: (/** @type {any} */ { factor }) => this.setSpeed(factor ?? Infinity),
      controls: () => ({}),
    };
    queueMicrotask(() => {
      on.open();
      this.show(0);
    });
  }

  /** Carry out a command; a promise of its answer, as of a server's.
   * @param {import("./messages.d.ts").Command} command */
  ask(command) {
    const does = this.doing[command.do];
    const refusal = { ok: false, error: "This page shows what was recorded: nothing in it can be changed." };
    return Promise.resolve(does ? { ok: true, ...does(command) } : refusal);
  }

  /** A frame was drawn: nothing waits for that, as frames are made as fast as pictures are shown. */
  drawn() {}

  // ---------------------------------------------------------------------------------------------------------- looking

  /** @param {any} robot */
  numberOf(robot) {
    return typeof robot === "string" ? this.head.scene.robots.findIndex((/** @type {{name: string}} */ one) => one.name === robot) : robot;
  }

  /** @param {any} series */
  table(series) {
    if (!this.tables.has(series)) this.tables.set(series, new Table(this.bytes, series));
    return this.tables.get(series);
  }

  state() {
    const { scene, epoch, newest, damage } = this.head;
    const tick = this.ticks[this.place];
    return {
      ok: true,
      version: scene.version,
      epoch,
      status: this.isRunning ? "running" : this.isAtEnd ? "ended" : "paused",
      tick,
      newest,
      time: tick * this.dt,
      can_continue: true,
      fault: null,
      damage,
    };
  }

  get isAtEnd() {
    return this.place === this.ticks.length - 1;
  }

  /** @param {number} robot */
  history(robot) {
    const { epoch, robots, bodies } = this.head;
    const ticks = /** @type {number[]} */ (this.head.ticks);
    const every = Math.ceil(ticks.length / MOST_OF_PATH);
    const places = Array.from(ticks.keys()).filter((place) => place % every === 0);
    const poses = (/** @type {string} */ name) => places.map((place) => Array.from(this.table(bodies[name]).row(place).subarray(3 * robot, 3 * robot + 3)));
    return {
      epoch,
      ticks: places.map((place) => ticks[place]),
      true: poses("true_poses"),
      estimated: poses("estimated_poses"),
      past: robots[robot] ? this.past(robots[robot].past) : { ticks: [], values: "" },
    };
  }

  /** @param {{ticks: number[], values: any}} series */
  past({ ticks, values }) {
    const bytes = new Uint8Array(this.table(values).flat().buffer);
    let letters = "";
    for (const byte of bytes) letters += String.fromCharCode(byte);
    return { ticks, values: btoa(letters) };
  }

  /** The maps, or the intentions, as they were last at the moment that is shown.
   * @param {string} kind
   * @param {number} robot */
  believed(kind, robot) {
    if (!this.head.robots[robot]) return [];
    const { values, moments } = this.head.robots[robot][kind];
    const at = lastAt(this.ticks[this.place], moments.length, (place) => moments[place][0]);
    if (at < 0) return [];
    return moments[at][1].map((/** @type {Record<string, number>} */ table) => Object.fromEntries(Object.entries(table).map(([key, place]) => [key, values[place]])));
  }

  // ------------------------------------------------------------------------------------------------------------- time

  run() {
    if (this.isRunning) return;
    if (this.isAtEnd) this.place = 0;
    this.isRunning = true;
    this.mark();
    this.show(this.place);
    requestAnimationFrame((now) => this.play(now));
  }

  pause() {
    this.isRunning = false;
    this.show(this.place);
  }

  /** @param {number} factor */
  setSpeed(factor) {
    this.speed = factor;
    this.mark();
    this.show(this.place);
  }

  /** From here on it is counted how fast it plays. */
  mark() {
    this.time = this.ticks[this.place] * this.dt;
    this.since = { now: performance.now(), time: this.time };
  }

  /** @param {number} now */
  play(now) {
    if (!this.isRunning) return;
    const passed = Math.min(LONGEST, Math.max(0, (now - (this.last ?? now)) / 1000));
    this.last = now;
    this.time += Number.isFinite(this.speed) ? passed * this.speed : 0;
    const due = lastAt(this.time / this.dt + 1e-6, this.ticks.length, (place) => this.ticks[place]);
    const place = Math.min(this.ticks.length - 1, Number.isFinite(this.speed) ? Math.max(due, this.place) : this.place + 1);
    if (place === this.ticks.length - 1) this.isRunning = false;
    if (place !== this.place) this.show(place);
    if (this.isRunning) requestAnimationFrame((next) => this.play(next));
    else this.last = undefined;
  }

  /** @param {number} place */
  move(place) {
    this.isRunning = false;
    this.show(Math.min(place, this.ticks.length - 1));
    return { tick: this.ticks[this.place], exact: true, can_continue: true, reason: "" };
  }

  /** Send the frame of a moment, about a robot.
   * @param {number} place */
  show(place, robot = this.robot) {
    this.place = place;
    this.robot = robot;
    const { scene, epoch, newest, events, bodies, robots } = this.head;
    const tick = this.ticks[place];
    const passed = this.since ? (performance.now() - this.since.now) / 1000 : 0;
    const head = {
      version: scene.version,
      number: ++this.number,
      epoch,
      time: tick * this.dt,
      speed: this.speed,
      achieved: this.since && this.isRunning && passed > 0 ? (tick * this.dt - this.since.time) / passed : 0,
      tick,
      newest,
      states: (this.isRunning ? FLAG.running : 0) | (this.isAtEnd ? FLAG.ended : 0),
      events: events.length,
      selected: robot,
    };
    /** @type {Record<string, ArrayLike<number>>} */
    const blocks = {};
    for (const name of OF_BODIES) blocks[name] = this.table(bodies[inPython(name)]).row(place);
    const one = robots[robot];
    if (one) {
      for (const name of OF_ROBOT) blocks[name] = this.table(one[inPython(name)]).row(place);
      for (const name of CLOUDS) blocks[name] = this.cloud(one[name], place);
    }
    this.on.frame(writeFrame(head, blocks));
  }

  /** @param {{of_moment: number[], counts: number[], rows: any}} belief
   * @param {number} place */
  cloud({ of_moment, counts, rows }, place) {
    const which = of_moment[place];
    const from = counts.slice(0, which).reduce((sum, count) => sum + count, 0);
    return this.table(rows).flat(from, from + counts[which]);
  }
}
