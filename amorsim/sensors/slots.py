"""Readings that are tables with a slot for each thing found."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts.side import Side

__all__ = ["table_of"]


def table_of(values: Array, range_: int, empty: tuple[float, ...]) -> tuple[Array, Side]:
    """Values `(N, slots, columns)` flattened to a reading `(N, slots * columns)`, and side information for the chain.

    The side information holds for each value its ``slot``, the ``range`` [m] of the slot's thing, from column
    `range_`, and the value that an ``empty`` slot reads.
    """
    rows, slots, columns = values.shape
    size = slots * columns
    side = Side(
        slot=lambda: np.tile(np.repeat(np.arange(slots, dtype=np.float64), columns), (rows, 1)),
        range=lambda: np.repeat(values[:, :, range_], columns, axis=1),
        empty=lambda: np.tile(np.tile(empty, slots), (rows, 1)),
    )
    return values.reshape(rows, size), side
