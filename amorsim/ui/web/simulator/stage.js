// The panes with what they share: camera, scene, newest frame, trails, colours. Draws when something changed, not more.

import { Camera } from "../shared/camera.js";
import { tinted, wallPath } from "../shared/marks.js";
import { Layer, Pane } from "./pane.js";
import { readTheme } from "../shared/theme.js";
import { Trail } from "./trail.js";

export class Stage {
  /** @param on `{pick(thing-finder arguments), drawn(frame, milliseconds), follow(isFollowing)}` */
  constructor(root, on) {
    this.root = root;
    this.on = on;
    this.camera = new Camera();
    this.camera.changed = () => this.redraw();
    this.truth = new Layer("true");
    this.belief = new Layer("estimated");
    const handlers = {
      pick: (pane, x, y, left, top) => on.pick(pane, x, y, left, top),
      panned: () => this.setOption("follow", false),
      fit: () => this.fit(),
    };
    const pane = (id, label, layers) => new Pane({ id, label, camera: this.camera, layers, on: handlers });
    this.robot = pane("pane-robot", "Robot: the true world", [this.truth]);
    this.control = pane("pane-control", "Control: what the robot knows", [this.belief]);
    this.options = { trails: true, ellipse: true, grid: true, follow: false, overlay: false };
    this.trueTrail = new Trail();
    this.estimatedTrail = new Trail();
    this.pictures = new Map();
    this.paths = new Map();
    this.trueSensors = []; // of the selected robot, as they are by their true parameters
    this.theme = readTheme(root);
    root.addEventListener("theme", () => {
      this.theme = readTheme(root);
      this.redraw();
    });
    new ResizeObserver(() => this.resize()).observe(this.robot.element);
    new ResizeObserver(() => this.resize()).observe(this.control.element);
  }

  get canvases() {
    return [this.robot.canvas, this.control.canvas];
  }

  setScene(scene, pictureOf) {
    this.scene = scene;
    this.paths.clear();
    this.pictures.clear();
    this.pictureOf = pictureOf;
    this.mark = null;
    this.resize();
    this.fit();
  }

  pathOf(map) {
    if (!this.paths.has(map)) this.paths.set(map, wallPath(map));
    return this.paths.get(map);
  }

  /** A map's picture in a colour, loaded when first wanted; null until it is there, and where there are lines. */
  picture(map, colour) {
    if (!map?.image || map.segments) return null;
    if (!this.pictures.has(map)) {
      const image = new Image();
      image.onload = () => this.redraw();
      this.pictures.set(map, { image, shades: new Map() });
      this.pictureOf(map.image.name).then((url) => url && (image.src = url));
    }
    const { image, shades } = this.pictures.get(map);
    if (!image.complete || !image.naturalWidth) return null;
    if (!shades.has(colour)) shades.set(colour, tinted(image, colour));
    return shades.get(colour);
  }

  setFrame(frame) {
    this.frame = frame;
    const i = frame.selected;
    if (this.scene?.robots[i] && !(frame.states & 4)) {
      this.trueTrail.add(frame.tick, frame.truePoses[3 * i], frame.truePoses[3 * i + 1]);
      this.estimatedTrail.add(frame.tick, frame.estimatedPoses[3 * i], frame.estimatedPoses[3 * i + 1]);
    }
    if (this.options.follow) {
      this.camera.x = frame.truePoses[3 * i];
      this.camera.y = frame.truePoses[3 * i + 1];
    }
    this.redraw(true);
  }

  clearTrails() {
    this.trueTrail.clear();
    this.estimatedTrail.clear();
  }

  setOption(name, value) {
    if (this.options[name] === value) return;
    this.options[name] = value;
    if (name === "overlay") this.robot.layers = value ? [this.truth, this.belief] : [this.truth];
    if (name === "follow" && value && this.frame) this.setFrame(this.frame);
    this.on.option(name, value);
    this.resize();
  }

  fit() {
    this.setOption("follow", false);
    if (!this.scene) return;
    this.camera.fit(this.scene.map.extent);
    const { x, y, scale } = this.camera;
    this.fitted = { x, y, scale };
  }

  /** Whether all is seen, as fitted, and nobody has moved it since. */
  get isFitted() {
    return ["x", "y", "scale"].every((part) => this.fitted?.[part] === this.camera[part]);
  }

  resize() {
    const [width, height] = this.robot.resize();
    if (!this.options.overlay) this.control.resize();
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

  draw(now) {
    const began = performance.now();
    this.robot.draw(this);
    if (!this.options.overlay) this.control.draw(this);
    const isNew = this.hasFrame;
    this.hasFrame = false;
    this.on.drawn(this.frame, isNew, now, began);
  }

  stop() {
    cancelAnimationFrame(this.asked);
  }
}
