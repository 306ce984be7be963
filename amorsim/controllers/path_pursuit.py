"""Following a planned path as it is, forwards and backwards."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Clock, Context, Draws, Measurement, RobotModel, State, parameter
from amorsim.controllers.avoider import Avoider, body_of, guarded, sight_of
from amorsim.controllers.driving import Course
from amorsim.controllers.planning import PLACES
from amorsim.controllers.pursuit import next_stops, turn_back
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.behaviours import pure_pursuit

__all__ = ["PathPursuit"]

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_LEAST = 1e-6  # [m] to a goal
_CREEP = 0.02  # [m/s] while the wheels steer


@attrs.frozen(kw_only=True)
class PathPursuit(Avoider):
    """Drives along a planned path as it is, forwards and backwards, by pure pursuit, and brakes before what it sees.

    It is the avoider for paths of a car, such as those of ``hybrid_a_star``: it does not leave its path, because a car
    cannot leave it and come back as it likes. Where the path turns back by more than a right angle, it stops, changes
    direction and goes on. It drives only as far as it can brake before its footprint and `clearance` meet something
    that it sees; `Navigate` then plans again. It does not look behind itself if its sensor does not, and does not guard
    a trailer. There the planner's clearance must do.

    By itself it drives straight for its goals.

    Parameters
    ----------
    goals, loop, tolerance
        Where it drives [m], whether it goes round for ever, and how near to a goal it must come [m].
    speed, turn_rate
        Fastest that it drives and turns; slower if the drive is slower.
    lookahead
        Distance along the path to the point that it steers to [m].
    stop
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
    stop: float = parameter(0.02, unit="m", gt=0, help="how near to the end, or where it turns about, it stops")
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
        }

    def take_path(self, row: int, pose: Array, state: State) -> None:
        """Begin at the start of the new path of a robot, forwards or backwards as it leads."""
        count = int(state["count"][row])
        state["progress"][row] = 0.0
        state["pace"][row] = state["paused"][row] = 0.0
        if count < 2:
            return
        legs = np.diff(state["path"][row : row + 1, :count], axis=1)
        turns_about = np.zeros((1, count), dtype=bool)
        turns_about[:, 1:-1] = turn_back(legs[:, 1:], legs[:, :-1])
        state["stops"][row, : count - 1] = next_stops(turns_about, loop=False)[0]
        ahead = np.array([[np.cos(pose[2]), np.sin(pose[2])]])
        state["way"][row] = -1.0 if turn_back(legs[:, 0], ahead)[0] else 1.0

    def steer(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        course: Course,
        guide: Guide,
        active: Bools,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The twists `(N, 3)` along the paths of `guide`; robots that are not `active` brake."""
        reading = readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state)
        # It brakes with half of what its drive can, which leaves the other half for steering.
        limits = state["limits"] * (1.0, 1.0, 0.5, 1.0)
        wanted = np.zeros((robot.rows, 2))
        for row in np.flatnonzero(active).tolist():
            wanted[row] = self._along(row, course, guide, limits, clock.dt, state)
        twist = guarded(wanted, sight, reading.age, course, body_of(robot, self.clearance), state, clock.dt)
        state["pace"][:, 0] = np.abs(twist[:, 0])
        return twist

    def _along(self, row: int, course: Course, guide: Guide, limits: Array, dt: float, state: State) -> Array:
        """The twist (2,), v and w, of a robot along its path; straight to the goal, where that is all of its path."""
        this = slice(row, row + 1)
        pose = course.poses[this]
        count = int(guide.size[row])
        path, along = guide.path[this, :count], guide.along[this, :count]
        progress, way, stops = state["progress"][this], state["way"][this], state["stops"][this, : count - 1]
        if count == 1:
            away = float(np.hypot(*(path[0, 0] - pose[0, :2])))
            if away < _LEAST:
                return np.zeros(2)
            path, along = np.stack((pose[:, :2], path[:, 0]), axis=1), np.array([[0.0, away]])
            progress, way, stops = np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1), dtype=np.int64)
        own: Any = self
        paused = state["paused"][this]
        speed = own.speed[this]
        if paused[0, 0] < own.pause[row, 0]:
            paused += dt
            speed = np.minimum(speed, _CREEP)
            speed.flags.writeable = False  # as that of a component: kernels are compiled for each kind
        before = float(way[0, 0])
        out = np.empty((1, 3))
        pure_pursuit.pursue(
            pose,
            pure_pursuit.Course(
                np.ascontiguousarray(path), np.ascontiguousarray(along), np.ascontiguousarray(stops), loops=False
            ),
            own.lookahead[this],
            own.stop[this],
            pure_pursuit.Pace(speed, own.turn_rate[this], limits[this], state["curvature"][this]),
            dt,
            progress,
            way,
            state["pace"][this],
            out,
        )
        if way[0, 0] != before:
            paused[:] = 0.0
        guide.leg[row] = max(int(np.searchsorted(along[0], progress[0, 0], side="right")) - 1, 0)
        return out[0, ::2]
