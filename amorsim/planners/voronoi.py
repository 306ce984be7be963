"""Voronoi: paths that keep as far from walls as they can."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, gaps_to_walls
from amorsim.array_types import Ints32
from amorsim.kernels.search.weighted import expand_priced
from amorsim.planners.grid_planner import Found, GridPlanner, found_by, octile_length, run_search
from amorsim.planners.on_cells import are_joined

__all__ = ["Voronoi"]


@attrs.frozen(kw_only=True)
class Voronoi(GridPlanner):
    """The path with most clearance, along the middle between walls.

    First, no path passes a wider narrowest place: the least gap between the path's cells and the walls is the largest
    that there is between start and goal. Second, of those paths it takes the one with the least integral of length over
    the squared gap to the walls, which runs near the edges of the walls' Voronoi diagram. `Plan.cost` is the length.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        gaps = gaps_to_walls(cells)
        widest = _widest(cells, gaps, start, goal)
        if widest is not None:
            cells = attrs.evolve(cells, free=cells.free & (gaps >= widest).view(np.uint8))
        # A cell's middle is half a cell farther from the walls than its border.
        price = 1.0 / (np.sqrt(np.maximum(gaps, 0)) + 0.5) ** 2
        status, search = run_search(
            cells, start, self.budget, lambda search, most: expand_priced(search, price, cells.width, goal, most)
        )
        return found_by(status, search, start, goal, lambda path: octile_length(path, cells.width))


def _widest(cells: Cells, gaps: Ints32, start: int, goal: int) -> int | None:
    """The largest squared gap [cells^2] that some path from start to goal keeps; None without a path."""
    steps = np.unique(gaps[cells.free.view(np.bool_)])
    steps = steps[steps <= min(gaps[start], gaps[goal])]
    low, high = -1, len(steps)
    while high - low > 1:
        middle = (low + high) // 2
        free = cells.free & (gaps >= steps[middle]).view(np.uint8)
        low, high = (middle, high) if are_joined(free, cells.width, start, goal) else (low, middle)
    return None if low < 0 else int(steps[low])
