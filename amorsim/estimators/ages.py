"""Readings that arrive late: an estimator that keeps no history refuses them."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.contracts import Measurement, RobotModel
from amorsim.core.errors import ComponentError

__all__ = ["refuse_late"]

_LATE = 1e-9  # [s] beyond the age allowed


def refuse_late(who: str, robot: RobotModel, sensor: str, reading: Measurement, age_max: Any) -> None:
    """Raise a `ComponentError` if a reading that has just arrived is older than `age_max` [s]."""
    late = reading.fresh & (reading.age > age_max + _LATE)
    if late.any():
        row = int(np.flatnonzero(late[:, 0])[0])
        raise ComponentError(
            f"{robot.who(row)}, estimator {who}: the reading of {sensor!r} was {reading.age[row, 0]:g} s old when it "
            "arrived, and the filter keeps no history; give the sensor no latency, or set age_max to use readings "
            "up to that age as if they were taken now"
        )
