"""Dijkstra's algorithm: the shortest path over eight neighbours, searched in all directions."""

from __future__ import annotations

import attrs

from amorsim.algorithms.cells import Cells
from amorsim.planners.grid_planner import Found, GridPlanner, found_by, octile_length, run_octile

__all__ = ["Dijkstra"]


@attrs.frozen(kw_only=True)
class Dijkstra(GridPlanner):
    """The shortest path over the eight neighbours of cells, by Dijkstra's algorithm.

    It finds what `AStar` finds, and expands every cell that is nearer to the start than the goal is.
    """

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Search for a path between two free cells."""
        status, search = run_octile(cells, start, goal, self.budget, 0.0)
        return found_by(status, search, start, goal, lambda path: octile_length(path, cells.width))
