"""Robots on two driven wheels, the commonest: phases of a step in one kernel call where several would do the same.

At one row a step is mostly calls, not arithmetic. What is asked here has the bits of what the phases give one by one;
whatever is not of the classes that are named here goes that way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from amorsim.contracts import Estimate
from amorsim.drives.differential import Differential
from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.kernels.concluding import conclude as conclude_rows
from amorsim.kernels.rolling import roll_free
from amorsim.sensors.encoder import Encoder
from amorsim.simulation.bodies import World

if TYPE_CHECKING:
    from amorsim.simulation.group import Group

__all__ = ["Wheels"]


class Wheels:
    """What can be made in one call for a group, and is given to it; made anew with the group's parameters."""

    def __init__(self, group: Group) -> None:
        self._group = group
        self._rows = group.rows
        self._rolls = self._rolling(group)
        self._concludes = self._concluding(group)

    @staticmethod
    def _rolling(group: Group) -> tuple[Any, ...] | None:
        drive = group.drive
        if type(drive) is not Differential or group.devices or group.ground.elements or group.zones:
            return None
        return (
            drive.rate_max,
            drive._acceleration(group.rows),
            drive.lag,
            drive.wheel_radius_left,
            drive.wheel_radius_right,
            drive.track,
            group.dt,
        )

    @staticmethod
    def _concluding(group: Group) -> tuple[str, tuple[Any, ...]] | None:
        if group.sensing.others or len(group.estimators) != 1:
            return None
        ((name, estimator),) = group.estimators.items()
        drive = group.robot.drive
        if type(estimator) is not DeadReckoning or type(drive) is not Differential:
            return None
        sensor = group.robot.sensors[estimator.encoder].sensor
        if type(sensor) is not Encoder:
            return None
        return name, (
            group.sensors[estimator.encoder].first,
            sensor.counts_per_revolution,
            drive.wheel_radius_left,
            drive.wheel_radius_right,
            drive.track,
            estimator.wheel_variance,
        )

    def roll(self, world: World) -> bool:
        """Actuate and move, where that can be and nothing is in the way; else nothing has happened.

        That is on firm ground, for robots that have no company and are the only ones.
        """
        if self._rolls is None:
            return False
        group, rows = self._group, self._rows
        wheels, end, twists = np.empty((2, rows, 2)), np.empty((rows, 3)), np.empty((rows, 3))
        roll: Any = roll_free
        made = roll(
            group.joints,
            group.joint_rates,
            group.command,
            *self._rolls,
            world.poses,
            world.bodies.reach,
            world.room,
            wheels,
            end,
            twists,
        )
        if made:
            group.joints, group.joint_rates = wheels
            group.true_pose, group.true_twist = end, twists
        return bool(made)

    def conclude(self) -> bool:
        """Estimate and record, where dead reckoning by a plain encoder is all there is; else nothing has happened."""
        if self._concludes is None:
            return False
        group, rows = self._group, self._rows
        name, given = self._concludes
        pose, grown, joints = np.empty((rows, 3)), np.empty((rows, 3, 3)), np.empty((rows, 2))
        state, batch = group.estimator_states[name], group.sensing.batch
        told = (
            *given,
            state["pose"],
            state["covariance"],
            state["joints"],
            joints,
            pose,
            grown,
            group.true_pose,
            group.joints,
            np.ascontiguousarray(group.command),
            group.sensing.sizes,
            batch.true,
            batch.measured,
        )
        conclude: Any = conclude_rows
        group.sensing.share_read(lambda first, end: conclude(*told, first, end, group.fingerprint))
        state["pose"], state["covariance"], state["joints"] = pose, grown, joints
        group.estimates[name] = Estimate(pose, grown)
        return True
