"""The map that an estimator believes in, as a map."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from amorsim.array_types import AnyArray
from amorsim.core.arguments import checked
from amorsim.core.errors import MapError
from amorsim.core.maps.map import Map

__all__ = ["estimated_map"]


@checked
def estimated_map(
    beliefs: Mapping[str, AnyArray], row: int = 0, *, occupied: float = 0.65, free: float = 0.35, name: str = ""
) -> Map:
    """The occupancy grid of an estimator's beliefs as a map, which `amorsim.save_map` writes for ROS and others.

    Cells between the two bounds, and those never seen, are unknown; rays and bodies pass them.

    Parameters
    ----------
    beliefs
        Of an estimator: with ``occupancy`` (rows, cols), or (N, rows, cols) as of a frame; ``occupancy_origin`` and
        ``occupancy_resolution``.
    row
        Which of N robots, for beliefs of a frame.
    occupied
        A cell is occupied if that is more probable than this.
    free
        A cell is free if it is occupied with less than this probability.

    Raises
    ------
    MapError
        If there is no occupancy grid in the beliefs, or the bounds make no sense.
    """
    wanted = ("occupancy", "occupancy_origin", "occupancy_resolution")
    if missing := [one for one in wanted if one not in beliefs]:
        known = ", ".join(beliefs) or "nothing"
        raise MapError(
            f"beliefs: expected {missing[0]!r}, as of an estimator that maps, such as grid_mapping; got {known}"
        )
    if not 0.0 <= free <= occupied <= 1.0:
        raise MapError(f"expected 0 <= free <= occupied <= 1, got free {free!r} and occupied {occupied!r}")
    grid, origin, resolution = (np.asarray(beliefs[one]) for one in wanted)
    if grid.ndim == 3:
        if not 0 <= row < len(grid):
            raise MapError(f"row: expected one of the {len(grid)} robots, counted from 0, got {row!r}")
        grid, origin, resolution = grid[row], origin[row], resolution[row]
    is_occupied, is_free = grid > occupied, grid < free  # neither, where nan
    x, y = origin.tolist()
    return Map.from_array(
        is_occupied,
        unknown=~(is_occupied | is_free),
        resolution=float(resolution),
        origin=(x, y, 0.0),
        name=name,
    )
