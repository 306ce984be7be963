// What is seen in the Editor: it stays where it is while the world is drawn in.

import { Sight } from "../shared/sight.js";

export class EditSight extends Sight {
  /** @param {import("./stage.js").EditStage} stage */
  constructor(stage) {
    super(stage);
    this.edited = stage;
    /** The world that was seen last: what it is called, and its extent. @type {{note: string, extent: number[]} | null} */
    this.world = null;
  }

  /** Whether the view stays: while walls are drawn, or the map cannot be read. All of another world is to be seen.
   * @param {import("../simulator/messages.d.ts").Still | null} still */
  keeps(still) {
    if (!still || still.scene.map === null) return true;
    const note = this.edited.byPath.get("world")?.note ?? "";
    const before = this.world;
    this.world = { note, extent: still.extent };
    const isDrawn = note.endsWith(".wld");
    if (!before) return isDrawn;
    return before.note === note && (isDrawn || before.extent.every((value, n) => value === still.extent[n]));
  }

  /** When faults come or go below the drawing, all stays where it is under the pointer.
   * @param {number[]} before
   * @param {boolean} wasFitted */
  resized([width, height], wasFitted) {
    const { stage } = this;
    const { camera } = stage;
    if (wasFitted && width !== camera.width) {
      stage.fit();
      return;
    }
    camera.centre(camera.x + (camera.width - width) / (2 * camera.scale), camera.y - (camera.height - height) / (2 * camera.scale));
    if (wasFitted) stage.fitted = [camera.x, camera.y, camera.scale];
  }
}
