"""Wheels that all steer and roll together, by one motor each."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, DriveBinding, Joint, State, parameter
from amorsim.core.parameters import own_first
from amorsim.drives.motors import Winding, over_rows
from amorsim.kernels.kinematics import synchro

__all__ = ["Synchro"]


_TURRETS = {"fixed": synchro.FIXED, "follows": synchro.FOLLOWS, "driven": synchro.DRIVEN}
_JOINTS = (Joint(name="steering", rolls=False), Joint(name="wheels"))
_TURRET = Joint(name="turret", rolls=False)


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Synchro(Winding):
    """Three or more wheels that stay parallel: one motor steers them all, another rolls them all.

    The base point is the middle between the wheels. It moves where the wheels point, in any orientation of the body:
    with the steering turning at w and the wheels rolling at v, along a circle of radius v / w, while the body keeps
    its orientation. The robot's frame (its shape and sensors) is that of a turret. The turret is ``"fixed"`` to the
    base and never turns; or it ``"follows"`` the steering, by a belt; or it is ``"driven"`` by a third motor.

    Ahead is where the wheels point (`heading_offset`). The turn of a commanded velocity is that of the wheels.

    Parameters
    ----------
    wheel_radius
        Radius of the wheels [m].
    rate_max
        Fastest rolling rate [rad/s].
    steering_rate_max
        Fastest steering rate [rad/s].
    turret
        How the robot's frame turns: ``"fixed"``, ``"follows"`` or ``"driven"``.
    turret_rate_max
        Fastest rate of a driven turret relative to the base [rad/s].
    steering_acceleration_max
        Largest change per second of the rates of steering and turret [rad/s^2]; none for no limit.
    lag, acceleration_max
        How the rate of the wheels follows its command (`Motors`); the lag also holds for steering and turret.
    """

    wheel_radius: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the wheels")
    rate_max: float = parameter(unit="rad/s", gt=0, le=1e6, help="fastest that the wheels roll")
    steering_rate_max: float = parameter(unit="rad/s", gt=0, le=1e6, help="fastest that the wheels steer")
    turret: str = parameter(
        "fixed", choices=("fixed", "follows", "driven"), static=True, help="how the robot's frame turns"
    )
    turret_rate_max: float = parameter(1.0, unit="rad/s", gt=0, le=1e6, help="fastest that a driven turret turns")
    steering_acceleration_max: float | None = parameter(
        None, unit="rad/s^2", gt=0, le=1e9, help="most that steering and turret speed up in a second; none for no limit"
    )

    @property
    def joints(self) -> tuple[Joint, ...]:  # type: ignore[override]
        """Steering and wheels, and the turret where it has a motor of its own; against the base, all of them."""
        return (*_JOINTS, _TURRET) if self.turret == "driven" else _JOINTS

    @property
    def channels(self) -> tuple[str, ...]:  # type: ignore[override]
        """Rates [rad/s] of the same."""
        return tuple(joint.name for joint in self.joints)

    @property
    def _mode(self) -> int:
        return _TURRETS[self.turret]

    def bind(self, at: DriveBinding) -> Callable[[], None]:
        """Move steering, wheels and turret by a kernel."""
        limits = self.steering_rate_max, self.rate_max, self.turret_rate_max
        changes = over_rows(self.steering_acceleration_max, at.rows), self._acceleration(at.rows), self.lag
        joints = at.joints, at.joint_rates, at.command
        return functools.partial(synchro.synchro_advance, *joints, *limits, *changes, at.dt, at.out)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, j)` [rad] and rates [rad/s] a step later; the command is rates [rad/s]."""
        out = np.empty((2, *joints.shape))
        synchro.synchro_advance(
            joints,
            rates,
            command,
            self.steering_rate_max,
            self.rate_max,
            self.turret_rate_max,
            over_rows(self.steering_acceleration_max, len(joints)),
            self._acceleration(len(joints)),
            self.lag,
            dt,
            out,
        )
        return out[0], out[1]

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        """The displacement `(N, 3)` at a fraction `(N, 1)` of the step: a chord of the circle that the wheels drive."""
        out = np.empty((len(before), 3))
        synchro.synchro_paths(before, after, fraction, self.wheel_radius, self._mode, out)
        return out

    def bind_displacement(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the displacement by a kernel."""
        whole = np.ones((len(out), 1))
        return functools.partial(synchro.synchro_paths, before, after, whole, self.wheel_radius, self._mode, out)

    def travel(self, before: Array, after: Array) -> Array:
        """Length of the path [m] and turning of the robot's frame [rad] `(N, 2)`."""
        way = np.abs(after[:, 1:2] - before[:, 1:2]) * self.wheel_radius
        turn = np.zeros_like(way)
        if self.turret != "fixed":
            column = 0 if self.turret == "follows" else 2
            turn = np.abs(after[:, column : column + 1] - before[:, column : column + 1])
        return np.concatenate((way, turn), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """Rates `(N, c)` [rad/s] for `twist` `(N, 3)`; the wheels roll at its component along them.

        They are steered at the twist's turn, and towards its velocity where they point elsewhere.
        """
        out = np.empty((len(twist), len(self.joints)))
        synchro.synchro_commands(twist, joints, self.wheel_radius, self._mode, out)
        return out

    def rolling_radius(self) -> Array:
        """Radius of the wheels `(N, 1)` [m]."""
        return np.array(self.wheel_radius)

    def heading_offset(self, joints: Array) -> Array | None:
        """Direction of the wheels `(N, 1)` [rad] in the robot's frame; None if the frame follows them."""
        if self.turret == "follows":
            return None
        out = np.empty((len(joints), 1))
        synchro.courses(joints, self._mode, out)
        return out

    def top_speeds(self) -> Array:
        """Top speed and turning rate of the course, and the largest change of each, `(N, 4)`."""
        fastest: Any = self.rate_max * self.wheel_radius
        rows = len(fastest)
        change = self._acceleration(rows) * self.wheel_radius
        turn: Any = self.steering_rate_max
        if self.turret == "driven":
            turn = np.minimum(turn, self.turret_rate_max)  # it turns along
        return np.concatenate((fastest, turn, change, over_rows(self.steering_acceleration_max, rows)), axis=1)
