"""The source of commands, row by row: the robot's own controller, or a caller that drives it by hand."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Beliefs, Clock, Context, Controller, Draws, Estimate, Measurement, RobotModel, State
from amorsim.core.rows import stack, take
from amorsim.core.trouble import RAISED
from amorsim.scenario.spec import Robot
from amorsim.simulation.beliefs import BeliefsNow, beliefs_problem, chosen
from amorsim.simulation.blame import Whose, is_finite

__all__ = ["Driver", "report_problem"]

Array = npt.NDArray[np.float64]
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

    _ARRAYS = ("active", "by_hand", "hand")

    def __init__(self, channels: Sequence[str], of_drive: int, draws: Draws, whose: Whose) -> None:
        self._channels = channels
        self._of_drive = of_drive  # number of channels of the drive
        self._draws = draws
        self._whose = whose
        self.controller: Controller | None = None
        self.state: State = {}
        self.hand = np.zeros((0, len(channels)))
        self.active = self.by_hand = np.zeros((0, 1), dtype=bool)

    def set_parameters(self, nominal: Sequence[Robot]) -> None:
        """Take the parameters of every row."""
        if nominal[0].controller is not None:
            self.controller = stack([robot.controller for robot in nominal])

    def start(self, context: Context) -> None:
        """Start an episode in every row, driven by its controller."""
        self.active = np.ones((context.rows, 1), dtype=bool)
        self.by_hand = np.zeros((context.rows, 1), dtype=bool)
        self.hand = np.zeros((context.rows, len(self._channels)))
        self.state = {}
        if self.controller is not None:
            try:
                self.state = dict(self.controller.start(context))
            except RAISED as error:
                self._whose.blame_start("controller", self.controller, error)

    def hand_over(self, row: int, to_hand: bool) -> None:
        """Drive a row from outside from now on, at rest at first, or by its controller again, which may have ended."""
        self.by_hand = self.by_hand.copy()
        self.by_hand[row] = to_hand
        self.hand = self.hand.copy()
        self.hand[row] = 0.0
        if not to_hand:
            self.active = self.active.copy()
            self.active[row] = True

    def end(self, row: int) -> None:
        """Stop a row from now on."""
        self.active = self.active.copy()
        self.active[row] = False

    def command(
        self, before: Array, robot: RobotModel, readings: Mapping[str, Measurement], estimate: Estimate, clock: Clock
    ) -> Array:
        """The command `(N, c)` of this step; `before`, the last one, if there is no controller and no hand.

        Raises
        ------
        ComponentError
            If the controller's command has another shape or is not finite; the message names controller and robot.
        """
        asked = robot, readings, estimate, clock
        if np.count_nonzero(self.by_hand):
            command = self.hand.copy()
            rows = np.flatnonzero(~self.by_hand[:, 0])
            if len(rows):
                answer = 0.0 if self.controller is None else self._ask(self.controller, rows, *asked)
                command[rows] = np.where(self.active[rows], answer, 0.0)
            return command
        if self.controller is None:
            return before
        # A copy: the controller may reuse its array.
        command = np.zeros(self.hand.shape)
        np.copyto(command, self._ask(self.controller, None, *asked), where=self.active)
        return command

    def _ask(
        self,
        controller: Controller,
        which: Rows | None,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
    ) -> Array:
        """The controller's command for the rows in `which`, or for all."""
        asked = robot, readings, estimate, clock, self.state, self._draws
        try:
            command = controller.command(*asked) if which is None else _ask_some(controller, *asked, which)
        except RAISED as error:
            self._whose.blame("controller", controller, error)
        expected = len(self.hand) if which is None else len(which), len(self._channels)
        answer: Any = command  # the plugin may return anything
        if not isinstance(answer, np.ndarray) or answer.dtype.kind not in "biuf":
            found = f"{answer.dtype} array" if isinstance(answer, np.ndarray) else type(answer).__name__
            problem = f"expected a command of the shape {expected}, got a {found}"
            raise self._whose.wrong("controller", controller, problem)
        if command.shape == (expected[0], self._of_drive) != expected:
            command = np.concatenate((command, np.zeros((expected[0], expected[1] - self._of_drive))), axis=1)
        channels = ", ".join(self._channels)
        if command.shape != expected:
            problem = f"expected a command of the shape {expected} ({channels}), got {command.shape}"
            raise self._whose.wrong("controller", controller, problem)
        if not is_finite(command):
            whole = np.zeros(self.hand.shape)
            whole[slice(None) if which is None else which] = command
            raise self._whose.not_finite("controller", controller, channels, whole)
        return command

    def reports(self) -> list[tuple[int, str, Any]]:
        """What the controller says happened in the last command: row, word and value, of the rows that it drives.

        Raises
        ------
        ComponentError
            If the controller raises, or returns no reports.
        """
        controller = self.controller
        if controller is None or type(controller).reports is Controller.reports:
            return []
        try:
            found = list(controller.reports(self.state))
        except RAISED as error:
            self._whose.blame("controller", controller, error)
        for report in found:
            if problem := report_problem(report, len(self.active)):
                raise self._whose.wrong("controller", controller, problem)
        return [report for report in found if self.active[report[0], 0] and not self.by_hand[report[0], 0]]

    @property
    def believes(self) -> bool:
        """Whether the controller has beliefs."""
        return self.controller is not None and type(self.controller).beliefs is not Controller.beliefs

    def beliefs(self, wanted: Iterable[str] | None = None) -> Beliefs:
        """The beliefs of the controller, as its state is now: those that are wanted, or all.

        Raises
        ------
        ComponentError
            If it raises, or returns what are no beliefs.
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

    # ------------------------------------------------------------------------------------ for snapshots and resets

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """The engine's own arrays that change; do not write into them."""
        return {name: getattr(self, name) for name in self._ARRAYS}

    def set_arrays(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Restore what `arrays` returned."""
        for name in self._ARRAYS:
            setattr(self, name, arrays[name])


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
    part: dict[str, npt.NDArray[Any]] = {name: array[rows] for name, array in state.items()}
    command = take(controller, rows).command(
        _model(robot, rows),
        {name: _some(reading, rows) for name, reading in readings.items()},
        Estimate(estimate.pose[rows], estimate.covariance[rows]),
        Clock(clock.tick[rows], clock.time[rows], clock.dt),
        part,
        draws.take(rows),
    )
    for name, array in part.items():
        whole = state[name].copy()
        whole[rows] = array
        state[name] = whole
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
