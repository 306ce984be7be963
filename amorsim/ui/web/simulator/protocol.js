// What `amorsim/ui/simulator/frames/packing.py` packs, unpacked: the bytes of a frame.

import { BLOCKS, FLAG, HEADER, HEADER_SIZE, MAGIC, ROBOT } from "./wire.js";

export { FLAG, ROBOT };

/**
 * A frame of its bytes; the scene says how the selected robot's values part into sensors.
 * @param {ArrayBuffer} buffer
 * @param {import("../shared/scene.js").Scene | null} scene
 * @returns {import("./messages.d.ts").Frame}
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

/**
 * The bytes of a frame, which `readFrame` reads.
 * @param {Record<string, number>} head the numbers of its header; counts are those of the blocks
 * @param {Record<string, ArrayLike<number>>} blocks by name; those that are missing are empty, or nan
 * @returns {ArrayBuffer}
 */
export function writeFrame(head, blocks) {
  /** @type {Record<string, number>} */
  const counts = {};
  for (const [name, , counted, each] of BLOCKS) if (counted) counts[counted] ??= (blocks[name]?.length ?? 0) / each;
  const sizes = BLOCKS.map(([, Kind, counted, each]) => Kind.BYTES_PER_ELEMENT * each * (counted ? counts[counted] : 1));
  const buffer = new ArrayBuffer(sizes.reduce((sum, size) => sum + size, HEADER_SIZE));
  const view = new DataView(buffer);
  view.setUint32(0, MAGIC, true);
  for (const [name, kind, at] of HEADER) view[`set${kind}`](at, counts[name] ?? head[name] ?? 0, true);
  let at = HEADER_SIZE;
  BLOCKS.forEach(([name, Kind], n) => {
    const block = new Kind(buffer, at, sizes[n] / Kind.BYTES_PER_ELEMENT);
    if (blocks[name]) block.set(blocks[name]);
    else block.fill(NaN);
    at += sizes[n];
  });
  return buffer;
}
