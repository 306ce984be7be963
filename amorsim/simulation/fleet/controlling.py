"""The source of commands, row by row: the robot's own controller, or a caller that drives it by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NoReturn

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import AnyArray, Array
from amorsim.contracts import (
    Beliefs,
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
from amorsim.core.error_text import RAISED
from amorsim.core.rows import stack, take
from amorsim.kernels.number_checks import all_finite
from amorsim.scenario.spec import Robot
from amorsim.simulation.error_context import ErrorContext, is_finite
from amorsim.simulation.estimation.beliefs import BeliefsNow, beliefs_problem, chosen
from amorsim.simulation.row_clock import RowClock

__all__ = ["Driver", "report_problem"]

Rows = npt.NDArray[np.intp]


class Driver:
    """The source of each row's command in a group of robots.

    Attributes
    ----------
    controller
        The robots' controller, or None.
    state
        The controller's state.
    active
        `(N, 1)` true until the row's controller ends; the robot stands still afterwards.
    by_hand
        `(N, 1)` whether the row is driven from outside, by the command `hand` `(N, c)`.
    """

    def __init__(self, rows: int, channels: Sequence[str], of_drive: int, draws: Draws, whose: ErrorContext) -> None:
        self._channels = channels
        self._of_drive = of_drive  # number of channels of the drive
        self._draws = draws
        self._whose = whose
        self.controller: Controller | None = None
        self.state: State = {}
        self.hand = np.zeros((rows, len(channels)))
        self.active, self.by_hand = np.ones((rows, 1), dtype=bool), np.zeros((rows, 1), dtype=bool)

    def set_parameters(self, nominal: Sequence[Robot]) -> None:
        """Take the parameters of every row."""
        if nominal[0].controller is not None:
            self.controller = stack([robot.controller for robot in nominal])

    def start(self, context: Context) -> None:
        """Start an episode in every row, driven by its controller."""
        self.active[:], self.by_hand[:], self.hand[:] = True, False, 0.0
        self.state = {}
        if self.controller is not None:
            try:
                self.state = dict(self.controller.start(context))
            except RAISED as error:
                self._whose.blame_start("controller", self.controller, error)

    def hand_over(self, row: int, to_hand: bool) -> None:
        """From now on drive a row from outside, at rest at first, or by its controller again, which may have ended."""
        self.by_hand[row], self.hand[row] = to_hand, 0.0
        if not to_hand:
            self.active[row] = True

    def is_driving(self, row: int) -> bool:
        """Whether a row's controller has not ended, and nobody drives the row from outside."""
        return bool(self.active[row, 0] and not self.by_hand[row, 0])

    def end(self, row: int) -> None:
        """Stop a row from now on."""
        self.active[row] = False

    def bind(
        self,
        robot: RobotModel,
        live: Mapping[str, Measurement],
        copies: Mapping[str, Measurement],
        estimate: Estimate,
        row_clock: RowClock,
        out: Array,
    ) -> Callable[[], None]:
        """The function that writes the command of each step into `out` `(N, c)`.

        Without a controller and without a hand, the command stays as it is. Robots whose controller has ended stand
        still. `live` are the arrays of the current readings, `copies` the same in copies.

        Raises
        ------
        ComponentError
            From the function, if the controller's command has another shape or is not finite; the message names
            controller and robot.
        """
        if self.controller is None:

            def by_hand() -> None:
                self._drive_by_hand(None, out)

            return by_hand
        wanted = np.zeros(out.shape)
        at = ControllerBinding(
            robot=robot,
            readings=live,
            copied_readings=copies,
            estimate=estimate,
            tick=row_clock.tick,
            time=row_clock.time,
            dt=row_clock.dt,
            state=self.state,
            draws=self._draws,
            out=wanted,
            answer=lambda command: np.copyto(wanted, self._checked(command, len(wanted))),
        )
        ask, controller, numbers = self.controller.bind(at), self.controller, wanted.ravel()

        def command() -> None:
            if self._drive_by_hand(at, out):
                return
            ask()
            if not all_finite(numbers):
                raise self._whose.not_finite("controller", controller, ", ".join(self._channels), wanted)
            out[:] = 0.0
            np.copyto(out, wanted, where=self.active)

        return command

    def _drive_by_hand(self, at: ControllerBinding | None, out: Array) -> bool:
        """If some rows are driven from outside, write the command of all rows; returns whether there are any."""
        if not np.count_nonzero(self.by_hand):
            return False
        out[:] = self.hand
        rows = np.flatnonzero(~self.by_hand[:, 0])
        if len(rows):
            answer = 0.0 if at is None else self._ask(at, rows)
            out[rows] = np.where(self.active[rows], answer, 0.0)
        return True

    def _ask(self, at: ControllerBinding, which: Rows) -> Array:
        """The controller's command for the rows in `which`, by its simple form."""
        estimate = Estimate(at.estimate.pose, at.estimate.covariance)
        clock = Clock(at.tick, at.time, at.dt)
        given = at.robot, at.copied_readings, estimate, clock, at.state, at.draws
        assert self.controller is not None
        command = self._checked(_ask_some(self.controller, *given, which), len(which))
        if not is_finite(command):
            whole = np.zeros(self.hand.shape)
            whole[which] = command
            raise self._whose.not_finite("controller", self.controller, ", ".join(self._channels), whole)
        return command

    def _checked(self, answer: Any, rows: int) -> Array:
        """The answer of the controller's `command` for a number of rows, as a command `(N, c)`."""
        expected = rows, len(self._channels)
        if not isinstance(answer, np.ndarray) or answer.dtype.kind not in "biuf":
            found = f"{answer.dtype} array" if isinstance(answer, np.ndarray) else type(answer).__name__
            problem = f"expected a command of the shape {expected}, got a {found}"
            raise self._whose.wrong("controller", self.controller, problem)
        if answer.shape == (rows, self._of_drive) != expected:
            answer = np.concatenate((answer, np.zeros((rows, expected[1] - self._of_drive))), axis=1)
        if answer.shape != expected:
            channels = ", ".join(self._channels)
            problem = f"expected a command of the shape {expected} ({channels}), got {answer.shape}"
            raise self._whose.wrong("controller", self.controller, problem)
        command: Array = answer
        return command

    def blame(self, error: BaseException) -> NoReturn:
        """Raise the controller's exception as `ErrorContext.blame` does."""
        self._whose.blame("controller", self.controller, error)

    def reports(self) -> list[tuple[int, str, Any]]:
        """The controller's reports of the last command: row, word and value, of the rows that it drives.

        Raises
        ------
        ComponentError
            If the controller raises, or returns no reports.
        """
        controller = self.controller
        assert controller is not None
        try:
            found = list(controller.reports(self.state))
        except RAISED as error:
            self._whose.blame("controller", controller, error)
        for report in found:
            if problem := report_problem(report, len(self.active)):
                raise self._whose.wrong("controller", controller, problem)
        return [report for report in found if self.is_driving(report[0])]

    @property
    def can_report(self) -> bool:
        """Whether the controller may have something to report."""
        return self.controller is not None and type(self.controller).reports is not Controller.reports

    @property
    def believes(self) -> bool:
        """Whether the controller has beliefs."""
        return self.controller is not None and type(self.controller).beliefs is not Controller.beliefs

    def beliefs(self, wanted: Iterable[str] | None = None) -> Beliefs:
        """The beliefs of the controller, as its state is now: those that are wanted, or all.

        Raises
        ------
        ComponentError
            If it raises, or returns something else than beliefs.
        """
        controller = self.controller
        assert controller is not None
        try:
            found: Beliefs = chosen(controller.beliefs(self.state), wanted)
        except RAISED as error:
            self._whose.blame("controller", controller, error)
        if problem := beliefs_problem(found, len(self.active)):
            raise self._whose.wrong("controller", controller, problem)
        return found

    def arrays(self) -> dict[str, AnyArray]:
        """The engine's own arrays that change."""
        return {"active": self.active, "by_hand": self.by_hand, "hand": self.hand}


