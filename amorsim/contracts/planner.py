"""The contract of planners, and their answer."""

from __future__ import annotations

import abc
import math
from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.core.display import in_notebook
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape

__all__ = ["Plan", "Planner"]


@attrs.frozen(kw_only=True, eq=False)
class Plan:
    """The answer of a planner: a path from start to goal, or the reason why there is none."""

    status: str
    """``"found"``, ``"unreachable"``, ``"start_blocked"``, ``"goal_blocked"``, or ``"budget"`` if the planner's budget
    was used up before it had an answer."""
    poses: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    """(M, 3) [m, m, rad] in the world: the corners of the path, from start to goal, joined by straight lines.

    The heading is that of the line to the next pose; at the goal the one asked for, or else that of the last line. Of a
    path for a car, poses lie close together on its curves, and the heading is the car's, also where it backs. No poses
    without a path.
    """
    length: float = math.inf
    """Length of the path [m]; inf without one. Of a curve it is that of the curve, not of the lines between its poses,
    which are shorter by 0.1 % at most."""
    cost: float = math.inf
    """The cost that the planner minimised, along this path; inf without one."""
    expanded: int = 0
    """How many cells or states the planner expanded."""
    searched: Array = attrs.field(factory=lambda: np.empty((0, 2)))
    """(K, 2) [m] in the world: the places it expanded, in order, for pictures."""
    links: Array = attrs.field(factory=lambda: np.empty((0, 4)))
    """(E, 4) [m] in the world: lines x, y to x, y between places that it expanded, such as the edges of a tree, for
    pictures."""
    trailer: Array = attrs.field(factory=lambda: np.empty((0, 3)))
    """(M, 3) [m, m, rad] in the world: the poses of the trailer's axle, for each of `poses`; none without a trailer."""
    message: str = ""
    """Why there is no path, in a sentence; empty if there is one."""

    _repr_mimebundle_ = in_notebook

    @property
    def points(self) -> Array:
        """The places of the poses (M, 2) [m]."""
        return self.poses[:, :2]


class Planner(abc.ABC):
    """Finds a path on a map: a pure function of map, start, goal, footprint and its own parameters.

    The map is one that a robot was given or made, never the true world. A planner works at a cell size of its own, has
    a budget, so that it always comes to an end, and can be interrupted with Ctrl-C.
    """

    plans_headings: ClassVar[bool] = False
    """Whether its paths are for a car: with the heading in each pose, and drives backwards. Such a planner turns the
    footprint with the car, instead of taking its reach in all directions."""

    @abc.abstractmethod
    def plan(
        self, world: Map, start: Sequence[float], goal: Sequence[float], *, footprint: Shape | None = None
    ) -> Plan:
        """The plan for a robot with this footprint from `start` to `goal`, each (x, y) or (x, y, heading) [m, rad].

        Without a footprint the robot is a point. Places in walls or outside the map give a status. Raises `PlanError`
        if start or goal are not such numbers, or if the map has more cells than the planner can take.
        """
