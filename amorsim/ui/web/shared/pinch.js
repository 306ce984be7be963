// Two fingers on a canvas: they zoom and move what is seen.

/** @typedef {{left: number, top: number}} Finger */

export class Pinch {
  /** @param {import("./camera.js").Camera} camera */
  constructor(camera) {
    this.camera = camera;
    /** @type {Map<number, Finger>} */
    this.fingers = new Map();
    this.isOn = false; // from the second finger down until the last is up
  }

  /** A finger comes down; whether there are two now.
   * @param {number} id
   * @param {Finger} finger */
  down(id, { left, top }) {
    if (this.fingers.size < 2) this.fingers.set(id, { left, top });
    this.isOn ||= this.fingers.size === 2;
    return this.isOn;
  }

  /** A finger moves; whether that was a part of the gesture.
   * @param {number} id
   * @param {Finger} finger */
  move(id, { left, top }) {
    if (!this.isOn || !this.fingers.has(id)) return this.isOn;
    const [before, wide] = this.measure();
    this.fingers.set(id, { left, top });
    if (this.fingers.size < 2) return true;
    const [now, wider] = this.measure();
    this.camera.pan(now.left - before.left, now.top - before.top);
    if (wide > 0 && wider > 0) this.camera.zoom(wider / wide, now.left, now.top);
    return true;
  }

  /** A finger is lifted; whether it belonged to the gesture.
   * @param {number} id */
  up(id) {
    const wasOn = this.isOn;
    this.fingers.delete(id);
    this.isOn &&= this.fingers.size > 0;
    return wasOn;
  }

  /** The middle between the fingers, and how far they are apart.
   * @returns {[Finger, number]} */
  measure() {
    const [one, other = one] = this.fingers.values();
    const middle = { left: (one.left + other.left) / 2, top: (one.top + other.top) / 2 };
    return [middle, Math.hypot(one.left - other.left, one.top - other.top)];
  }
}