def report_problem(report: Any, rows: int) -> str:
    """The fault of one of the things that `Controller.reports` returned; empty if there is none."""
    if not isinstance(report, tuple) or len(report) != 3:
        return f"expected reports() to return triples (row, word, value), got {report!r}"
    row, word, value = report
    if not isinstance(row, int) or not 0 <= row < rows:
        return f"expected a report of a row from 0 to {rows - 1}, got {row!r}"
    if not isinstance(word, str) or not word.isidentifier():
        return f"expected a report to be a word such as 'goal_reached', got {word!r}"
    if not isinstance(value, (str, int, float)):
        return f"expected a number or a text as the value of a report, got {value!r}"
    return ""


def _ask_some(
    controller: Controller,
    robot: RobotModel,
    readings: Mapping[str, Measurement],
    estimate: Estimate,
    clock: Clock,
    state: State,
    draws: Draws,
    rows: Rows,
) -> Array:
    """A controller's command `(n, c)` for some of its rows; it is not called for the others, which keep their state.

    So a robot's behaviour never depends on whether others of its group are driven by hand, and a user's controller
    that raises or hangs is not called for a robot that is driven by hand.
    """
    part: dict[str, AnyArray] = {name: array[rows] for name, array in state.items()}
    command = take(controller, rows).command(
        _model(robot, rows),
        {name: _some(reading, rows) for name, reading in readings.items()},
        Estimate(estimate.pose[rows], estimate.covariance[rows]),
        Clock(clock.tick[rows], clock.time[rows], clock.dt),
        part,
        draws.take(rows),
    )
    for name, array in part.items():
        state[name][rows] = array
    return command


def _some(reading: Measurement, rows: Rows) -> Measurement:
    return Measurement(reading.measured[rows], reading.stamp[rows], reading.age[rows], reading.fresh[rows])


def _model(robot: RobotModel, rows: Rows) -> RobotModel:
    sensors = {
        name: attrs.evolve(model, sensor=take(model.sensor, rows), mount=take(model.mount, rows))
        for name, model in robot.sensors.items()
    }
    names = tuple(robot.names[row] for row in rows.tolist()) if robot.names else ()
    maps = tuple(robot.maps[row] for row in rows.tolist()) if robot.maps else ()
    beliefs = robot.beliefs.take(rows) if isinstance(robot.beliefs, BeliefsNow) else robot.beliefs
    return attrs.evolve(
        robot,
        rows=len(rows),
        names=names,
        drive=take(robot.drive, rows),
        sensors=sensors,
        maps=maps,
        beliefs=beliefs,
    )
