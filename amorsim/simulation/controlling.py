"""Who drives: each robot's own controller, or a hand from outside, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Clock, Context, Controller, Draws, Estimate, Measurement, RobotModel, State
from amorsim.core.errors import ComponentError
from amorsim.core.rows import take
from amorsim.core.trouble import RAISED
from amorsim.simulation.blame import is_finite

if TYPE_CHECKING:
    from amorsim.simulation.group import Group

__all__ = ["command_of", "command_of_some", "start_controller"]

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


def start_controller(group: Group, context: Context) -> State:
    """The state of a group's controller at the start of an episode; nothing where there is none."""
    if group.controller is None:
        return {}
    try:
        return dict(group.controller.start(context))
    except RAISED as error:
        group.whose.blame("controller", group.controller, error)


def command_of(group: Group, which: Rows | None) -> Array:
    """The command that the controller of a group gives to the rows in `which`, or to all.

    Raises
    ------
    ComponentError
        If it is of another shape, or not finite; the message names the controller and the robot.
    """
    controller = group.controller
    assert controller is not None
    asked = (group.robot, group.readings, group.estimate, group.row_clock.clock, group.controller_state)
    try:
        if which is None:
            command = controller.command(*asked, group.controller_draws)
        else:
            command = _ask_some(controller, *asked, group.controller_draws, which)
    except RAISED as error:
        group.whose.blame("controller", controller, error)
    expected = group.hand.shape if which is None else (len(which), len(group.channels))
    answer: Any = command  # whatever the plugin returned
    if not isinstance(answer, np.ndarray) or answer.dtype.kind not in "biuf":
        found = f"{answer.dtype} array" if isinstance(answer, np.ndarray) else type(answer).__name__
        raise group.whose.wrong("controller", controller, f"expected a command of the shape {expected}, got a {found}")
    if group.devices and command.shape == (expected[0], len(group.drive.channels)):
        missing = expected[1] - command.shape[1]
        command = np.concatenate((command, np.zeros((expected[0], missing))), axis=1)
    if command.shape != expected or not is_finite(command):
        raise _bad_command(group, command, np.arange(len(group.names)) if which is None else which)
    return command


def command_of_some(group: Group) -> Array:
    """The command of a group of which some rows are driven by hand, and the others by their controller."""
    command = group.hand.copy()
    rows = np.flatnonzero(~group.by_hand[:, 0])
    if len(rows):
        asked = 0.0 if group.controller is None else command_of(group, rows)
        command[rows] = np.where(group.active[rows], asked, 0.0)
    return command


def _bad_command(group: Group, command: Array, which: Rows) -> ComponentError:
    channels = ", ".join(group.channels)
    expected = (len(which), len(group.channels))
    if command.shape != expected:
        problem = f"expected a command of the shape {expected} ({channels}), got {command.shape}"
        return group.whose.wrong("controller", group.controller, problem)
    whole = np.zeros(group.hand.shape)
    whole[which] = command
    return group.whose.not_finite("controller", group.controller, channels, whole)


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
    """The command `(n, c)` that a controller gives to some of its rows; the others are not asked and keep their state.

    So what one robot does never hangs on whether others of its group are driven by hand, and a user's controller that
    raises or hangs is not called for a robot that was taken from it.
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
    return attrs.evolve(robot, rows=len(rows), names=names, drive=take(robot.drive, rows), sensors=sensors)
