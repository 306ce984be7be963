// Numbers that are the same but for rounding.

import assert from "node:assert/strict";

/** @param {ArrayLike<number>} found
 * @param {number[]} expected
 * @param {number} [apart] */
export function areNear(found, expected, apart = 1e-9) {
  assert.equal(found.length, expected.length);
  expected.forEach((value, n) => assert(Math.abs(found[n] - value) <= apart, `${[...Array.from(found)]} for ${expected}`));
}

/** Numbers in [0, 1) that are the same in every run.
 * @param {number} seed */
export function drawn(seed) {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 2 ** 32;
  };
}
