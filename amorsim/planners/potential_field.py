"""Potential field: downhill towards the goal, until the goal or a trap."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np

from amorsim.algorithms.cells import Cells, gaps_to_walls, place_of
from amorsim.array_types import Array
from amorsim.contracts import Plan
from amorsim.core.errors import PlanError
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter
from amorsim.core.shapes import Shape
from amorsim.planners.grid_planner import Found, GridPlanner, octile_length
from amorsim.planners.on_cells import are_joined, free_ends

__all__ = ["Potential", "PotentialField"]


@attrs.frozen(kw_only=True, eq=False)
class Potential:
    """The potential of a goal on a map, and the places at which a robot going downhill stops."""

    values: Array
    """(rows, cols), row 0 lowest; inf in cells that are not free."""
    traps: Array
    """(K, 2) [m] in the world: cells none of whose neighbours lies lower, other than the goal's."""
    side: float
    """Side of a cell [m]."""


@attrs.frozen(kw_only=True)
class PotentialField(GridPlanner):
    """Goes downhill in a potential that pulls towards the goal and pushes away from walls, and may end in a trap.

    The potential is the distance to the goal [m], and within `influence` of a wall, at a gap g, more by
    ``strength * (1 / g - 1 / influence)**2 / 2``. A robot that follows it needs no map and no memory; but where walls
    lie across its way it comes to rest before it reaches the goal. Then the status is ``"unreachable"``, the message
    states where it rests and whether there is a path, and `Plan.searched` leads there. `potential` gives all traps.

    After O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", IJRR 5, 1986; on why there are
    traps, Y. Koren and J. Borenstein, "Potential field methods and their inherent limitations", ICRA 1991.
    """

    influence: float = parameter(0.5, unit="m", gt=0, help="gap within which walls push away")
    strength: float = parameter(0.02, unit="m^3", ge=0, help="of the push")

    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a robot with this footprint; see `amorsim.Planner.plan`."""
        plan = super().plan(world, start, goal, footprint=footprint)
        if plan.status != "unreachable":
            return plan
        cells = self.cells_of(world, footprint)
        ends = free_ends(cells, place_of(start, "start"), place_of(goal, "goal"))
        if isinstance(ends, Plan) or not are_joined(cells.free, cells.width, *ends):
            return plan
        x, y = plan.searched[-1].tolist()
        left = math.dist((x, y), place_of(goal, "goal")[:2])
        message = (
            f"it rests in a trap of the potential at ({x:.3f}, {y:.3f}), {left:.3g} m from the goal; there is a path, "
            "which a planner that searches finds"
        )
        return attrs.evolve(plan, message=message)

    def search(self, cells: Cells, start: int, goal: int) -> Found:
        """Go downhill from one free cell to the next, where it is steepest."""
        values = self._values(cells, goal)
        path = [start]
        while path[-1] != goal and len(path) <= self.budget:
            lower = _steepest(cells, values, path[-1])
            if lower == path[-1]:
                return Found("unreachable", np.empty(0, np.int32), math.inf, np.array(path, np.int32))
            path.append(lower)
        found = np.array(path, np.int32)
        if len(path) > self.budget:
            return Found("budget", np.empty(0, np.int32), math.inf, found[: self.budget])
        return Found("found", found, octile_length(found, cells.width), found)

    def potential(self, world: Map, goal: Sequence[float], *, footprint: Shape | None = None) -> Potential:
        """The potential of a goal, and its traps.

        Raises
        ------
        PlanError
            If the goal is not two or three finite numbers or is not in a free cell.
        """
        x, y, _ = place_of(goal, "goal")
        cells = self.cells_of(world, footprint)
        place = cells.cell_at(x, y)
        if place is None or not cells.free[place]:
            raise PlanError(f"the goal ({x:g}, {y:g}) is not in a free cell, so no potential leads to it")
        values = self._values(cells, place)
        is_trap = np.isfinite(values)
        for step in _steps(cells.width):
            other = np.roll(values, -step)
            if abs(step) not in (1, cells.width):  # a diagonal step needs both cells next to it free
                across = 1 if step % cells.width == 1 else -1
                beside = np.isfinite(np.roll(values, -across)) & np.isfinite(np.roll(values, across - step))
                other = np.where(beside, other, math.inf)
            is_trap &= other >= values
        is_trap[place] = False
        shape = (-1, cells.width)
        return Potential(
            values=values.reshape(shape)[1:-1, 1:-1], traps=cells.places(np.flatnonzero(is_trap)), side=cells.side
        )

    def _values(self, cells: Cells, goal: int) -> Array:
        """The potential (n,) of each cell, inf where it is not free."""
        numbers = np.arange(len(cells.free))
        rows, cols = numbers // cells.width - goal // cells.width, numbers % cells.width - goal % cells.width
        values = cells.side * np.sqrt((rows * rows + cols * cols).astype(np.float64))
        # From the middle of a cell, and from the footprint's border.
        gaps = (np.sqrt(np.maximum(gaps_to_walls(cells), 0)) + 0.5) * cells.side - cells.reach
        near = np.maximum(gaps, 0.5 * cells.side)
        push = 0.5 * self.strength * (1.0 / near - 1.0 / self.influence) ** 2
        values += np.where(near < self.influence, push, 0.0)
        return np.where(cells.free.view(np.bool_), values, math.inf)


def _steps(width: int) -> tuple[int, ...]:
    return (1, -1, width, -width, width + 1, width - 1, 1 - width, -1 - width)


def _steepest(cells: Cells, values: Array, cell: int) -> int:
    """The neighbour with the steepest descent by a step that cuts no corner; the cell itself if none is lower."""
    best, most = cell, 0.0
    for up in (0, cells.width, -cells.width):
        for across in (0, 1, -1):
            other = cell + up + across
            fall = values[cell] - values[other]
            slope = fall / math.sqrt(2.0) if up and across else fall
            if slope > most and cells.free[cell + up] and cells.free[cell + across]:
                best, most = other, slope
    return best
