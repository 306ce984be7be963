"""raycast2D (C): Bresenham's line from the middle of a cell, through an array; it only casts rays."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.task import BEAMS, RANGE_MAX
from benchmarks.worlds import World

__all__ = ["COMPUTES", "Raycast2D"]

Array = npt.NDArray[np.float64]

COMPUTES = (
    "Bresenham in C from cell to cell, one call a scan, approximate; its end cells taken as ranges to where they are "
    "entered"
)


class Raycast2D:
    """Its lidar in a bitmap world.

    Attributes
    ----------
    poses
        `(N, 3)`: of the given ones those from which no beam leaves the image (its coordinates are unsigned), moved to
        the middles of their cells.

    Raises
    ------
    ImportError
        If it is not installed.
    """

    def __init__(self, world: World, poses: Array) -> None:
        module: Any = importlib.import_module("raycast2D.raycast2D")
        side = world.map.resolution
        self._side, self._reach = side, round(RANGE_MAX / side)
        inside = (poses[:, :2] > RANGE_MAX + side) & (poses[:, :2] < np.array(world.size) - RANGE_MAX - side)
        self.poses = poses[inside.all(axis=1)]
        self._cells = np.floor(self.poses[:, :2] / side).astype(int)
        self.poses[:, :2] = (self._cells + 0.5) * side
        # Its headings count from the y axis.
        headings = (self.poses[:, 2] + math.pi / 2.0).tolist()
        self._starts = [(x, y, heading) for (x, y), heading in zip(self._cells.tolist(), headings, strict=True)]
        free = (1 - world.cells).astype(np.uint8)
        self._lidar = module.Lidar2D(num_rays=BEAMS, FOV=180, ray_length=self._reach, occupancy_grid=free)

    def cast(self) -> list[Any]:
        """The end cells of all beams, a scan for each pose."""
        return [self._lidar.scan(start, only_true_collisions=False) for start in self._starts]

    def ranges(self) -> Array:
        """Ranges `(N, k)` [m] to where the end cells are entered.

        A line enters a cell half a cell before its middle, along the axis in which it goes farther. Where nothing was
        met the end cell is the beam's end.
        """
        offsets = np.array(self.cast(), dtype=np.float64) - self._cells[:, None]
        farther = np.maximum(np.abs(offsets).max(axis=2), 1.0)
        cells = np.hypot(offsets[..., 0], offsets[..., 1])
        entered: Array = np.where(cells >= self._reach - 1.0, cells, cells * (1.0 - 0.5 / farther))
        return entered * self._side
