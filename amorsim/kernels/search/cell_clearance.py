"""The room around cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Ints32
from amorsim.kernels.compile import kernel

__all__ = ["squared_gaps"]


@kernel
def squared_gaps(free: NDArray[np.uint8], most: int, gaps: Ints32, out: Ints32) -> None:
    """Squared gap [cells^2] between each cell and the nearest that is not free, (rows, cols), up to ``most**2``.

    The gap between two cells is the distance of their nearest points: 0 if they share a side or a corner. A blocked
    cell has -1. Outside the array everything is blocked. `gaps` (rows, cols) is to work in.
    """
    rows, cols = free.shape
    # In each column, the gap to the nearest blocked cell of the column: -1 at one, 0 next to one.
    for col in range(cols):
        gap = -1
        for row in range(rows):
            gap = min(gap + 1, most) if free[row, col] else -1
            gaps[row, col] = gap
        gap = -1
        for row in range(rows - 1, -1, -1):
            gap = min(gap + 1, most) if free[row, col] else -1
            gaps[row, col] = min(gaps[row, col], gap)
    for row in range(rows):
        for col in range(cols):
            if free[row, col] == 0:
                out[row, col] = -1
                continue
            least = most * most
            for away in range(most + 2):
                across = max(away - 1, 0)
                if across * across >= least:
                    break
                for side in (-1, 1):
                    other = col + side * away
                    up = max(gaps[row, other], 0) if 0 <= other < cols else 0
                    least = min(least, across * across + up * up)
            out[row, col] = least
