"""The world as one matrix: walls and robots."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import shapely

from amorsim.core.errors import MapError
from amorsim.core.maps.map import Place
from amorsim.simulation.world.world import World

__all__ = ["occupancy"]

FREE, WALL, ROBOT = 0, 1, 2


def occupancy(world: World, replica: int, resolution: float) -> npt.NDArray[np.uint8]:
    """Cells `(rows, columns)` of `resolution` [m] in the map's frame, row 0 at the bottom.

    0: the whole cell is free; 1: anything in it is occupied; 2: the inside of a body's footprint overlaps it (not its
    border alone). Bodies are drawn over walls.

    Raises
    ------
    MapError
        If the resolution is not above 0, or the array would take more than 1 GB.
    """
    if not math.isfinite(resolution) or resolution <= 0.0:
        raise MapError(f"occupancy: expected a resolution [m] > 0, got {resolution!r}")
    map_ = world.terrain.at(replica)
    cells = map_.to_array(resolution=resolution).copy()
    cells[cells > 0] = WALL
    first = int(world.first[replica])
    for body in range(first, first + world.count):
        _draw(cells, world, body, map_.origin, resolution)
    return cells


def _draw(cells: npt.NDArray[np.uint8], world: World, body: int, origin: Place, resolution: float) -> None:
    x, y, heading = world.poses[body]
    footprint = shapely.affinity.rotate(
        shapely.Polygon(world.shapes[body % world.count].outline), heading, (0, 0), True
    )
    footprint = shapely.affinity.translate(footprint, x, y)
    origin_x, origin_y, yaw = origin
    footprint = shapely.affinity.translate(footprint, -origin_x, -origin_y)
    footprint = shapely.affinity.rotate(footprint, -yaw, (0, 0), True)
    left, low, right, high = (math.floor(side / resolution) for side in footprint.bounds)
    rows = np.arange(max(low, 0), min(high + 1, cells.shape[0]))
    columns = np.arange(max(left, 0), min(right + 1, cells.shape[1]))
    column, row = (grid.ravel() for grid in np.meshgrid(columns, rows))
    boxes = shapely.box(column * resolution, row * resolution, (column + 1) * resolution, (row + 1) * resolution)
    inside = shapely.intersects(boxes, footprint) & ~shapely.touches(boxes, footprint)
    cells[row[inside], column[inside]] = ROBOT
