"""Who drives: each robot's own controller, or a hand from outside, row by row."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Clock, Controller, Draws, Estimate, Measurement, RobotModel, State
from amorsim.core.rows import take

__all__ = ["ask_some"]

Array = npt.NDArray[np.float64]
Rows = npt.NDArray[np.intp]


def ask_some(
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
