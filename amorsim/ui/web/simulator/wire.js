// Made by tools/make_wire.py from what amorsim/ui/{scene, simulator, faults} say: change it there.

/** How the simulation stands in a frame. */
export const FLAG = { running: 1, ended: 2, scrubbed: 4, fault: 8, hang: 16, loading: 32, posesOnly: 64 };

/** How a robot stands in a frame. */
export const ROBOT = { touching: 1, ended: 2, byHand: 4 };

export const MAGIC = 0x31666d61; // the first four bytes, little endian
export const HEADER_SIZE = 96; // bytes

/** Where the numbers of a frame's header lie: name, kind, byte.
 * @type {[string, "Uint32" | "Int32" | "Float32" | "Float64", number][]} */
export const HEADER = [
  ["version", "Uint32", 4],
  ["number", "Uint32", 8],
  ["epoch", "Uint32", 12],
  ["time", "Float64", 16],
  ["speed", "Float32", 24],
  ["achieved", "Float32", 28],
  ["tick", "Uint32", 32],
  ["newest", "Uint32", 36],
  ["states", "Uint32", 40],
  ["events", "Uint32", 44],
  ["robotCount", "Uint32", 48],
  ["obstacleCount", "Uint32", 52],
  ["selected", "Int32", 56],
  ["valueCount", "Uint32", 60],
  ["sensorCount", "Uint32", 64],
  ["jointCount", "Uint32", 68],
  ["channelCount", "Uint32", 72],
  ["oldest", "Uint32", 76],
  ["partCount", "Uint32", 80],
  ["particleCount", "Uint32", 84],
  ["hypothesisCount", "Uint32", 88],
];

/** What follows it: name, kind, which number of the header counts it, how many for each.
 * @type {[string, Float64ArrayConstructor | Float32ArrayConstructor | Uint8ArrayConstructor, string, number][]} */
export const BLOCKS = [
  ["trueValues", Float64Array, "valueCount", 1],
  ["measuredValues", Float64Array, "valueCount", 1],
  ["ages", Float64Array, "sensorCount", 1],
  ["trueRates", Float64Array, "jointCount", 1],
  ["measuredRates", Float64Array, "jointCount", 1],
  ["trueTwist", Float64Array, "", 3],
  ["estimatedTwist", Float64Array, "", 3],
  ["command", Float64Array, "channelCount", 1],
  ["believedParts", Float64Array, "partCount", 3],
  ["particles", Float64Array, "particleCount", 4],
  ["hypotheses", Float64Array, "hypothesisCount", 10],
  ["truePoses", Float32Array, "robotCount", 3],
  ["estimatedPoses", Float32Array, "robotCount", 3],
  ["covariances", Float32Array, "robotCount", 6],
  ["obstacles", Float32Array, "obstacleCount", 3],
  ["flags", Uint8Array, "robotCount", 1],
];
