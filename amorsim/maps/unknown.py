"""Maps with unknown cells: how rays and bodies treat them, an option shared by loaders, and how to make them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.grid import Grid

__all__ = ["OCCUPIED", "UNKNOWN", "map_of_classes", "unknown_as"]

OCCUPIED, UNKNOWN = 1, 2
"""Bits of a cell's class; 0 is a cell that is known to be free."""


def unknown_as() -> Any:
    """The field ``unknown`` of a loader."""
    return parameter(
        "free",
        choices=("free", "occupied"),
        help="what unknown cells are to beams and bodies; robots that are given no place start in known cells",
    )


def map_of_classes(
    classes: NDArray[np.uint8],
    *,
    resolution: float,
    origin: Sequence[float],
    warnings: Sequence[str],
    name: str,
) -> Map:
    """The map of cells (rows, cols) of some classes, row 0 lowest; the array is used up.

    Otherwise as `Map.from_array`. The grid of the unknown cells comes first, so that no more than two arrays of that
    size are in memory at a time.
    """
    unknown = _unknown_grid(classes, resolution)
    classes &= np.uint8(OCCUPIED)
    world = Map.from_array(classes, resolution=resolution, origin=origin, warnings=warnings, name=name)
    return world if unknown is None else attrs.evolve(world, unknown=unknown)


def _unknown_grid(classes: NDArray[np.uint8], resolution: float) -> Grid | None:
    unknown = classes & np.uint8(UNKNOWN)
    return grid_from_array(unknown, resolution) if unknown.any() else None
