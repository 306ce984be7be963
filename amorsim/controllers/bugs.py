"""Avoiders that follow borders, and the nearness diagram."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Beliefs, Context, Draws, State, parameter
from amorsim.controllers.headed import Headed
from amorsim.kernels.avoidance.bugs import BUG_COLUMNS, bug2, nearness, tangent_bug

__all__ = ["Bug2", "NearnessDiagram", "TangentBug"]


_SECTORS = 180


@attrs.frozen(kw_only=True)
class _Bug(Headed):
    kernel: ClassVar[Callable[..., None]]

    range_max: float = parameter(0.5, unit="m", gt=0, help="how far it looks")

    def start_steering(self, context: Context) -> State:
        """State: that of all avoiders that choose a direction, and a bug's memory."""
        rows = context.rows
        return {
            **super().start_steering(context),
            "histogram": np.zeros((rows, _SECTORS), dtype=bool),
            "bug": np.full((rows, BUG_COLUMNS), np.nan),
            "step": np.full((rows, 1), context.dt),
        }

    def bearing(self, points: Array, room: Array, target: Array, pose: Array, state: State, draws: Draws) -> Array:
        """The direction to the goal, or along a border."""
        bearing = np.empty((len(target), 1))
        step = float(state["step"][0, 0]) if len(target) else 0.0
        asked: Any = (points, room, target, pose, self.range_max, step, state["histogram"], state["bug"], bearing)
        type(self).kernel(*asked)
        return bearing

    def beliefs(self, state: State) -> Beliefs:
        """Also whether it follows a border."""
        return {**super().beliefs(state), "follows": state["bug"][:, 4:5] == 1.0}


@attrs.frozen(kw_only=True)
class Bug2(_Bug):
    """Drives straight for its goal, and round what is in the way until it is back on its line, nearer to the goal.

    The border stays to its right. After V. Lumelsky and A. Stepanov, "Path-planning strategies for a point mobile
    automaton moving amidst unknown obstacles of arbitrary shape", Algorithmica 2, 1987: with perfect sensing it gets
    to any goal that there is a way to. It needs a sensor that sees to its right.

    Parameters
    ----------
    range_max
        Distance at which something is in the way [m].
    """

    kernel: ClassVar[Callable[..., None]] = staticmethod(bug2)


@attrs.frozen(kw_only=True)
class TangentBug(_Bug):
    """Drives for its goal, or for the edge of what is in the way, as far as it sees; along a border where that fails.

    After I. Kamon, E. Rimon and E. Rivlin, "TangentBug: a range-sensor-based navigation algorithm", IJRR 17 (9), 1998,
    with sectors for its graph of tangents. It takes shorter ways than `Bug2`, the farther it sees.

    Parameters
    ----------
    range_max
        How far it looks [m].
    """

    kernel: ClassVar[Callable[..., None]] = staticmethod(tangent_bug)

    range_max: float = parameter(2.0, unit="m", gt=0, help="how far it looks")


@attrs.frozen(kw_only=True)
class NearnessDiagram(Headed):
    """Drives to goals through the open region nearest to the goal, and away from what is near.

    After J. Minguez and L. Montano, "Nearness diagram (ND) navigation: collision avoidance in troublesome scenarios",
    IEEE Transactions on Robotics and Automation 20 (1), 2004.

    Parameters
    ----------
    sectors
        How many directions there are.
    range_max
        How far it looks [m].
    turn_distance
        Distance from the circle around its footprint from which on it turns away from things [m].
    """

    sectors: int = parameter(180, ge=8, le=100_000, static=True, help="how many directions there are")
    range_max: float = parameter(1.5, unit="m", gt=0, help="how far it looks")
    turn_distance: float = parameter(0.2, unit="m", gt=0, help="distance from which on it turns away from things")

    def start_steering(self, context: Context) -> State:
        """State: that of all avoiders that choose a direction, and the diagram."""
        return {**super().start_steering(context), "histogram": np.zeros((context.rows, self.sectors), dtype=bool)}

    def bearing(self, points: Array, room: Array, target: Array, pose: Array, state: State, draws: Draws) -> Array:
        """The direction through the region."""
        bearing = np.empty((len(target), 1))
        nearness(points, room, target, self.range_max, self.turn_distance, state["histogram"], bearing)
        return bearing

    def beliefs(self, state: State) -> Beliefs:
        """Also which directions are blocked, the first one behind the robot, anticlockwise."""
        return {**super().beliefs(state), "histogram": state["histogram"].copy()}
