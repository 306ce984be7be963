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

__all__ = ["conclude", "roll"]


def roll(group: Group, world: World) -> bool:
    """Actuate and move, where that can be and nothing is in the way; else nothing has happened.

    That is on firm ground, for robots that have no company and are the only ones.
    """
    drive = group.drive
    if type(drive) is not Differential or group.devices or group.ground.elements or group.zones:
        return False
    rows = group.rows
    wheels, end, twists = np.empty((2, rows, 2)), np.empty((rows, 3)), np.empty((rows, 3))
    made = roll_free(
        group.joints,
        group.joint_rates,
        group.command,
        drive.rate_max,
        drive._acceleration(rows),
        drive.lag,
        drive.wheel_radius_left,
        drive.wheel_radius_right,
        drive.track,
        group.dt,
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


def conclude(group: Group) -> bool:
    """Estimate and record, where dead reckoning by a plain encoder is all there is; else nothing has happened."""
    plan = group.sensing
    if plan.others or len(group.estimators) != 1:
        return False
    ((name, estimator),) = group.estimators.items()
    drive: Any = group.robot.drive
    if type(estimator) is not DeadReckoning or type(drive) is not Differential:
        return False
    sensor: Any = group.robot.sensors[estimator.encoder].sensor
    if type(sensor) is not Encoder:
        return False
    counts: Any = sensor.counts_per_revolution  # over rows
    rows = group.rows
    pose, grown, joints = np.empty((rows, 3)), np.empty((rows, 3, 3)), np.empty((rows, 2))
    state, batch = group.estimator_states[name], plan.batch
    given = (
        group.sensors[estimator.encoder].first,
        counts,
        drive.wheel_radius_left,
        drive.wheel_radius_right,
        drive.track,
        estimator.wheel_variance,
        state["pose"],
        state["covariance"],
        state["joints"],
        joints,
        pose,
        grown,
        group.true_pose,
        group.joints,
        np.ascontiguousarray(group.command),
        plan.sizes,
        batch.true,
        batch.measured,
    )
    plan.share_read(lambda first, end: conclude_rows(*given, first, end, group.fingerprint))
    state["pose"], state["covariance"], state["joints"] = pose, grown, joints
    group.estimates[name] = Estimate(pose, grown)
    return True
