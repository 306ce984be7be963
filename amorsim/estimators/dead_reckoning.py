"""Dead reckoning: the pose from the motion of the wheels."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import (
    Context,
    Draws,
    Estimate,
    Estimator,
    EstimatorBinding,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.estimator import update_bound
from amorsim.core.execution.workers import in_turn
from amorsim.estimators.initial_beliefs import covariance_at_start, refuse_lost
from amorsim.estimators.wheels import bind_angles, bind_step, check_encoder
from amorsim.kernels.kinematics import odometry

__all__ = ["DeadReckoning"]


@attrs.frozen(kw_only=True)
class DeadReckoning(Estimator):
    """Adds up the nominal drive's displacements between encoder readings, from the pose it was given.

    The covariance grows from that of the robot's initial belief by white noise on the travel of each rolling joint, to
    first order; it does not depend on the number of steps. A drive may offer ``jacobian(before, after) -> (N, 3, r)``,
    the body's motion (forward, left, turn) per metre of travel of each rolling joint. Otherwise the Jacobian is found
    by turning each joint a little.

    Parameters
    ----------
    encoder
        Name of the sensor that counts the joints; any with a method ``angles(values) -> joints`` will do.
    wheel_variance
        Variance of the travel of each rolling joint per metre, as the robot assumes it [m^2/m].
    """

    encoder: str = parameter("encoder", refers="sensors", help="name of the sensor that counts the joints")
    wheel_variance: float = parameter(
        0.0,
        unit="m",
        ge=0,
        help="variance of a rolling joint's travel [m^2] per metre of it, as the robot believes",
    )

    def start(self, context: Context) -> State:
        """Pose and covariance, and the joints at the last reading, none yet.

        Raises
        ------
        ComponentError
            If the robot has no such sensor, or one that counts no joints, or knows nothing of its start.
        """
        check_encoder("dead reckoning", context.robot, self.encoder)
        refuse_lost("dead reckoning", context)
        return {
            "pose": np.array(context.pose, dtype=np.float64),
            "covariance": covariance_at_start(context),
            "joints": np.full((context.rows, len(context.robot.drive.joints)), np.nan),
        }

    def bind(self, at: EstimatorBinding) -> Callable[[], None]:
        """Reckon on the engine's own arrays."""
        pose, covariance, joints = (at.state[name] for name in ("pose", "covariance", "joints"))
        before, after, take = bind_angles(at.robot, self.encoder, at.readings[self.encoder].measured, joints)
        step, move = bind_step(at.robot.drive, before, after)
        variance: Any = self.wheel_variance
        carry_on = functools.partial(odometry.reckon, pose, covariance, *step, variance, pose, covariance)

        def show() -> None:
            np.copyto(at.out.pose, pose)
            np.copyto(at.out.covariance, covariance)

        return in_turn([take, move, carry_on, show])

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's reading; an old reading shows the same joints and changes nothing."""
        bind = functools.partial(DeadReckoning.bind, self)
        return update_bound(bind, robot, readings, command, elapsed, state, draws)

    def is_current(self, readings: Mapping[str, Measurement], state: State) -> Bools:
        """Where the last reading of the encoder was not lost, or none has come in yet."""
        is_read = np.isfinite(readings[self.encoder].measured).all(axis=1, keepdims=True)
        return np.asarray(is_read | np.isnan(state["joints"]).all(axis=1, keepdims=True))
