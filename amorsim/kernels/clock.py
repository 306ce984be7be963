"""The clocks of rows: tick, time, and the tick's place in the counter of random draws."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel

__all__ = ["advance_clocks"]


@kernel
def advance_clocks(tick: Ints, dt: float, time: Array, counter: NDArray[np.uint32]) -> None:
    """Put rows to their next `tick` (N, 1), and set their `time` (N, 1) [s] and the last column of `counter` (N, 3).

    The time is a product and not a sum: it is still right after a billion steps.
    """
    for i in range(tick.shape[0]):
        tick[i, 0] += 1
        time[i, 0] = tick[i, 0] * dt
        counter[i, 2] = np.uint32(tick[i, 0])
