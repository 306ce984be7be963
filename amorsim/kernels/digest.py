"""A running fingerprint of exact results, one for each row: two runs with equal bits have equal fingerprints."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel

__all__ = ["absorb"]

# Odd multipliers with well-mixed bits, from the fractional parts of the golden ratio and of the square root of 2.
_FIRST = np.uint64(0x9E3779B97F4A7C15)
_SECOND = np.uint64(0x6A09E667F3BCC909)
_SHIFT = np.uint64(29)
_OTHER = np.uint64(32)


@kernel
def absorb(values: npt.NDArray[np.float64], out: npt.NDArray[np.uint64]) -> None:
    """Mix the bits of `values` (N, k) into the fingerprints `out` (N, 2), in order."""
    bits = values.view(np.uint64)
    for i in range(values.shape[0]):
        first = out[i, 0]
        second = out[i, 1]
        for j in range(values.shape[1]):
            word = bits[i, j]
            first = (first ^ word) * _FIRST
            first ^= first >> _SHIFT
            second = (second + word) * _SECOND
            second ^= second >> _OTHER
        out[i, 0] = first
        out[i, 1] = second
