"""Following a planned path as it is, forwards and backwards."""

from __future__ import annotations

from typing import Any, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Context, RobotModel, State, parameter
from amorsim.controllers.abilities import Course
from amorsim.controllers.avoider import Avoider, SteeringInput, body_of, guarded, sight_of
from amorsim.controllers.planning import PLACES
from amorsim.controllers.pursuit import next_stops, turn_back
from amorsim.controllers.trailer import Trailer
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.behaviours import pure_pursuit

__all__ = ["PathPursuit"]


_LEAST = 1e-6  # [m] to a goal
_CREEP = 0.02  # [m/s] while the wheels steer


class _Line(NamedTuple):
    """The path that a robot follows, or that the axle of its trailer follows where it is pushed."""

    path: Array
    """(1, p, 2) [m]"""
    along: Array
    """(1, p) [m] of its points."""
    stops: Ints
    """(1, p - 1) the point at which it stops next on each leg."""
    progress: Array
    """(1, 1) [m] how far it has come; changed."""

    @classmethod
    def laid(cls, points: Array, progress: Array) -> _Line:
        """The line of these points (p, 2), two at least."""
        legs = np.diff(points, axis=0)[None]
        turns_about = np.zeros((1, len(points)), dtype=bool)
        turns_about[:, 1:-1] = turn_back(legs[:, 1:], legs[:, :-1])
        along = np.concatenate(([0.0], np.cumsum(np.hypot(legs[0, :, 0], legs[0, :, 1]))))
        return cls(points[None], along[None], next_stops(turns_about, loop=False), progress)

    @property
    def ends(self) -> Array:
        """Where its parts end [m]: those that are driven forwards, those that are driven backwards."""
        return np.asarray(self.along[0, np.unique(self.stops)])

    def come_along(self, other: _Line) -> None:
        """Advance as far as the other line has: in the same part, by the same share of it."""
        mine, theirs = self.ends, other.ends
        s = float(other.progress[0, 0])
        number = min(int(np.searchsorted(theirs, s, side="right")), len(theirs) - 1)
        low, high = (float(np.concatenate(([0.0], theirs))[number + k]) for k in (0, 1))
        start, end = (float(np.concatenate(([0.0], mine))[number + k]) for k in (0, 1))
        self.progress[0, 0] = start + (end - start) * min(max((s - low) / (high - low), 0.0), 1.0)


