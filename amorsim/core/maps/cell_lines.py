"""Lines that draw the cells of a map, for formats that hold lines only."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array, Bools, Ints, Ints32
from amorsim.core.maps.map import Map, Place

__all__ = ["extent_of", "placed", "to_world", "wall_lines"]


def wall_lines(world: Map) -> Array:
    """Walls (M, 4) x0, y0, x1, y1 [m] in the world that fill the occupied cells of a map, and no others.

    They are the walls that the map was made from, or else lines along rows and columns, from the middle of a cell to
    that of another. Drawn on a grid with the same borders, these touch no other cell.
    """
    if world.segments is not None:
        return world.segments
    cells = world.to_array() != 0
    # Each cell belongs to the longer of its runs, so that a straight wall is one line, along it.
    along, up = _run_lengths(cells), _run_lengths(cells.T).T
    flat = cells & (along >= up)
    rows, first, last = _runs(flat)
    columns, low, high = _runs((cells & ~flat).T)
    ends = np.concatenate(
        [np.stack((first, rows, last, rows), axis=-1), np.stack((columns, low, columns, high), axis=-1)]
    )
    places = (ends + 0.5).reshape(-1, 2) * world.resolution
    return to_world(world, places).reshape(-1, 4)


def extent_of(world: Map) -> tuple[float, float, float, float]:
    """xmin, ymin, xmax, ymax [m] of a map in the world, however it is turned."""
    width, height = world.size
    corners = to_world(world, np.array([[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]]))
    (xmin, ymin), (xmax, ymax) = corners.min(axis=0).tolist(), corners.max(axis=0).tolist()
    return xmin, ymin, xmax, ymax


def to_world(world: Map, places: Array) -> Array:
    """Places (n, 2) [m] of a map's frame in the world."""
    return placed(world.origin, places)


def placed(origin: Place, places: Array) -> Array:
    """Places (n, 2) [m] in the frame of a map with this `origin`, in the world."""
    x, y, yaw = origin
    if yaw == 0.0:
        return np.asarray(places + np.array([x, y]))
    c, s = math.cos(yaw), math.sin(yaw)
    return np.stack((x + c * places[:, 0] - s * places[:, 1], y + s * places[:, 0] + c * places[:, 1]), axis=-1)


def _runs(cells: Bools) -> tuple[Ints, Ints, Ints]:
    """Row, first and last column of each run of true cells in a row."""
    steps = np.diff(np.pad(cells, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    rows, first = np.nonzero(steps == 1)
    _, after = np.nonzero(steps == -1)
    return rows, first, after - 1


def _run_lengths(cells: Bools) -> Ints32:
    """The length of the run in its row for each true cell; 0 for others."""
    _, first, last = _runs(cells)
    lengths = np.zeros(cells.shape, np.int32)
    lengths[cells] = np.repeat(last - first + 1, last - first + 1)
    return lengths
