"""Along waypoints: once, round and round, or there and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.kernels import elementary
from amorsim.kernels.behaviours import routes
from amorsim.motions.ways import displacement

__all__ = ["Loop", "Oscillate", "Waypoints"]


@attrs.frozen(kw_only=True)
class _Route(Motion):
    """From waypoint to waypoint on straight lines, at one speed; a step past a waypoint cuts the corner.

    Subclasses define the `order` of the waypoints.
    """

    order: ClassVar[int]

    waypoints: tuple[tuple[float, float], ...] = parameter(
        unit="m", frame="world", help="places [x, y] in the world, in order"
    )
    speed: float = parameter(1.0, unit="m/s", ge=0, help="at which it goes")
    pause: float = parameter(0.0, unit="s", ge=0, help="how long it rests at each waypoint")
    blocked: str = parameter(
        "wait",
        choices=("wait", "skip"),
        help="what it does when something is in the way: wait until the way is free, or leave this waypoint out",
    )
    patience: float = parameter(1.0, unit="s", ge=0, help="how long it is blocked before it skips a waypoint")
    faces: str = parameter("ahead", choices=("ahead", "fixed"), help="whether it turns to where it goes")
    turn_rate: float = parameter(3.0, unit="rad/s", ge=0, help="how fast it turns, while it goes on")

    def __attrs_post_init__(self) -> None:
        if not self.waypoints:
            raise ParameterError("waypoints", "expected one waypoint [x, y] at least, got none")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The waypoints."""
        return [(f"waypoints.{i}", x, y) for i, (x, y) in enumerate(self.waypoints)]

    def default_start(self) -> tuple[float, float, float]:
        """At the first waypoint, looking towards the second."""
        x, y = self.waypoints[0]
        ahead = self.waypoints[min(1, len(self.waypoints) - 1)]
        heading = float(elementary.arctan2(ahead[1] - y, ahead[0] - x))
        return float(x), float(y), heading if self.faces == "ahead" else 0.0

    def start(self, context: Context) -> State:
        """Heads for the first waypoint: the fields of a `Progress`, by name."""
        rows = context.rows
        state: State = {name: np.zeros((rows, 1), dtype=np.int64) for name in ("following", "last_following")}
        state |= {name: np.ones((rows, 1), dtype=np.int64) for name in ("way", "last_way")}
        state |= {name: np.zeros((rows, 1)) for name in ("rest", "last_rest", "blocked")}
        return state

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The way of a step, past waypoints if it reaches any; straight from its start to its end."""
        progress = routes.Progress(**state)
        ways, points = np.empty((view.rows, 3)), np.ascontiguousarray(np.asarray(self.waypoints), dtype=np.float64)
        rules = self.order, self.blocked == "skip", self.faces == "ahead", dt
        given: Any = self.speed, self.pause, self.patience, self.turn_rate, *rules
        routes.follow_route(view.body_pose, view.free, points, progress, ways, *given)
        return displacement(view, ways[:, :1], ways[:, 1:2], ways[:, 2:])


@attrs.frozen(kw_only=True)
class Waypoints(_Route):
    """Goes from waypoint to waypoint, once, and stays at the last.

    An obstacle without a pose starts at the first one.
    """

    order: ClassVar[int] = routes.ONCE


@attrs.frozen(kw_only=True)
class Loop(_Route):
    """Goes from waypoint to waypoint, and from the last to the first, round and round.

    An obstacle without a pose starts at the first one.
    """

    order: ClassVar[int] = routes.ROUND


@attrs.frozen(kw_only=True)
class Oscillate(_Route):
    """Goes from waypoint to waypoint, at the last turns back, at the first again, there and back.

    An obstacle without a pose starts at the first one.
    """

    order: ClassVar[int] = routes.BACK
