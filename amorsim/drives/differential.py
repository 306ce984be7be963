"""Two wheels on one axle, each with its own motor."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, DriveBinding, Joint, State, parameter
from amorsim.core.parameters import own_first
from amorsim.drives.motors import Motors
from amorsim.kernels.kinematics import odometry

__all__ = ["Differential"]


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Differential(Motors):
    """Two driven wheels on one axle, and castors that follow; the base point is the middle of the axle.

    With the wheels' travels l and r [m] over a step, the body goes (l + r) / 2 forward and turns by (r - l) /
    track: an arc of a circle, or a line, followed in closed form.

    Parameters
    ----------
    wheel_radius_left, wheel_radius_right
        Radii of the wheels [m].
    track
        Distance between the points where the wheels touch the ground [m].
    rate_max
        Fastest rate of a wheel [rad/s]. A faster command is scaled down for both wheels by the same factor, which
        keeps the curvature of the path.
    lag, acceleration_max
        How each wheel follows its own command; see `Motors`.
    """

    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="left_wheel"), Joint(name="right_wheel"))
    channels: ClassVar[tuple[str, ...]] = ("left", "right")

    wheel_radius_left: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the left wheel")
    wheel_radius_right: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the right wheel")
    track: float = parameter(unit="m", ge=1e-3, le=100, help="distance between the wheels' points of contact")
    rate_max: float = parameter(unit="rad/s", gt=0, le=1e6, help="fastest that a wheel turns")

    def bind(self, at: DriveBinding) -> Callable[[], None]:
        """Move the wheels by a kernel."""
        acceleration, lag = self._acceleration(at.rows), self.lag
        rates = at.joint_rates, at.command, self.rate_max, acceleration, lag
        return functools.partial(odometry.drive_wheels, at.joints, *rates, at.dt, at.out)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Wheel angles `(N, 2)` [rad] and rates [rad/s] a step later; the command is wheel rates [rad/s]."""
        out = np.empty((2, *joints.shape))
        odometry.drive_wheels(joints, rates, command, self.rate_max, self._acceleration(len(joints)), self.lag, dt, out)
        return out[0], out[1]

    def twist(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward [m], 0, turn [rad]) `(N, 3)` as wheels go from `before` to `after`."""
        out = np.empty((len(before), 3))
        odometry.wheel_twists(before, after, self.wheel_radius_left, self.wheel_radius_right, self.track, out)
        return out

    def bind_twist(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the twist by a kernel."""
        lengths = self.wheel_radius_left, self.wheel_radius_right, self.track
        return functools.partial(odometry.wheel_twists, before, after, *lengths, out)

    def travel(self, before: Array, after: Array) -> Array:
        """Length of the path [m] and turning [rad] of a step `(N, 2)`."""
        return np.abs(self.twist(before, after)[:, ::2])

    def command_for(self, twist: Array, joints: Array) -> Array:
        """Wheel rates `(N, 2)` [rad/s] for `twist` `(N, 3)` [m/s, m/s, rad/s], less its part to the left."""
        out = np.empty((len(twist), 2))
        odometry.wheel_rates(twist, self.wheel_radius_left, self.wheel_radius_right, self.track, out)
        return out

    def rolling_radius(self) -> Array:
        """Radii of the left and the right wheel `(N, 2)` [m]."""
        radii: Any = (self.wheel_radius_left, self.wheel_radius_right)
        return np.concatenate(radii, axis=1)

    def contacts(self, joints: Array) -> Array:
        """Half the track to the left and to the right of the base point `(N, 2, 2)` [m]."""
        found = np.zeros((len(joints), 2, 2))
        half = 0.5 * np.asarray(self.track)
        found[:, 0, 1], found[:, 1, 1] = half[:, 0], -half[:, 0]
        return found

    def speeds_to_rates(self, speeds: Array) -> Array:
        """Wheel rates `(N, 2)` [rad/s] for speeds of the rims `(N, 2)` [m/s], by the drive's own radii."""
        return speeds / self.rolling_radius()

    def jacobian(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward, left, turn) per metre of each wheel's travel, `(N, 3, 2)`."""
        out = np.empty((len(before), 3, 2))
        odometry.wheel_jacobian(self.track, out)
        return out
