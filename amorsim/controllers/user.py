"""A user's own controller: a plain function of one robot, or a class with such a method."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable, Mapping, Sequence
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array
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
)
from amorsim.contracts.joints import joints_of
from amorsim.controllers.abilities import command_along
from amorsim.core.error_text import RAISED, in_words
from amorsim.core.errors import ControllerError
from amorsim.core.one_robot import PoseVector, RobotReading, RobotReadings
from amorsim.core.user_code import UserCode

__all__ = [
    "PoseVector",
    "RobotClock",
    "RobotEstimate",
    "RobotReading",
    "Twist",
    "UserController",
    "WheelSpeeds",
]


@attrs.frozen
class Twist:
    """A velocity: forward [m/s], turning anticlockwise [rad/s], and to the left [m/s] for a drive that can.

    Forward is the direction in which the drive goes ahead: for a synchro drive, where its wheels point.
    """

    forward: float = 0.0
    turn: float = 0.0
    left: float = 0.0


@attrs.frozen
class WheelSpeeds:
    """Speeds of the left and the right wheel's rim [m/s]; the robot converts them with its nominal radii."""

    left: float = 0.0
    right: float = 0.0


class RobotEstimate(NamedTuple):
    """The estimated pose of one robot."""

    pose: PoseVector  # (3,) x [m], y [m], heading [rad]
    covariance: Array  # (3, 3)

    @property
    def x(self) -> float:
        """To the right in the world [m]."""
        return self.pose.x

    @property
    def y(self) -> float:
        """Up in the world [m]."""
        return self.pose.y

    @property
    def heading(self) -> float:
        """Anticlockwise from the world's x axis [rad]."""
        return self.pose.heading


class RobotClock(NamedTuple):
    """The time of one robot: ticks and seconds since the episode began, and the length of a step [s]."""

    tick: int
    time: float
    dt: float


@attrs.frozen(kw_only=True)
class UserController(UserCode, Controller):
    """Runs a user's function of one robot, or objects of a user's class, one for each robot.

    A function is called as ``function(readings, estimate, clock, **options)``. From a class an object is made with
    the options as keyword arguments, and its method is called as ``command(readings, estimate, clock)``. They get

    - ``readings[name]``: a `RobotReading` with `measured` `(k,)`, `stamp`, `age` [s], `fresh`;
    - ``estimate``: a `RobotEstimate` with `pose` `(3,)`, `covariance` `(3, 3)`, and `x`, `y`, `heading`;
    - ``clock``: a `RobotClock` with `tick`, `time` [s], `dt` [s];

    These are copies and may be kept. The return value is a `Twist`; `WheelSpeeds`; a number in rad/s for each channel
    of the drive in order (then of devices that take commands, or these stay at 0); a mapping from some channels'
    names to numbers (0 for the others); or None to stop.
    """

    kind: ClassVar[str] = "controller"
    signature: ClassVar[str] = "command(self, readings, estimate, clock)"

    def failure(self, message: str, name: str) -> ControllerError:
        """A `ControllerError` of the robot `name`."""
        return ControllerError(message, robot=name)

    def start(self, context: Context) -> State:
        """An object of the class for each row, ``state["objects"]`` `(N,)`; nothing for a function.

        Raises
        ------
        ControllerError
            If it cannot be called, an object cannot be made, or has no method `command`.
        """
        return dict(self.make_objects(context.rows, context.robot.who))

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step.

        Raises
        ------
        ControllerError
            If the user's code raises, or does not return a command.
        """
        return self.ask_robots(robot, dict(readings), estimate, clock, state).command()

    def bind(self, at: ControllerBinding) -> Callable[[], None]:
        """Call the user's code with copies of those arrays of the engine that it looks at."""
        clock = Clock(tick=at.tick, time=at.time, dt=at.dt)

        def command() -> None:
            answers = self.ask_robots(at.robot, at.readings, at.estimate, clock, at.state)
            np.copyto(at.out, answers.command())

        return command

    def ask_robots(
        self, robot: RobotModel, readings: Mapping[str, Measurement], estimate: Estimate, clock: Clock, state: State
    ) -> _Answers:
        """The answers of the users' code for all rows; it is given copies, which it may keep and change."""
        caller = self.asker(state)
        answers = _Answers(robot, self.title, readings)
        poses, covariances = estimate.pose.copy().view(PoseVector), estimate.covariance.copy()
        times, dt = zip(clock.tick[:, 0].tolist(), clock.time[:, 0].tolist(), strict=True), float(clock.dt)
        for row, (pose, covariance, (tick, time)) in enumerate(zip(poses, covariances, times, strict=True)):
            given = RobotReadings(readings, row)
            try:
                answer = caller(row)(given, RobotEstimate(pose, covariance), RobotClock(tick, time, dt))
            except RAISED as error:
                name = robot.names[row] if robot.names else ""
                raise self.raised(error, robot.who(row), time, name) from error
            answers.take(row, answer)
            kept = weakref.ref(given)
            del given
            if (readings_kept := kept()) is not None:
                readings_kept.keep()
        return answers


