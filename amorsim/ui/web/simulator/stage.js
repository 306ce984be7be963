// The Simulator's canvases with what they share: camera, scene, newest frame, trails, colours. Draws when something changed.

import { Camera } from "../shared/camera.js";
import { Canvas } from "../shared/canvas.js";
import { h, there } from "../shared/dom.js";
import { GridLayer } from "../shared/ground.js";
import { Selection } from "../shared/selection.js";
import { readTheme } from "../shared/theme.js";
import { Hand } from "../shared/tool.js";
import { BodiesLayer, NamesLayer, SelectionLayer, WorldLayer } from "../shared/world.js";
import { Intended, IntendedLayer } from "./intended.js";
import { BoxLayer, FutureNamesLayer, FuturesLayer, KnownLayer, MarkLayer, RobotLayer } from "./layers.js";
import { Mapped, MappedLayer } from "./mapped.js";
import { Picker } from "./pick.js";
import { Pictures } from "../shared/pictures.js";
import { Trail } from "./trail.js";

const HELP = "Drag or Shift and arrows pan, Shift and drag lists robots, plus and minus zoom, 0 shows all, F follows, Enter tells what is in the middle.";

/** A canvas with what is said on it. */
class Pane extends Canvas {
  /** @param {ConstructorParameters<typeof Canvas>[0]} what */
  constructor(what) {
    super({ ...what, label: `${what.label}. ${HELP}` });
    this.note = h("output", { class: "note", "aria-hidden": "true" }); // what the table tells, too
    this.lack = h("p", { class: "lack", role: "status" }); // why there is less to see than one might expect
    this.element.append(this.lack, this.note);
    /** @type {import("../shared/world.js").View[]} */
    this.views = []; // what is pointed at first comes first
  }
}

export class Stage {
  /**
   * @param {HTMLElement} root
   * @param {{
   *   ask: (command: object) => Promise<any>,
   *   picked: (pane: Pane, place: import("../shared/tool.js").Place) => void,
   *   option: (name: string, value: boolean) => void,
   *   boxed: (robots: number[]) => void,
   *   drawn: (frame: import("./messages.d.ts").Frame | undefined, isNew: boolean, now: number, began: number) => void,
   * }} on
   */
  constructor(root, on) {
    this.root = root;
    this.on = on;
    this.camera = new Camera();
    this.camera.changed = () => this.redraw();
    this.theme = readTheme(root);
    /** @type {Record<string, boolean>} */
    this.options = { trails: true, ellipse: true, particles: true, hypotheses: true, grid: true, follow: false, overlay: false };
    this.hidden = new Set(); // names of sensors that are not drawn
    this.trueTrail = new Trail();
    this.estimatedTrail = new Trail();
    /** @type {import("./messages.d.ts").SensorShape[]} */
    this.trueSensors = []; // of the selected robot, as they are by their true parameters
    this.pictures = new Pictures(() => this.redraw());
    this.picker = new Picker();
    /** @type {Selection<import("./pick.js").Found>} */
    this.selection = new Selection();
    this.selection.listen(() => this.redraw());
    /** What an event points at. @type {any} */
    this.mark = null;
    /** @type {import("./futures.js").Future[]} */
    this.futures = []; // other courses of events, drawn pale
    /** @type {number[] | null} */
    this.box = null; // that is being drawn around robots [m]
    this.mapped = new Mapped(on.ask, () => this.redraw());
    this.intended = new Intended(on.ask, () => this.redraw());
    this.robot = this.pane("pane-robot", "Robot: the true world");
    this.control = this.pane("pane-control", "Control: what the robot knows");
    this.arrange();
    root.addEventListener("theme", () => {
      this.robot.theme = this.control.theme = this.theme = readTheme(root);
      this.redraw();
    });
    for (const pane of [this.robot, this.control]) new ResizeObserver(() => this.resize()).observe(pane.element);
  }

  /** @param {string} id
   * @param {string} label */
  pane(id, label) {
    const pane = new Pane({ id, label, camera: this.camera, theme: this.theme });
    const hand = new Hand(this.camera, {
      clicked: (place) => this.pick(pane, place),
      panned: () => this.setOption("follow", false),
      boxing: (box) => {
        this.box = box;
        this.redraw();
      },
      boxed: (box) => this.on.boxed(this.robotsIn(box, pane.views[0])),
    });
    pane.panning = hand;
    pane.take(hand);
    pane.canvas.addEventListener("dblclick", () => this.fit());
    return pane;
  }

  /** Give the panes their layers. What is known lies under what is true, so that an overlay shows both. */
  arrange() {
    const { overlay } = this.options;
    const grid = new GridLayer(() => this.options.grid);
    const [known, mapped, belief] = [new KnownLayer(this), new MappedLayer(this), new RobotLayer(this, "estimated")];
    const intended = new IntendedLayer(this);
    const [mark, seenOnes, knownOnes] = [new MarkLayer(this), new SelectionLayer(this, "true"), new SelectionLayer(this, "estimated")];
    const seen = [new WorldLayer(this), new BodiesLayer(this), new FuturesLayer(this, "true"), new RobotLayer(this, "true")];
    const [believed, box] = [new FuturesLayer(this, "estimated"), new BoxLayer(this)];
    const names = (/** @type {import("../shared/world.js").View} */ view) => [new NamesLayer(this, view), new FutureNamesLayer(this, view), box];
    this.robot.layers = overlay
      ? [grid, known, mapped, ...seen, intended, believed, belief, seenOnes, knownOnes, mark, ...names("true")]
      : [grid, ...seen, seenOnes, mark, ...names("true")];
    this.robot.views = overlay ? ["estimated", "true"] : ["true"];
    this.control.layers = [grid, known, mapped, intended, believed, belief, knownOnes, mark, ...names("estimated")];
    this.control.views = ["estimated"];
  }

