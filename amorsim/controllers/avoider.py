"""Avoiders: controllers that lead a robot along a path without touching what its range sensor sees."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.joints import at_rest
from amorsim.controllers.abilities import Course, abilities
from amorsim.controllers.beams import beams_of, range_sensor, turned_beams
from amorsim.core.errors import ComponentError
from amorsim.kernels.avoidance.arcs import Box
from amorsim.kernels.avoidance.guide import Guide
from amorsim.kernels.avoidance.seen_window import Window, guard
from amorsim.kernels.behaviours.free_space import Sight

__all__ = ["Avoider", "SteeringInput", "body_of", "guarded", "sight_of", "start_moving", "start_sight"]


_ARC_SAMPLES = 7  # points that stand for the arc on which a cone's return lies
_PROGRESS = 0.1  # [m] nearer to the goal counts as progress


class SteeringInput(NamedTuple):
    """What an avoider is given in a step."""

    readings: Mapping[str, Measurement]
    course: Course
    guide: Guide  # the paths
    active: Bools  # (N, 1); the other robots stop
    clock: Clock
    state: State
    draws: Draws


@attrs.frozen(kw_only=True)
class Avoider(Controller):
    """The base of controllers that drive to goals, or along a path, past what they sense.

    By itself it drives straight for each of its `goals` in turn. `Navigate` leads it along paths that a planner found.
    """

    blocked_word: ClassVar[str] = "blocked"
    """The event that it reports when it makes no progress."""

    goals: tuple[tuple[float, float], ...] = parameter(
        (), unit="m", frame="world", help="where it drives, one after the other; not needed within 'navigate'"
    )
    loop: bool = parameter(False, static=True, help="whether it goes on from the last goal to the first")
    tolerance: float = parameter(0.1, unit="m", gt=0, help="distance from the goal within which it stops")
    speed: float = parameter(0.5, unit="m/s", gt=0, help="fastest that it drives")
    turn_rate: float = parameter(1.5, unit="rad/s", gt=0, help="fastest that it turns")
    sensor: str = parameter("laser", refers="sensors", help="name of the range sensor that it uses")
    clearance: float = parameter(
        0.05, unit="m", ge=0, help="kept free around the footprint; three times the sensor's noise at least"
    )
    patience: float = parameter(
        10.0,
        unit="s",
        gt=0,
        help="after this time without coming 0.1 m nearer to the goal it reports that it is blocked",
    )

    @abc.abstractmethod
    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active stop."""

    def start_steering(self, context: Context) -> State:
        """The arrays that `steer` keeps in the state."""
        return {**start_sight(context, self.sensor, type(self).__name__.lower()), **start_moving(context)}

    def take_path(self, row: int, pose: Array, axle: Array, state: State) -> None:
        """Take over a new path, in `state`, of a robot that stands at `pose` (3,).

        `axle` (L, 2) [m] is the path of its trailer's axle, without points if the plan is for no trailer.
        """

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals."""
        return [(f"goals.{i}", x, y) for i, (x, y) in enumerate(self.goals)]

    def start(self, context: Context) -> State:
        """State: that of `steer`, and the progress of the drive to the goals.

        Raises
        ------
        ComponentError
            If there is no goal, or the robot has no such sensor.
        """
        if len(self.goals) == 0:
            who, name = context.robot.who(0), type(self).__name__.lower()
            raise ComponentError(f"{name} by itself needs goals, as in goals = [[4.0, 2.0]]; {who} has none")
        rows = context.rows
        return {
            **self.start_steering(context),
            "goal": np.zeros((rows, 1), dtype=np.int64),  # its number; that of all goals once they are reached
            "nearest": np.full((rows, 1), np.inf),  # [m] to the goal, so far
            "since": np.zeros((rows, 1)),  # [s] when that was
            "blocked": np.zeros((rows, 1), dtype=bool),
            "news": np.zeros((rows, 1), dtype=np.int64),
        }

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step; at the last goal that of standing still."""
        course = Course.of(robot, readings, estimate)
        goals = np.asarray(self.goals)
        rows, count = goals.shape[:2]
        number = state["goal"]
        goal = goals[np.arange(rows), np.minimum(number[:, 0], count - 1)]
        off = goal - estimate.pose[:, :2]
        away = np.sqrt(off[:, :1] ** 2 + off[:, 1:] ** 2)
        there = (number < count) & (away <= self.tolerance)
        if there.any():
            state["goal"] = (number + there) % count if self.loop else number + there
            goal = goals[np.arange(rows), np.minimum(state["goal"][:, 0], count - 1)]
        active = state["goal"] < count
        nearer = there | (away < state["nearest"] - _PROGRESS)
        state["nearest"] = np.where(there, np.inf, np.where(nearer, away, state["nearest"]))
        state["since"] = np.where(nearer, clock.time, state["since"])
        blocked = active & (clock.time - state["since"] >= self.patience)
        state["news"] = np.where(there, 1 + number, np.where(blocked & ~state["blocked"], -1, 0))
        state["blocked"] = blocked
        guide = Guide(
            np.ascontiguousarray(goal[:, None, :]),
            np.zeros((rows, 1)),
            np.ones(rows, dtype=np.int64),
            np.zeros(rows, dtype=np.int64),
        )
        return course.command(self.steer(SteeringInput(readings, course, guide, active, clock, state, draws)))

    def reports(self, state: State) -> Sequence[tuple[int, str, object]]:
        """Goals that were reached, and robots that make no progress."""
        news = state["news"][:, 0]
        if not news.any():
            return ()
        count = np.asarray(self.goals).shape[1]
        return [
            (row, "goal_reached", f"{news[row]} of {count}")
            if news[row] > 0
            else (row, self.blocked_word, "no progress")
            for row in np.flatnonzero(news).tolist()
        ]


