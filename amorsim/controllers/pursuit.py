"""Pure pursuit: driving along waypoints."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence

import attrs
import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    ControllerBinding,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.controller import command_bound
from amorsim.contracts.joints import at_rest
from amorsim.controllers.abilities import Course, abilities, heading_poses
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.kernels.behaviours import pure_pursuit

__all__ = ["Pursuit", "next_stops", "turn_back"]


_LEAST = 1e-6  # [m] between waypoints


@attrs.frozen(kw_only=True)
class Pursuit(Controller):
    """Drives along straight lines from where it starts through waypoints, by its estimate, and stops at the last.

    Pure pursuit (R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992):
    it steers to the point on the path that lies `lookahead` ahead, along the circle that leads there from its heading.
    It cuts corners, the more the longer `lookahead` is. It avoids no obstacles.

    Any drive will do. A drive that turns in place does so when the point is far off its heading. One that cannot takes
    its sharpest curve, and needs room for it.

    It drives backwards where `reverse` is set: it stops at the waypoint, changes direction, and goes on with its rear
    in front. A car can thus back into a bay, or turn round in a narrow place.

    Parameters
    ----------
    waypoints
        Places in the world [m], one at least.
    loop
        Whether it goes on from the last waypoint to the first, for ever.
    reverse
        Which legs it drives backwards. ``"never"``: none. ``"auto"``: a first leg that leads behind it; and it changes
        direction at each waypoint where the path turns back by more than a right angle. A list: the legs to the
        waypoints with these numbers, from 0.
    speed
        Its speed [m/s]; slower in curves that need more than `turn_rate`.
    lookahead
        Distance along the path to the point that it steers to [m].
    tolerance
        Distance along the path [m] from the last waypoint, or one where it changes direction, at which it stops.
    turn_rate
        Fastest turning rate [rad/s].
    """

    waypoints: tuple[tuple[float, float], ...] = parameter(
        unit="m", frame="world", static=True, help="places in the world, in order"
    )
    loop: bool = parameter(False, static=True, help="whether it goes round for ever")
    reverse: str | tuple[int, ...] = parameter(
        "never",
        ge=0,
        choices=("never", "auto"),
        static=True,
        help="legs that it drives backwards: none, as the path asks for it, or to the waypoints of these numbers",
    )
    speed: float = parameter(0.3, unit="m/s", gt=0, help="at which it drives")
    lookahead: float = parameter(0.5, unit="m", gt=0, help="how far ahead on the path it looks")
    tolerance: float = parameter(
        0.02, unit="m", gt=0, help="how near to the last waypoint, or where it turns about, it stops"
    )
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="fastest that it turns")

    def __attrs_post_init__(self) -> None:
        if not self.waypoints:
            raise ParameterError("waypoints", "expected one waypoint at least, got none")
        last = len(self.waypoints) - 1
        beyond = [number for number in self.reverse if isinstance(number, int) and number > last]
        if beyond:
            raise ParameterError("reverse", f"expected numbers of waypoints, 0 to {last}, got {beyond[0]}")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The waypoints."""
        return [(f"waypoints.{i}", x, y) for i, (x, y) in enumerate(self.waypoints)]

    def start(self, context: Context) -> State:
        """The paths from where the robots stand, and what they know of their drives.

        Raises
        ------
        ComponentError
            If a loop has fewer than two different places, or a robot stands on the only waypoint.
        """
        rows = context.rows
        places, numbers = [np.array(self.waypoints[0])], [0]
        for number, place in enumerate(self.waypoints):
            if np.hypot(*(place - places[-1])) > _LEAST:
                places.append(np.array(place))
                numbers.append(number)
        if self.loop:
            if np.hypot(*(places[0] - places[-1])) > _LEAST:
                places.append(places[0])
                numbers.append(0)
            if len(places) < 3:
                raise ComponentError(f"pursuit: a loop needs two waypoints that differ, got {self.waypoints}")
        path = np.empty((rows, len(places) + 1, 2))
        path[:, 0] = context.pose[:, :2]
        path[:, 1:] = places
        # A robot that stands on the first waypoint sets out from a little before it.
        steps = path[:, 1:] - path[:, :-1]
        lengths = np.sqrt(steps[:, :, 0] ** 2 + steps[:, :, 1] ** 2)
        there = lengths[:, 0] <= _LEAST
        path[there, 0, 0] -= 2.0 * _LEAST
        lengths[there, 0] = 2.0 * _LEAST
        along = np.zeros((rows, len(places) + 1))
        for i in range(len(places)):
            along[:, i + 1] = along[:, i] + lengths[:, i]
        way, turns_about = self._ways(path, numbers, heading_poses(context.robot, context.pose, at_rest(context.robot)))
        return {
            "path": path,
            "along": along,
            "stops": next_stops(turns_about, self.loop),
            "way": way,
            "progress": np.zeros((rows, 1)),
            **abilities(context.robot),
        }

    def _ways(self, path: Array, numbers: list[int], pose: Array) -> tuple[Array, Bools]:
        """Whether each robot sets out forwards (1) or backwards (-1) `(N, 1)`, and where it changes direction `(N, p)`.

        `numbers` are of the waypoints that the legs lead to.
        """
        rows, points = path.shape[:2]
        turns_about = np.zeros((rows, points), dtype=bool)
        if self.reverse == "never":
            return np.ones((rows, 1)), turns_about
        if isinstance(self.reverse, tuple):
            back = np.isin(numbers, self.reverse)
            turns_about[:, 1:-1] = back[1:] != back[:-1]
            if self.loop:
                turns_about[:, -1] = back[1] != back[-1]
            return np.full((rows, 1), -1.0 if back[0] else 1.0), turns_about
        legs = path[:, 1:] - path[:, :-1]
        turns_about[:, 1:-1] = turn_back(legs[:, 1:], legs[:, :-1])
        if self.loop:
            turns_about[:, -1] = turn_back(legs[:, 1], legs[:, -1])
        ahead = np.stack((np.cos(pose[:, 2]), np.sin(pose[:, 2])), axis=1)
        return np.where(turn_back(legs[:, 0], ahead)[:, None], -1.0, 1.0), turns_about

    def bind(self, at: ControllerBinding) -> Callable[[], None]:
        """Pursue on the engine's own arrays."""
        robot, state, twist = at.robot, at.state, np.empty((at.robot.rows, 3))
        wanted = at.out[:, : len(robot.drive.channels)]
        path = pure_pursuit.Course(state["path"], state["along"], state["stops"], self.loop)
        pace = pure_pursuit.Pace(self.speed, self.turn_rate, state["limits"], state["curvature"])
        lookahead, tolerance = self.lookahead, self.tolerance
        kept = state["progress"], state["way"], state["moving"], twist

        def command() -> None:
            course = Course.of(robot, at.readings, at.estimate)
            pure_pursuit.pursue(course.poses, path, lookahead, tolerance, pace, at.dt, *kept)
            wanted[:] = course.command(twist)

        return command

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step; at the end that of standing still."""
        bind = functools.partial(Pursuit.bind, self)
        return command_bound(bind, robot, readings, estimate, clock, state, draws)


def turn_back(one: Array, other: Array) -> Bools:
    """Whether two directions are more than a right angle apart `(...)`; they are `(..., 2)`."""
    found: Bools = one[..., 0] * other[..., 0] + one[..., 1] * other[..., 1] < 0.0
    return found


def next_stops(turns_about: Bools, loop: bool) -> Ints:
    """The point at which a robot on each leg stops next `(N, p - 1)`, -1 for none."""
    rows, points = turns_about.shape
    last = points - 1
    stops = np.full((rows, last), -1, dtype=np.int64)
    after = np.full(rows, -1 if loop else last, dtype=np.int64)
    for _ in range(2 if loop else 1):  # in a loop the first stop may be in the next round
        for leg in range(last - 1, -1, -1):
            after = np.where(turns_about[:, leg + 1], leg + 1, after)
            stops[:, leg] = after
        after = stops[:, min(1, last - 1)]
    return stops
