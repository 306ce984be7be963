"""Philox 4x32-10: random numbers as a pure function of a key and a counter.

Source: J. K. Salmon, M. A. Moraes, R. O. Dror, D. E. Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.compile import inlined, kernel, part
from amorsim.kernels.random.normals import normals

__all__ = ["fill_normal", "fill_uniform", "lay_out", "pairs", "philox"]


_MULTIPLIER_0 = np.uint64(0xD2511F53)
_MULTIPLIER_1 = np.uint64(0xCD9E8D57)
_WEYL_0 = np.uint64(0x9E3779B9)
_WEYL_1 = np.uint64(0xBB67AE85)
_LOW = np.uint64(0xFFFFFFFF)
_HALF_WORD = np.uint64(32)
_TO_UNIT = 1.0 / 9007199254740992.0  # 2**-53
_LARGEST = 1.0 - _TO_UNIT

Words = tuple[np.uint64, np.uint64, np.uint64, np.uint64]


@inlined
def philox(c0: np.uint64, c1: np.uint64, c2: np.uint64, c3: np.uint64, k0: np.uint64, k1: np.uint64) -> Words:
    """Four random 32-bit words (in uint64) from a counter of four words and a key of two."""
    for _ in range(10):
        product_0 = _MULTIPLIER_0 * c0
        product_1 = _MULTIPLIER_1 * c2
        c0 = (product_1 >> _HALF_WORD) ^ c1 ^ k0
        c1 = product_1 & _LOW
        c2 = (product_0 >> _HALF_WORD) ^ c3 ^ k1
        c3 = product_0 & _LOW
        k0 = (k0 + _WEYL_0) & _LOW
        k1 = (k1 + _WEYL_1) & _LOW
    return c0, c1, c2, c3


@inlined
def _unit(high: np.uint64, low: np.uint64) -> float:
    # 53 bits, and half a step, so that 0 (its logarithm) never comes out; the largest would be rounded up to 1.
    bits = ((high >> np.uint64(5)) << np.uint64(26)) | (low >> np.uint64(6))
    return min((np.float64(np.int64(bits)) + 0.5) * _TO_UNIT, _LARGEST)


@part
def pairs(key: np.uint64, counter: npt.NDArray[np.uint32], row: int, block: int, first: Array, second: Array) -> None:
    """Two uniform draws in (0, 1) from each of a row's blocks of the tick, from number `block` on, into two arrays.

    A loop that does nothing else, and words known to be of 32 bits: so several blocks go side by side.
    """
    tick = np.uint64(counter[row, 2])
    episode = np.uint64(counter[row, 1])
    replica = np.uint64(counter[row, 0])
    for b in range(first.shape[0]):
        w0, w1, w2, w3 = philox(
            np.uint64(block + b) & _LOW, tick & _LOW, episode & _LOW, replica & _LOW, key & _LOW, key >> _HALF_WORD
        )
        first[b] = _unit(w0, w1)
        second[b] = _unit(w2, w3)


@part
def lay_out(first: Array, second: Array, out: Array) -> None:
    """Lay pairs of draws side by side into `out` (k,); of an odd number the last has one draw."""
    for b in range(out.shape[0] // 2):
        out[2 * b] = first[b]
        out[2 * b + 1] = second[b]
    if out.shape[0] % 2:
        out[-1] = first[-1]


@kernel
def fill_uniform(keys: npt.NDArray[np.uint64], counter: npt.NDArray[np.uint32], block: int, out: Array) -> None:
    """Uniform draws in (0, 1) into `out` (N, k): row i from key i and its counter (replica, episode, tick)."""
    first = np.empty((out.shape[1] + 1) // 2)
    second = np.empty((out.shape[1] + 1) // 2)
    for i in range(out.shape[0]):
        pairs(keys[i], counter, i, block, first, second)
        lay_out(first, second, out[i])


@kernel
def fill_normal(keys: npt.NDArray[np.uint64], counter: npt.NDArray[np.uint32], block: int, out: Array) -> None:
    """Standard normal draws into `out` (N, k), two from each block."""
    first = np.empty((out.shape[1] + 1) // 2)
    second = np.empty((out.shape[1] + 1) // 2)
    power = np.empty((out.shape[1] + 1) // 2)
    first_bits = first.view(np.int64)
    for i in range(out.shape[0]):
        pairs(keys[i], counter, i, block, first, second)
        normals(first, second, first_bits, power)
        lay_out(first, second, out[i])