def start_sight(context: Context, sensor: str, who: str, prefix: str = "") -> State:
    """State of a controller that uses a range sensor: origin and direction of its values; keys begin with `prefix`.

    Raises
    ------
    ComponentError
        If the robot has no such sensor, or the sensor does not give the directions of its values.
    """
    model = range_sensor(context.robot, sensor, who)
    half_angle: Any = getattr(model.sensor, "half_angle", 0.0)
    return {
        f"{prefix}beams": beams_of(model, context.rows),
        f"{prefix}half_angle": np.array(np.broadcast_to(half_angle, (context.rows, 1)), dtype=np.float64),
    }


def start_moving(context: Context) -> State:
    """State of a controller that knows the limits of its drive and keeps track of its twist, ``"moving"``."""
    return {**abilities(context.robot), "moving": np.zeros((context.rows, 2))}


def sight_of(
    robot: RobotModel, reading: Measurement, sensor: str, joints: Array, state: State, prefix: str = ""
) -> Sight:
    """The range sensor's reading, in the frame in which the drive goes ahead."""
    is_cone = hasattr(robot.sensors[sensor].sensor, "half_angle")
    return Sight(
        np.ascontiguousarray(reading.measured),
        turned_beams(robot, state[f"{prefix}beams"], joints),
        state[f"{prefix}half_angle"],
        _ARC_SAMPLES if is_cone else 1,
    )


def body_of(robot: RobotModel, clearance: Any) -> tuple[Box, Array]:
    """A rectangle in the frame of the drive's course, and the distance [m] kept around it `(N, 1)`.

    For a disc the rectangle is a point, for other footprints the smallest that holds it, without what is beyond the
    footprint's reach. A body that does not turn with its wheels is taken as the disc that it sweeps.
    """
    shape = robot.shape
    margin = np.zeros((robot.rows, 1)) + clearance
    if robot.drive.heading_offset(at_rest(robot)) is not None:
        return Box(0.0, 0.0, 0.0, 0.0, np.inf), margin + shape.reach
    if len(shape.vertices) == 1 and len(shape.vertices[0]) == 1:
        x, y = shape.vertices[0][0]
        return Box(x, x, y, y, np.inf), margin + shape.radius
    low, high = shape.outline.min(axis=0).tolist(), shape.outline.max(axis=0).tolist()
    return Box(low[0], high[0], low[1], high[1], float(shape.reach)), margin


def guarded(
    wanted: Array, sight: Sight, age: Array, course: Course, body: tuple[Box, Array], state: State, dt: float
) -> Array:
    """The twists `(N, 3)`: `wanted` `(N, 2)` if robots can brake from it before what they see, else braking.

    `body` is what `body_of` gives; ``state["limits"]`` and ``state["moving"]`` are those of `start_moving`, and
    ``state["moving"]`` is brought up to the twist.
    """
    rows = len(wanted)
    never, corner = np.full((rows, 1, 1), -1e30, dtype=np.float32), np.zeros((rows, 2), dtype=np.int64)
    no_memory = Window(never, corner, 1.0, np.zeros((rows, 1, 1, 2), dtype=np.int8))
    twist = np.empty((rows, 3))
    guard(
        sight,
        age,
        course.poses,
        *body,
        state["limits"],
        no_memory,
        np.zeros((rows, 1)),
        wanted,
        np.ones((rows, 1), dtype=bool),
        dt,
        state["moving"],
        twist,
    )
    return twist
