"""Readings that arrive late: an estimator that keeps no history refuses them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from amorsim.array_types import Bools
from amorsim.contracts import Measurement, RobotModel
from amorsim.core.errors import ComponentError
from amorsim.kernels.number_checks import first_late

__all__ = ["bind_fresh", "check_fresh", "is_late"]

_LATE = 1e-9  # [s] beyond the age allowed


def is_late(reading: Measurement, age_max: Any) -> Bools:
    """Whether readings, new or not, are older than `age_max` [s] `(N, 1)`."""
    return np.asarray(reading.age > age_max + _LATE)


def check_fresh(who: str, robot: RobotModel, sensor: str, reading: Measurement, age_max: Any) -> Bools:
    """Whether readings are new `(N, 1)`.

    Raises
    ------
    ComponentError
        If one is older than `age_max` [s] when it arrives.
    """
    bind_fresh(who, robot, sensor, reading, age_max)()
    return reading.fresh


def bind_fresh(who: str, robot: RobotModel, sensor: str, reading: Measurement, age_max: Any) -> Callable[[], None]:
    """A function that raises a `ComponentError` if a reading is older than `age_max` [s] when it arrives."""
    limit = np.array(np.broadcast_to(age_max + _LATE, reading.age.shape))

    def check() -> None:
        row = first_late(reading.fresh, reading.age, limit)
        if row >= 0:
            raise ComponentError(
                f"{robot.who(row)}, estimator {who}: the reading of {sensor!r} was {reading.age[row, 0]:g} s old when "
                "it arrived, and the estimator keeps no history; give the sensor no latency, or set age_max to use "
                "readings up to that age as if they were taken now"
            )

    return check
