"""A running fingerprint of exact results, one for each row: two runs with equal bits have equal fingerprints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel

__all__ = ["absorb"]

# Odd multipliers with well-mixed bits, from the fractional parts of the golden ratio and of the square root of 2.
_FIRST = np.uint64(0x9E3779B97F4A7C15)
_SECOND = np.uint64(0x6A09E667F3BCC909)
_SHIFT = np.uint64(29)
_OTHER = np.uint64(32)

# Arrays a kernel call takes: always so many, for each number of them would be compiled by itself.
_BATCH = 8
_NOTHING = np.empty((0, 0))


@kernel
def _absorb(values: tuple[npt.NDArray[np.float64], ...], out: npt.NDArray[np.uint64]) -> None:
    for n in range(_BATCH):
        bits = values[n].view(np.uint64)
        for i in range(bits.shape[0]):
            first = out[i, 0]
            second = out[i, 1]
            for j in range(bits.shape[1]):
                word = bits[i, j]
                first = (first ^ word) * _FIRST
                first ^= first >> _SHIFT
                second = (second + word) * _SECOND
                second ^= second >> _OTHER
            out[i, 0] = first
            out[i, 1] = second


def absorb(values: Sequence[npt.NDArray[np.float64]], out: npt.NDArray[np.uint64]) -> None:
    """Mix the bits of arrays (N, k), C-contiguous and writeable, into the fingerprints `out` (N, 2), in order."""
    for start in range(0, len(values), _BATCH):
        batch = tuple(values[start : start + _BATCH])
        _absorb(batch + (_NOTHING,) * (_BATCH - len(batch)), out)
