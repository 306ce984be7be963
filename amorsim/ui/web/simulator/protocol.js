// What `amorsim/ui/simulator/frames/packing.py` packs, unpacked: the bytes of a frame.

import { BLOCKS, FLAG, HEADER, HEADER_SIZE, MAGIC, ROBOT } from "./wire.js";

export { FLAG, ROBOT };

/**
 * A frame of its bytes; the scene says how the selected robot's values part into sensors.
 * @param {ArrayBuffer} buffer
 * @param {import("../shared/scene.js").Scene | null} scene
 * @returns {import("./wire.js").Frame}
 */
export function readFrame(buffer, scene) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER_SIZE || view.getUint32(0, true) !== MAGIC) throw new Error("these are not a frame's bytes");
  /** @type {any} */
  const frame = {};
  for (const [name, kind, at] of HEADER) frame[name] = view[`get${kind}`](at, true);
  let at = HEADER_SIZE;
  for (const [name, Kind, counted, each] of BLOCKS) {
    frame[name] = new Kind(buffer, at, each * (counted ? frame[counted] : 1));
    at += frame[name].byteLength;
  }
  frame.sensors = [];
  const shapes = scene && scene.version === frame.version ? (scene.robots[frame.selected]?.sensors ?? []) : [];
  let from = 0;
  shapes.forEach((sensor, s) => {
    const to = from + sensor.size;
    if (to > frame.valueCount || s >= frame.sensorCount) return;
    frame.sensors.push({ true: frame.trueValues.subarray(from, to), measured: frame.measuredValues.subarray(from, to), age: frame.ages[s] });
    from = to;
  });
  return frame;
}