  get canvases() {
    return [this.robot.canvas, this.control.canvas];
  }

  /** @param {import("../shared/world.js").View} view */
  posesOf(view) {
    return there(this.frame)[view === "true" ? "truePoses" : "estimatedPoses"];
  }

  /** @param {import("../shared/scene.js").Scene} scene
   * @param {(name: string) => Promise<any>} pictureOf */
  setScene(scene, pictureOf) {
    this.scene = scene;
    this.pictures.reset(pictureOf);
    this.picker.setScene(scene);
    this.selection.clear();
    this.mark = null;
    this.resize();
    this.fit();
  }

  /** @param {import("./messages.d.ts").Frame} frame */
  setFrame(frame) {
    this.frame = frame;
    this.mapped.setFrame(frame);
    this.intended.setFrame(frame);
    const i = frame.selected;
    if (this.scene?.recorded) {
      this.trueTrail.showUntil(frame.tick, frame.truePoses[3 * i], frame.truePoses[3 * i + 1]);
      this.estimatedTrail.showUntil(frame.tick, frame.estimatedPoses[3 * i], frame.estimatedPoses[3 * i + 1]);
    } else if (this.scene?.robots[i] && !(frame.states & 4)) {
      this.trueTrail.add(frame.tick, frame.truePoses[3 * i], frame.truePoses[3 * i + 1]);
      this.estimatedTrail.add(frame.tick, frame.estimatedPoses[3 * i], frame.estimatedPoses[3 * i + 1]);
    }
    if (this.options.follow) {
      const poses = Number.isFinite(frame.truePoses[3 * i]) ? frame.truePoses : frame.estimatedPoses; // of a log nothing true is known
      this.camera.x = poses[3 * i];
      this.camera.y = poses[3 * i + 1];
    }
    this.redraw(true);
  }

  /** Draw the paths of a part of the time alone.
   * @param {[number, number] | null} zoom seconds */
  showTimes(zoom) {
    const [from, to] = zoom ?? [-Infinity, Infinity];
    const { dt } = there(this.scene);
    for (const trail of [this.trueTrail, this.estimatedTrail, ...this.futures.flatMap((one) => [one.trueTrail, one.estimatedTrail])]) {
      [trail.from, trail.to] = [from / dt, to / dt];
    }
    this.redraw();
  }

  /** The robots whose middle lies in a box.
   * @param {number[]} box
   * @param {import("../shared/world.js").View} view */
  robotsIn([x0, y0, x1, y1], view) {
    const poses = this.posesOf(view);
    return there(this.scene).robots.map((_, i) => i).filter((i) => poses[3 * i] >= x0 && poses[3 * i] <= x1 && poses[3 * i + 1] >= y0 && poses[3 * i + 1] <= y1);
  }

  clearTrails() {
    this.trueTrail.clear();
    this.estimatedTrail.clear();
  }

  /** @param {string} name
   * @param {boolean} value */
  setOption(name, value) {
    if (this.options[name] === value) return;
    this.options[name] = value;
    if (name === "overlay") this.arrange();
    if (name === "follow" && value && this.frame) this.setFrame(this.frame);
    this.on.option(name, value);
    this.resize();
  }

  /** @param {Pane} pane
   * @param {import("../shared/tool.js").Place} place */
  pick(pane, place) {
    const { scene, frame, camera, hidden, trueSensors } = this;
    const near = { x: place.x, y: place.y, scale: camera.scale };
    const found = scene && frame ? this.picker.pick(frame, pane.views, near, { hidden, trueSensors }) : null;
    this.selection.set(found ? [found] : []);
    this.on.picked(pane, place);
  }

  fit() {
    this.setOption("follow", false);
    if (!this.scene) return;
    this.camera.fit(there(this.scene.map).extent);
    const { x, y, scale } = this.camera;
    this.fitted = { x, y, scale };
  }

  /** Whether all is seen, as fitted, and nobody has moved it since. */
  get isFitted() {
    return /** @type {const} */ (["x", "y", "scale"]).every((part) => this.fitted?.[part] === this.camera[part]);
  }

  resize() {
    const [width, height] = this.robot.resize();
    if (!this.options.overlay) this.control.resize();
    if (!width || !height) return; // another panel is shown alone
    const isChanged = width !== this.camera.width || height !== this.camera.height;
    const isFirst = this.camera.width === 1;
    this.camera.resize(width, height);
    if (isChanged && (isFirst || (this.isFitted && !this.options.follow))) this.fit();
    this.redraw();
  }

  redraw(isFrame = false) {
    this.hasFrame ||= isFrame;
    if (this.asked) return;
    this.asked = requestAnimationFrame((now) => {
      this.asked = 0;
      this.draw(now);
    });
  }

  /** @param {number} now */
  draw(now) {
    const began = performance.now();
    this.robot.draw();
    if (!this.options.overlay) this.control.draw();
    const isNew = this.hasFrame;
    this.hasFrame = false;
    this.on.drawn(this.frame, Boolean(isNew), now, began);
  }
}
