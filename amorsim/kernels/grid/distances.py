"""Distances from every cell of an array to the nearest cell that is set, exactly.

Source: P. F. Felzenszwalb, D. P. Huttenlocher, "Distance transforms of sampled functions", Theory of Computing 8
(2012). The squares of the distances are whole numbers, so the result has no rounding but that of one root.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = ["distances"]


@kernel
def distances(cells: npt.NDArray[np.uint8], out: Array) -> None:
    """Distances in cells, middle to middle, from each cell (rows, cols) to the nearest set one; inf if none is set."""
    rows, cols = cells.shape
    for j in range(cols):
        away = math.inf
        for i in range(rows):
            away = 0.0 if cells[i, j] else away + 1.0
            out[i, j] = away
        away = math.inf
        for i in range(rows - 1, -1, -1):
            away = 0.0 if cells[i, j] else away + 1.0
            out[i, j] = min(out[i, j], away)
    # Along a row: the lower envelope of parabolas, one for each column that has a set cell.
    square = np.empty(cols)
    lowest = np.empty(cols, dtype=np.int64)  # the columns of its parabolas
    begins = np.empty(cols + 1)  # where each becomes the lowest
    for i in range(rows):
        count = 0
        for j in range(cols):
            square[j] = out[i, j] * out[i, j]
            if square[j] == math.inf:
                continue
            at = -math.inf
            while count > 0:
                k = lowest[count - 1]
                at = ((square[j] + j * j) - (square[k] + k * k)) / (2.0 * (j - k))
                if at > begins[count - 1]:
                    break
                count -= 1
                at = -math.inf
            lowest[count] = j
            begins[count] = at
            count += 1
        begins[count] = math.inf
        k = 0
        for j in range(cols):
            if count == 0:
                out[i, j] = math.inf
                continue
            while begins[k + 1] < j:
                k += 1
            out[i, j] = math.sqrt((j - lowest[k]) * (j - lowest[k]) + square[lowest[k]])
