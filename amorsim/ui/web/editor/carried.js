// What is dragged, or plays: drawn above what stands still, frame by frame.

/** What layers of bodies draw from that are dragged, or play: nothing but those. */
export class Carried {
  /** @param {import("./stage.js").EditStage} stage */
  constructor(stage) {
    this.stage = stage;
  }

  get scene() {
    return this.stage.scene;
  }

  get frame() {
    return this.stage.carried;
  }

  get pictures() {
    return this.stage.pictures;
  }

  get selection() {
    return this.stage.selection;
  }

  posesOf() {
    return this.frame?.truePoses ?? [];
  }
}
