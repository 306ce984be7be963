"""The joints of a drive as its robot knows them: by a sensor that counts them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts.robot import Joint, RobotModel
from amorsim.contracts.values import Measurement

__all__ = ["at_rest", "joints_of"]


def at_rest(robot: RobotModel) -> Array:
    """Joints `(N, j)` of a drive that points straight ahead: all at 0."""
    return np.zeros((robot.rows, len(robot.drive.joints)))


def joints_of(robot: RobotModel, readings: Mapping[str, Measurement]) -> Array:
    """The drive's joints `(N, j)` [rad] from the first sensor that counts them; all 0 where none does.

    They are also 0 where all joints only roll: their angles do not show where the wheels point.
    """
    rest = at_rest(robot)
    if _only_rolls(robot.drive.joints):
        return rest
    for name, model in robot.sensors.items():
        angles: Any = getattr(model.sensor, "angles", None)
        if callable(angles):
            found = np.asarray(angles(readings[name].measured))
            if found.shape == rest.shape:
                return np.where(np.isfinite(found), found, 0.0)
    return rest


def _only_rolls(joints: tuple[Joint, ...]) -> bool:
    for joint in joints:  # noqa: SIM110 - asked in every step, and a generator takes longer
        if not joint.rolls:
            return False
    return True
