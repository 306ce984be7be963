"""Worlds in which a disc reaches every free place: pockets that it cannot reach are filled."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Ints, Ints32
from amorsim.core.errors import MapError
from amorsim.kernels.grid.disc_places import clear_cells, label_parts, number_parts

__all__ = ["cells_of", "nearest", "open_parts", "places_for", "reach_of", "without_pockets"]

Cells = NDArray[np.uint8]

_MOST_ROUNDS = 1000


def reach_of(clearance: float) -> Ints:
    """For each row offset, up to which column a cell is nearer than `clearance` [cells] to a cell's middle."""
    reach: list[int] = []
    while max(len(reach) - 0.5, 0.0) < clearance:
        rows = max(len(reach) - 0.5, 0.0)
        columns = 0
        while (columns + 0.5) ** 2 + rows**2 < clearance**2:
            columns += 1
        reach.append(columns)
    return np.array(reach or [0], dtype=np.int64)


def places_for(cells: Cells, clearance: float, resolution: float) -> Cells:
    """1 for each cell around whose middle a disc of `clearance` [m], and half a cell more, is free.

    Such a disc moves from one of these cells to the next, along rows and columns, and keeps its clearance on the way.
    Outside the array everything is occupied.
    """
    return _clear(cells, reach_of(clearance / resolution + 0.5), 1)


def open_parts(places: Cells) -> tuple[Ints32, Ints]:
    """The connected parts of the cells that are set, numbered from 1, and the number of cells of each from 0 on."""
    labels, joined, count = _labelled(places)
    sizes = np.empty(count + 1, dtype=np.int64)
    number_parts(joined, sizes, labels)
    return labels, sizes


def _labelled(places: Cells) -> tuple[Ints32, Ints32, int]:
    """The labels of cells, the part of each label, and the number of parts, as `label_parts` gives them."""
    labels, joined = np.empty(places.shape, dtype=np.int32), np.empty(places.size + 1, dtype=np.int32)
    return labels, joined, label_parts(places, joined, labels)


def without_pockets(cells: Cells, clearance: float, resolution: float) -> tuple[Cells, Cells]:
    """The cells with all filled in that a disc cannot reach from the largest part, and the `places_for` it.

    Raises
    ------
    MapError
        If the disc fits nowhere.
    """
    reach = reach_of(clearance / resolution + 0.5)
    cells = cells.copy()
    for rounds in range(_MOST_ROUNDS):  # each fills at least a cell, and hardly any world needs more than two
        places = _clear(cells, reach, 1)
        count = _labelled(places)[2]
        if count == 0:
            break
        if count == 1:
            return (_without_cracks(cells, places) if rounds else cells), places
        parts, sizes = open_parts(places)
        main = (parts == 1 + int(np.argmax(sizes[1:]))).astype(np.uint8)
        pockets = places & (1 - main)
        # What the disc covers in the largest part stays free, so that this part stays as it is.
        filled = (1 - _clear(pockets, reach, 0)) & _clear(main, reach, 0)
        cells |= filled if filled.any() else pockets
    raise MapError(
        f"a disc with a radius of {clearance:g} m fits nowhere in this world; take a smaller clearance, or wider ways"
    )


def _without_cracks(cells: Cells, main: Cells) -> Cells:
    """The cells, with free ones filled that are not connected to `main`: they are rests of pockets."""
    parts, sizes = open_parts(1 - cells)
    return cells if len(sizes) == 2 else (parts != parts.flat[int(np.argmax(main))]).astype(np.uint8)


def nearest(places: Cells, row: float, col: float) -> tuple[int, int]:
    """The set cell at a place given in cells, or else the nearest one; the first of equally near ones."""
    at = int(row), int(col)
    if 0 <= at[0] < places.shape[0] and 0 <= at[1] < places.shape[1] and places[at]:
        return at
    rows, cols = np.nonzero(places)
    best = int(np.argmin((rows + 0.5 - row) ** 2 + (cols + 0.5 - col) ** 2))
    return int(rows[best]), int(cols[best])


def _clear(cells: Cells, reach: Ints, beyond: int) -> Cells:
    out = np.empty_like(cells)
    # A disc that reaches farther than 65,535 cells fits into no world that is generated.
    short = np.minimum(reach, 0xFFFF).astype(np.uint16)
    clear_cells(cells, short, beyond, np.empty(cells.shape, dtype=np.uint16), out)
    return out


def cells_of(metres: float, resolution: float) -> int:
    """The number of cells that a length is, to the nearest, at least 1."""
    return max(1, math.floor(metres / resolution + 0.5))
