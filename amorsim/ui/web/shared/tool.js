// Tools: what the pointer and the keys do on a canvas. A canvas has one at a time.

/**
 * Where a pointer is: in the world [m] and on the canvas [CSS pixels].
 * @typedef {{x: number, y: number, left: number, top: number}} Place
 */

const STILL = 4; // pixels that a click may move

/** A tool that does nothing. */
export class Tool {
  get cursor() {
    return "default";
  }

  /** The pointer goes down.
   * @param {Place} _place
   * @param {PointerEvent} _event */
  down(_place, _event) {}

  /** The pointer moves, down or not.
   * @param {Place} _place
   * @param {PointerEvent} _event */
  move(_place, _event) {}

  /** The pointer is let go.
   * @param {Place} _place
   * @param {PointerEvent} _event */
  up(_place, _event) {}

  /** What was begun is given up: the pointer is lost, Escape pressed, or another tool taken. */
  cancel() {}

  /** A key is pressed on the canvas, with the place that keys point at; whether the tool has used it.
   * @param {KeyboardEvent} _event
   * @param {Place} _place
   * @returns {boolean} */
  key(_event, _place) {
    return false;
  }
}

/** The hand: drags the camera, and a click points at what is there. Enter points at what lies where keys point. */
export class Hand extends Tool {
  /**
   * @param {import("./camera.js").Camera} camera
   * @param {{
   *   clicked?: (place: Place) => void,
   *   panned?: () => void,
   *   boxing?: (box: number[] | null) => void,
   *   boxed?: (box: number[]) => void,
   * }} on `boxing` and `boxed` get a box in the world [m] that is dragged out with Shift
   */
  constructor(camera, on) {
    super();
    this.camera = camera;
    this.on = on;
    /** @type {{left: number, top: number} | null} */
    this.from = null;
    /** @type {Place | null} */
    this.corner = null; // of a box, where it was begun
    this.moved = 0;
  }

  get cursor() {
    if (this.corner) return "crosshair";
    return this.from ? "grabbing" : "grab";
  }

  /** @param {Place} place
   * @param {PointerEvent} event */
  down(place, event) {
    this.from = { left: place.left, top: place.top };
    this.corner = this.on.boxed && event.shiftKey ? place : null;
    this.moved = 0;
  }

  /** @param {Place} place */
  move(place) {
    if (!this.from) return;
    const { left, top } = place;
    if (this.corner) {
      this.moved += Math.abs(left - this.from.left) + Math.abs(top - this.from.top);
      this.from = { left, top };
      this.on.boxing?.(boxOf(this.corner, place));
      return;
    }
    const [right, down] = [left - this.from.left, top - this.from.top];
    this.moved += Math.abs(right) + Math.abs(down);
    this.from = { left, top };
    if (this.moved <= STILL) return;
    this.on.panned?.();
    this.camera.pan(right, down);
  }

  /** @param {Place} place
   * @param {PointerEvent} event */
  up(place, event) {
    const isClick = this.from !== null && this.moved <= STILL && event.button === 0;
    const { corner } = this;
    this.cancel();
    if (corner && !isClick) this.on.boxed?.(boxOf(corner, place));
    if (isClick) this.on.clicked?.(place);
  }

  cancel() {
    this.from = null;
    if (this.corner) this.on.boxing?.(null);
    this.corner = null;
  }

  /** @param {KeyboardEvent} event
   * @param {Place} place */
  key(event, place) {
    if (event.key !== "Enter") return false;
    this.on.clicked?.(place);
    return true;
  }
}

/** The box between two corners, as [left, bottom, right, top] [m].
 * @param {Place} one
 * @param {Place} other */
const boxOf = (one, other) => [Math.min(one.x, other.x), Math.min(one.y, other.y), Math.max(one.x, other.x), Math.max(one.y, other.y)];
