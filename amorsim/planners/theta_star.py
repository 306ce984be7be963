"""Theta*: short paths at any angle."""

from __future__ import annotations

import math
from typing import ClassVar

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells
from amorsim.array_types import Ints32
from amorsim.core.parameters import parameter
from amorsim.kernels.search.any_angle import expand_any_angle
from amorsim.planners.grid_planner import Found, GridPlanner, found_by, run_search

__all__ = ["ThetaStar"]


@attrs.frozen(kw_only=True)
class ThetaStar(GridPlanner):
    """A short path at any angle, by Theta*: A* whose cells may be reached in a straight line from afar.

    All lines lead from the centre of a cell to that of another, or to start and goal, and touch free cells only. The
    path is usually a few per cent shorter than that of `AStar`, and has few corners; it is not always the shortest of
    all. After K. Daniel and others, "Theta*: any-angle path planning on grids", JAIR 39, 2010.
    """

    any_angle: ClassVar[bool] = True

    lazy: bool = parameter(False, help="look along a line only once its cell is expanded: fewer looks, similar paths")

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        status, search = run_search(
            cells,
            start,
            self.budget,
            lambda search, most: expand_any_angle(search, cells.width, goal, self.lazy, most),
            at_a_time=2_000,  # with eight lines of sight each
        )
        return found_by(status, search, start, goal, lambda path: _length(path, cells.width))


def _length(path: Ints32, width: int) -> float:
    up, across = np.diff(path // width), np.diff(path % width)
    return math.fsum(np.sqrt((up * up + across * across).astype(np.float64)).tolist())
