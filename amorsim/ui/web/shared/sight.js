// What is seen of a scenario: all of it, whenever it has another extent or the pane another size.

export class Sight {
  /** @param {import("./still.js").StillStage} stage */
  constructor(stage) {
    this.stage = stage;
  }

  /** Whether the camera stays though something else is to be seen.
   * @param {import("../simulator/messages.d.ts").Still | null} _still */
  keeps(_still) {
    return false;
  }

  /** The pane had another size before; `wasFitted` says whether the camera showed all.
   * @param {number[]} _before
   * @param {boolean} wasFitted */
  resized(_before, wasFitted) {
    if (wasFitted) this.stage.fit();
  }
}
