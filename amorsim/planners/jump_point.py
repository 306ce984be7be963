"""Jump point search: A* that skips the cells between turns."""

from __future__ import annotations

import attrs

from amorsim.algorithms.cells import Cells
from amorsim.kernels.search.jump import expand_jumps
from amorsim.planners.grid_planner import Found, GridPlanner, found_by, octile_length, run_search

__all__ = ["JumpPoint"]


@attrs.frozen(kw_only=True)
class JumpPoint(GridPlanner):
    """The shortest path over the eight neighbours of cells, by jump point search.

    It finds paths as short as those of `AStar`, usually in less time: it follows lines of free cells without putting
    them into a queue, and expands only cells where a path may have to turn. `Plan.poses` are such cells.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        status, search = run_search(
            cells,
            start,
            self.budget,
            lambda search, most: expand_jumps(search, cells.width, goal, most),
            at_a_time=200,  # each may look at all cells ahead
        )
        return found_by(status, search, start, goal, lambda path: octile_length(path, cells.width))
