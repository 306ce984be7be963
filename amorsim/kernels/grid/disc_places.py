"""Where a disc fits on an array of cells, and which of these places are connected."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Ints, Ints32
from amorsim.kernels.compile import kernel

__all__ = ["clear_cells", "label_parts", "number_parts"]

Cells = NDArray[np.uint8]


@kernel
def clear_cells(cells: Cells, reach: NDArray[np.uint16], beyond: int, runs: NDArray[np.uint16], out: Cells) -> None:
    """Write 1 for each cell near which no cell is set, else 0.

    Cells n rows away are near up to `reach[n]` columns. `beyond` is 1 if all cells outside the array are set. `runs`
    is room to work in, of the array's shape: short numbers, so that many are compared at once.
    """
    rows, cols = cells.shape
    far = 0xFFFF
    for i in range(rows):
        run = 0 if beyond else far
        for j in range(cols):
            run = 0 if cells[i, j] else min(run + 1, far)
            runs[i, j] = run
        run = 0 if beyond else far
        for j in range(cols - 1, -1, -1):
            run = 0 if cells[i, j] else min(run + 1, far)
            if run < runs[i, j]:
                runs[i, j] = run
    out[:] = 1
    for i in range(rows):
        for n in range(1 - reach.shape[0], reach.shape[0]):
            row = i + n
            if 0 <= row < rows:
                most = reach[abs(n)]
                for j in range(cols):
                    out[i, j] &= np.uint8(runs[row, j] > most)
            elif beyond:
                out[i] = 0


@kernel
def label_parts(cells: Cells, joined: Ints32, out: Ints32) -> int:
    """Label the set cells in `out`, and give each label's part in `joined`; returns how many parts there are.

    A part is set cells that are connected by sides; parts are numbered from 1 on. Cells that are not set have the label
    0, whose part is 0. `joined` has a number for each cell and one more.
    """
    rows, cols = cells.shape
    count = 0
    for i in range(rows):
        label = 0
        last = 0  # the label above that this run was joined to
        for j in range(cols):
            if cells[i, j] == 0:
                label = 0
                out[i, j] = 0
                continue
            if label == 0:
                count += 1
                label = count
                joined[label] = label
                last = 0
            out[i, j] = label
            if i > 0 and out[i - 1, j] not in (0, last):
                last = out[i - 1, j]
                one, other = last, label
                while joined[one] != one:
                    one = joined[one]
                while joined[other] != other:
                    other = joined[other]
                joined[max(one, other)] = min(one, other)
    parts = 0
    for label in range(1, count + 1):  # a label is joined to a lower one, which has its number already
        if joined[label] == label:
            parts += 1
            joined[label] = parts
        else:
            joined[label] = joined[joined[label]]
    joined[0] = 0
    return parts


@kernel
def number_parts(joined: Ints32, sizes: Ints, labels: Ints32) -> None:
    """Turn labels into the numbers of their parts, in place; `sizes` gets how many cells each part has, from 0 on."""
    for n in range(sizes.shape[0]):
        sizes[n] = 0
    for i in range(labels.shape[0]):
        for j in range(labels.shape[1]):
            part = joined[labels[i, j]]
            labels[i, j] = part
            sizes[part] += 1
