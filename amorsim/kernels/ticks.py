"""The next tick of rows, in all the forms in which it is asked for."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel

__all__ = ["tell_time"]

Ints = NDArray[np.int64]


@kernel
def tell_time(before: Ints, dt: float, counter: NDArray[np.uint32], tick: Ints, time: NDArray[np.float64]) -> None:
    """Write ticks (N, 1) one after those `before`, their times [s], and the ticks that draws count by.

    The last are column 2 of `counter` (N, 3). Time is multiplied, never added up: a billion steps later it is still
    right.
    """
    for i in range(before.shape[0]):
        tick[i, 0] = before[i, 0] + 1
        time[i, 0] = tick[i, 0] * dt
        counter[i, 2] = np.uint32(tick[i, 0])
