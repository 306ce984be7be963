// What is selected on the canvases of a page: things that were picked, which those who listen show in their own way.

/**
 * A thing that can be pointed at. `key` tells things of one kind apart; `title` and `lines` say what it is.
 * @typedef {{kind: string, key: string | number, title: string, lines: string[]}} Thing
 */

/** @template {Thing} T */
export class Selection {
  constructor() {
    /** @type {T[]} */
    this.things = [];
    /** @type {((selection: Selection<T>) => void)[]} */
    this.listeners = [];
  }

  /** Call a function whenever something else is selected, and for a thing that is picked again.
   * @param {(selection: Selection<T>) => void} listener */
  listen(listener) {
    this.listeners.push(listener);
  }

  /** The one thing that is selected, or null where it is none or several. */
  get only() {
    return this.things.length === 1 ? this.things[0] : null;
  }

  /** @param {string} kind
   * @param {string | number} key */
  has(kind, key) {
    return this.things.some((thing) => thing.kind === kind && thing.key === key);
  }

  /** @param {T[]} things */
  set(things) {
    this.things = things;
    for (const listener of this.listeners) listener(this);
  }

  clear() {
    if (this.things.length) this.set([]);
  }
}
