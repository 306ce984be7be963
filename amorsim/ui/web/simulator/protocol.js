// What `amorsim/ui/simulator/protocol.py` packs, unpacked: the bytes of a frame, and a scene made ready for drawing.

import { reach, waist } from "../shared/marks.js";

const HEADER = 88;
const MAGIC = 0x31666d61; // "amf1", little endian

export const FLAG = { running: 1, ended: 2, scrubbed: 4, fault: 8, hang: 16, loading: 32, posesOnly: 64 };
export const ROBOT = { touching: 1, ended: 2, byHand: 4 };

/** A frame of its bytes; `kinds` says how the selected robot's values part into sensors. */
export function readFrame(buffer, scene) {
  const view = new DataView(buffer);
  if (buffer.byteLength < HEADER || view.getUint32(0, true) !== MAGIC) throw new Error("these are not a frame's bytes");
  const u32 = (at) => view.getUint32(at, true);
  const frame = {
    version: u32(4),
    number: u32(8),
    epoch: u32(12),
    time: view.getFloat64(16, true),
    speed: view.getFloat32(24, true),
    achieved: view.getFloat32(28, true),
    tick: u32(32),
    newest: u32(36),
    flags: u32(40),
    events: u32(44),
    selected: view.getInt32(56, true),
    oldest: u32(76),
  };
  const [robots, obstacles] = [u32(48), u32(52)];
  const [values, sensors, joints, channels, parts] = [u32(60), u32(64), u32(68), u32(72), u32(80)];
  let at = HEADER;
  const f64 = (n) => {
    const part = new Float64Array(buffer, at, n);
    at += 8 * n;
    return part;
  };
  const f32 = (n) => {
    const part = new Float32Array(buffer, at, n);
    at += 4 * n;
    return part;
  };
  const truth = f64(values);
  const measured = f64(values);
  const ages = f64(sensors);
  frame.trueRates = f64(joints);
  frame.measuredRates = f64(joints);
  frame.trueTwist = f64(3);
  frame.estimatedTwist = f64(3);
  frame.command = f64(channels);
  frame.believedParts = f64(3 * parts);
  frame.truePoses = f32(3 * robots);
  frame.estimatedPoses = f32(3 * robots);
  frame.covariances = f32(6 * robots);
  frame.obstacles = f32(3 * obstacles);
  frame.states = frame.flags;
  frame.flags = new Uint8Array(buffer, at, robots);
  frame.sensors = [];
  const shapes = scene && scene.version === frame.version ? (scene.robots[frame.selected]?.sensors ?? []) : [];
  let from = 0;
  shapes.forEach((sensor, s) => {
    const to = from + sensor.size;
    if (to > values || s >= sensors) return;
    frame.sensors.push({ true: truth.subarray(from, to), measured: measured.subarray(from, to), age: ages[s] });
    from = to;
  });
  return frame;
}

/** A scene with what drawing needs put in place: each robot with its kind's shape, its reach and what it was told. */
export function readScene(raw) {
  const kinds = raw.kinds.map((kind) => ({
    ...kind,
    reach: reach(kind.footprint),
    waist: waist(kind.footprint),
    wheels: kind.wheels.map(([x, y, heading, radius]) => ({ x, y, heading, radius, width: 0.4 * radius })),
  }));
  return {
    ...raw,
    map: raw.maps[raw.map],
    robots: raw.robots.map((robot) => ({
      ...kinds[robot.kind],
      name: robot.name,
      colour: robot.colour,
      controller: robot.controller,
      landmarks: robot.knowledge.landmarks,
      parts: raw.obstacles.filter((body) => body.part_of === robot.name),
      knowledge: robot.knowledge.map === null ? null : raw.maps[robot.knowledge.map],
    })),
    obstacles: raw.obstacles.map((obstacle) => ({ ...obstacle, reach: reach(obstacle.footprint) })),
  };
}