class _Answers:
    """Collects the returned values of all rows into one command."""

    def __init__(self, robot: RobotModel, title: str, readings: Mapping[str, Measurement]) -> None:
        self._robot = robot
        self._readings = readings
        self._title = title
        self._rates = np.zeros((robot.rows, len(robot.channels)))
        self._twists: dict[int, list[float]] = {}
        self._speeds: dict[int, list[float]] = {}

    def take(self, row: int, answer: Any) -> None:
        """Keep the answer of a row, or raise `ControllerError`."""
        channels = self._robot.channels
        if answer is None:
            return
        if isinstance(answer, Twist):
            self._twists[row] = self._numbers(row, answer, (answer.forward, answer.left, answer.turn))
        elif isinstance(answer, WheelSpeeds):
            if not hasattr(self._robot.drive, "speeds_to_rates"):
                raise self._wrong(row, answer, f"a {type(self._robot.drive).__name__} takes no wheel speeds")
            self._speeds[row] = self._numbers(row, answer, (answer.left, answer.right))
        # Most answers are tuples; whether something is a Sequence takes longer to find out.
        elif isinstance(answer, (tuple, list, np.ndarray, Sequence)) and not isinstance(answer, (str, bytes)):
            is_flat = not isinstance(answer, np.ndarray) or answer.ndim == 1
            if not is_flat or len(answer) not in (len(channels), len(self._robot.drive.channels)):
                raise self._wrong(row, answer, f"there are {len(channels)} channels")
            self._rates[row, : len(answer)] = self._numbers(row, answer, answer)
        elif isinstance(answer, Mapping):
            unknown = [name for name in answer if name not in channels]
            if unknown:
                raise self._wrong(row, answer, f"there is no channel {in_words(unknown[0])}")
            self._rates[row] = self._numbers(row, answer, [answer.get(name, 0.0) for name in channels])
        else:
            raise self._wrong(row, answer, f"a {type(answer).__name__} is not a command")

    def command(self) -> Array:
        """The command `(N, c)` of all rows."""
        drive: Any = self._robot.drive
        of_drive = self._rates[:, : len(drive.channels)]
        if self._twists:
            rows, twists = self._of_rows(self._twists, 3)
            joints = joints_of(self._robot, self._readings)
            of_drive[rows] = command_along(self._robot, twists, joints)[rows]
        if self._speeds:
            rows, speeds = self._of_rows(self._speeds, 2)
            of_drive[rows] = drive.speeds_to_rates(speeds)[rows]
        return self._rates

    def _of_rows(self, answers: Mapping[int, list[float]], width: int) -> tuple[list[int], Array]:
        """The rows with such answers, and the answers in an array of all rows, 0 for the others."""
        rows, whole = list(answers), np.zeros((self._robot.rows, width))
        whole[rows] = list(answers.values())
        return rows, whole

    def _numbers(self, row: int, answer: Any, values: Any) -> list[float]:
        found = []
        for value in values:
            if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, float, np.integer, np.floating)):
                raise self._wrong(row, answer, f"{in_words(value)} is not a number")
            try:
                number = float(value)
            except OverflowError:  # an integer with hundreds of digits
                raise self._wrong(row, answer, f"{in_words(value)} is too large") from None
            if not math.isfinite(number):
                raise self._wrong(row, answer, f"{in_words(value)} is not finite")
            found.append(number)
        return found

    def _wrong(self, row: int, answer: Any, problem: str) -> ControllerError:
        channels = ", ".join(self._robot.channels)
        return ControllerError(
            f"{self._title} of {self._robot.who(row)} returned {in_words(answer)}: {problem}. Expected "
            f"am.Twist(forward, turn), am.WheelSpeeds(left, right) in m/s, rad/s for each of ({channels}) in "
            "order or by name, or None to stop",
            robot=self._robot.names[row] if self._robot.names else "",
        )
