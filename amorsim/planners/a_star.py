"""A*: the shortest path over eight neighbours, searched towards the goal."""

from __future__ import annotations

import attrs

from amorsim.algorithms.cells import Cells
from amorsim.planners.grid_planner import Found, GridPlanner, found_by, octile_length, run_octile

__all__ = ["AStar"]


@attrs.frozen(kw_only=True)
class AStar(GridPlanner):
    """The shortest path over the eight neighbours of cells, by A* with the octile distance.

    A straight step costs 1 cell. A diagonal one costs the square root of 2, and needs both cells next to it free.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        status, search = run_octile(cells, start, goal, self.budget, 1.0)
        return found_by(status, search, start, goal, lambda path: octile_length(path, cells.width))
