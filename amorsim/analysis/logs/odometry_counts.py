"""Odometry in a log, which is poses, as the counts of a robot's encoder."""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.core.errors import AnalysisError
from amorsim.core.poses import logarithm, relative
from amorsim.core.rows import stack
from amorsim.scenario.spec import Robot
from amorsim.sensors.encoder import Encoder

__all__ = ["OdometryCounts"]


class OdometryCounts:
    """The counts with which a robot's nominal drive would have moved as odometry says.

    Raises
    ------
    AnalysisError
        If the robot's wheels do not only roll.
    """

    def __init__(self, robot: Robot, encoder: Encoder, where: str) -> None:
        if not all(joint.rolls for joint in robot.drive.joints):
            raise AnalysisError(
                f"{where}: poses by odometry become counts of an encoder on wheels that only roll; those of robot "
                f"{robot.name!r} steer"
            )
        self._drive = stack([robot.drive])
        self._per_turn = np.asarray(encoder.counts_per_revolution)
        self._angles = np.zeros((1, len(robot.drive.joints)))
        self._pose: Array | None = None

    def at(self, pose: Array) -> Array:
        """The counts `(j,)` at the next pose `(3,)`; nan at one that is not finite, which is passed over."""
        if not np.isfinite(pose).all():
            return np.full(self._angles.shape[1], math.nan)
        if self._pose is not None:
            motion = logarithm(relative(self._pose[None], pose[None]))
            self._angles = self._angles + self._drive.command_for(np.ascontiguousarray(motion), self._angles)  # in 1 s
        self._pose = pose
        counts: Array = self._angles[0] / (2.0 * math.pi) * self._per_turn
        return counts