@attrs.frozen(kw_only=True)
class PathPursuit(Avoider):
    """Drives along a planned path as it is, forwards and backwards, by pure pursuit, and brakes before what it sees.

    It is the avoider for paths of a car, such as those of ``hybrid_a_star``: it does not leave its path, because a car
    cannot leave it and come back as it likes. Where the path turns back by more than a right angle, it stops, changes
    direction and goes on. It drives only as far as it can brake before its footprint and `clearance` meet something
    that it sees; `Navigate` then plans again. It does not look behind itself if its sensor does not, and does not guard
    a trailer. There the planner's clearance must do.

    A trailer it pushes where its path leads backwards: the trailer's axle follows its own path, and the hitch angle, as
    the robot's sensor reads it, steers it. So its drive needs a joint ``hitch`` that an encoder counts, as `Tractor`
    has, and its planner a trailer, as `HybridAStar` may have.

    By itself it drives straight for its goals.

    Parameters
    ----------
    goals, loop, tolerance
        Where it drives [m], whether it goes round for ever, and how near to a goal it must come [m].
    speed, turn_rate
        Fastest that it drives and turns; slower if the drive is slower.
    lookahead
        Distance along the path to the point that it steers to [m].
    stop_distance
        Distance along the path [m] from its end, or from where it changes direction, at which it stops.
    pause
        Time [s] for which it hardly moves at the start of a path, and where it changes direction, while its wheels
        steer.
    sensor
        Name of the range sensor that it uses.
    clearance
        What it keeps free around its footprint [m].
    patience
        Time without progress after which it reports that it is blocked [s].
    """

    lookahead: float = parameter(0.5, unit="m", gt=0, help="how far ahead on the path it looks")
    stop_distance: float = parameter(
        0.02, unit="m", gt=0, help="how near to the end, or where it turns about, it stops"
    )
    pause: float = parameter(
        0.0, unit="s", ge=0, help="time for which it hardly moves where it changes direction, while its wheels steer"
    )

    def start_steering(self, context: Context) -> State:
        """The sensor's beams, the drive's limits, and where it is on its path."""
        rows = context.rows
        return {
            **super().start_steering(context),
            "progress": np.zeros((rows, 1)),
            "way": np.ones((rows, 1)),
            "stops": np.full((rows, PLACES - 1), -1, dtype=np.int64),
            "pace": np.zeros((rows, 2)),
            "paused": np.zeros((rows, 1)),  # [s] so far
            **(_no_axle(rows) if Trailer.column(context.robot) is not None else {}),
        }

    def take_path(self, row: int, pose: Array, axle: Array, state: State) -> None:
        """Begin at the start of the new path of a robot, forwards or backwards as it leads."""
        count = int(state["count"][row])
        state["progress"][row] = 0.0
        state["pace"][row] = state["paused"][row] = 0.0
        if count < 2:
            return
        line = _Line.laid(state["path"][row, :count], state["progress"][row : row + 1])
        state["stops"][row, : count - 1] = line.stops[0]
        ahead = np.array([[np.cos(pose[2]), np.sin(pose[2])]])
        state["way"][row] = -1.0 if turn_back((line.path[0, 1] - line.path[0, 0])[None], ahead)[0] else 1.0
        if "axle_path" in state:
            _lay_axle(axle, len(line.ends), row, state)

    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active brake."""
        robot, course, state = given.course.robot, given.course, given.state
        reading = given.readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state)
        # It brakes with half of what its drive can, which leaves the other half for steering.
        limits = state["limits"] * (1.0, 1.0, 0.5, 1.0)
        wanted = np.zeros((robot.rows, 2))
        for row in np.flatnonzero(given.active).tolist():
            trailer = self._pushed(robot, course, row, state)
            wanted[row] = self._along(row, trailer, course, given.guide, limits, given.clock.dt, state)
        twist = guarded(wanted, sight, reading.age, course, body_of(robot, self.clearance), state, given.clock.dt)
        state["pace"][:, 0] = np.abs(twist[:, 0])
        return twist

    def _pushed(self, robot: RobotModel, course: Course, row: int, state: State) -> Trailer | None:
        """The trailer of a robot that is to push it along a path; else None."""
        column = Trailer.column(robot) if state["way"][row, 0] < 0.0 else None
        if column is None or state["axle_count"][row] < 2:
            return None
        return Trailer.of(robot, course.joints, row, column)

    def _along(
        self,
        row: int,
        trailer: Trailer | None,
        course: Course,
        guide: Guide,
        limits: Array,
        dt: float,
        state: State,
    ) -> Array:
        """The twist (2,), v and w, of a robot along its path; straight to the goal, where that is all of its path.

        That which follows the path is the axle of the `trailer` where there is one.
        """
        this = slice(row, row + 1)
        pose = course.poses[this]
        count = int(guide.size[row])
        own: Any = self
        speed, look, bend = own.speed[this], own.lookahead[this], state["curvature"][this]
        way = state["way"][this]
        own_line: _Line | None = None
        if count == 1:
            away = float(np.hypot(*(guide.path[row, 0] - pose[0, :2])))
            if away < _LEAST:
                return np.zeros(2)
            line = _Line.laid(np.stack((pose[0, :2], guide.path[row, 0])), np.zeros((1, 1)))
            way = np.ones((1, 1))
        else:
            line = own_line = _Line(
                guide.path[this, :count],
                guide.along[this, :count],
                state["stops"][this, : count - 1],
                state["progress"][this],
            )
        if trailer is not None:
            line, pose, bend = _axle_line(row, state), trailer.axle(pose), np.array([[trailer.curvature_max]])
            speed = np.minimum(speed, trailer.speed_max(float(state["lag"][row, 0]) + dt))
            look = np.maximum(look, trailer.looks)
        paused = state["paused"][this]
        if paused[0, 0] < own.pause[row, 0]:
            paused += dt
            speed = np.minimum(speed, _CREEP)
        for number in (speed, look):
            number.flags.writeable = False  # as those of a component: kernels are compiled for each kind
        before = float(way[0, 0])
        out = np.empty((1, 3))
        pure_pursuit.pursue(
            pose,
            pure_pursuit.Course(
                np.ascontiguousarray(line.path),
                np.ascontiguousarray(line.along),
                np.ascontiguousarray(line.stops),
                loops=False,
            ),
            look,
            own.stop_distance[this],
            pure_pursuit.Pace(speed, own.turn_rate[this], limits[this], bend),
            dt,
            line.progress,
            way,
            state["pace"][this],
            out,
        )
        if way[0, 0] != before:
            paused[:] = 0.0
        guide.leg[row] = 0
        if own_line is not None:
            self._keep_pace(own_line, trailer, row, state)
            guide.leg[row] = max(int(np.searchsorted(own_line.along[0], own_line.progress[0, 0], side="right")) - 1, 0)
        v, w = out[0, ::2].tolist()
        if trailer is None or v == 0.0:
            return np.array([v, w])
        return np.array(trailer.twist(v, w / v, min(float(own.turn_rate[row, 0]), float(limits[row, 1]))))

    def _keep_pace(self, own_line: _Line, trailer: Trailer | None, row: int, state: State) -> None:
        """Of the paths of the robot and of its trailer's axle, advance the one that does not lead."""
        if "axle_path" not in state or state["axle_count"][row] < 2:
            return
        axle = _axle_line(row, state)
        if trailer is None:
            axle.come_along(own_line)
        else:
            own_line.come_along(axle)


def _no_axle(rows: int) -> State:
    """State for the path of each trailer's axle, empty at first."""
    return {
        "axle_path": np.zeros((rows, PLACES, 2)),
        "axle_along": np.zeros((rows, PLACES)),
        "axle_stops": np.full((rows, PLACES - 1), -1, dtype=np.int64),
        "axle_progress": np.zeros((rows, 1)),
        "axle_count": np.zeros(rows, dtype=np.int64),
    }


def _lay_axle(points: Array, parts: int, row: int, state: State) -> None:
    """Put the path (L, 2) of an axle into the state, if it has as many parts, forwards or backwards, as the robot's."""
    state["axle_progress"][row] = 0.0
    state["axle_count"][row] = 0
    count = len(points)
    if not 2 <= count <= PLACES:
        return
    line = _Line.laid(points, state["axle_progress"][row : row + 1])
    if len(line.ends) != parts:  # the hitch is so far off the axles that one goes on where the other turns about
        return
    state["axle_path"][row, :count], state["axle_along"][row, :count] = line.path[0], line.along[0]
    state["axle_stops"][row, : count - 1] = line.stops[0]
    state["axle_count"][row] = count


def _axle_line(row: int, state: State) -> _Line:
    this, count = slice(row, row + 1), int(state["axle_count"][row])
    return _Line(
        state["axle_path"][this, :count],
        state["axle_along"][this, :count],
        state["axle_stops"][this, : count - 1],
        state["axle_progress"][this],
    )
