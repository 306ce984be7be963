"""Four wheels with rollers at 45 degrees, each with its own motor."""

from __future__ import annotations

from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Joint, State, parameter
from amorsim.core.parameters import own_first
from amorsim.drives.motors import Motors
from amorsim.kernels.kinematics import odometry

__all__ = ["Mecanum"]


# In the order of the joints: the side to which a wheel that rolls ahead pushes the body, and the side that it is on.
_ASIDE = (-1.0, 1.0, 1.0, -1.0)
_SIDE = (-1.0, 1.0, -1.0, 1.0)
_AGAINST = (1.0, 1.0, -1.0, -1.0)  # rim speeds that make no motion


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Mecanum(Motors):
    """Four wheels whose rollers stand at 45 degrees (seen from above in an X): it goes any way and turns as it does.

    The base point is the middle between the wheels. A body that moves with (v, u, w) rolls its wheels at v -+ u -+ h w,
    where h is half the sum of track and wheelbase. Conversely, the body moves with the mean over the wheels. If the
    wheels agree with no motion (one of them slips), the mean is the least-squares solution. The drive does not follow
    the part of a command that would set the wheels against one another. A step is the arc of a constant twist, in
    closed form.

    Parameters
    ----------
    wheel_radius_front_left, wheel_radius_front_right, wheel_radius_rear_left, wheel_radius_rear_right
        Radii of the wheels [m].
    wheelbase
        Distance from the middles of the rear wheels to those of the front wheels [m].
    track
        Distance between the middles of left and right wheels [m].
    rate_max
        Fastest rate of a wheel [rad/s]. A faster command is scaled down for all wheels by the same factor, which keeps
        the path.
    lag, acceleration_max
        How each wheel follows its own command; see `Motors`.
    """

    joints: ClassVar[tuple[Joint, ...]] = tuple(
        Joint(name=f"{end}_{side}") for end in ("front", "rear") for side in ("left", "right")
    )
    channels: ClassVar[tuple[str, ...]] = tuple(joint.name for joint in joints)

    wheel_radius_front_left: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the left front wheel")
    wheel_radius_front_right: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the right front wheel")
    wheel_radius_rear_left: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the left rear wheel")
    wheel_radius_rear_right: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the right rear wheel")
    wheelbase: float = parameter(unit="m", ge=1e-3, le=100, help="from the rear wheels' middles to the front ones'")
    track: float = parameter(unit="m", ge=1e-3, le=100, help="distance between the middles of left and right wheels")
    rate_max: float = parameter(unit="rad/s", gt=0, le=1e6, help="fastest that a wheel turns")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Wheel angles `(N, 4)` [rad] and rates [rad/s] a step later; the command is wheel rates [rad/s]."""
        # Remove the part that sets the wheels against one another: the wheels grip, and the motors give way.
        radius = self.rolling_radius()
        fl, fr, rl, rr = np.moveaxis(command * radius, 1, 0)
        against = ((fl + fr) - (rl + rr))[:, None] / 4.0
        command = command - against * np.array([_AGAINST]) / radius
        out = np.empty((2, *joints.shape))
        odometry.drive_wheels(joints, rates, command, self.rate_max, self._acceleration(len(joints)), self.lag, dt, out)
        return out[0], out[1]

    def twist(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward [m], left [m], turn [rad]) `(N, 3)` as wheels go from `before` to `after`."""
        fl, fr, rl, rr = np.moveaxis((after - before) * self.rolling_radius(), 1, 0)
        # Each sum is in the same order for every row, so bits do not depend on the number of rows.
        forward, left = ((fl + fr) + (rl + rr)) / 4.0, ((fr - fl) + (rl - rr)) / 4.0
        turn = ((fr - fl) + (rr - rl)) / (4.0 * self._lever()[:, 0])
        return np.stack((forward, left, turn), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """Wheel rates `(N, 4)` [rad/s] that make the body move with `twist` `(N, 3)`."""
        across = self._lever() * twist[:, 2:3]
        rims = twist[:, 0:1] + np.array([_ASIDE]) * twist[:, 1:2] + np.array([_SIDE]) * across
        return np.asarray(rims / self.rolling_radius())

    def rolling_radius(self) -> Array:
        """Radii of the wheels `(N, 4)` [m]."""
        radii: Any = (
            self.wheel_radius_front_left,
            self.wheel_radius_front_right,
            self.wheel_radius_rear_left,
            self.wheel_radius_rear_right,
        )
        return np.concatenate(radii, axis=1)

    def contacts(self, joints: Array) -> Array:
        """Where the wheels touch the ground `(N, 4, 2)` [m]."""
        found = np.empty((len(joints), 4, 2))
        found[:, :, 0] = np.array([[0.5, 0.5, -0.5, -0.5]]) * self.wheelbase
        found[:, :, 1] = np.array([[0.5, -0.5, 0.5, -0.5]]) * self.track
        return found

    def jacobian(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward, left, turn) per metre of each wheel's travel, `(N, 3, 4)`."""
        lever = self._lever()
        out = np.empty((len(lever), 3, 4))
        out[:, 0] = 0.25
        out[:, 1] = 0.25 * np.array([_ASIDE])
        out[:, 2] = 0.25 * np.array([_SIDE]) / lever
        return out

    def _lever(self) -> Array:
        lever: Any = self.track + self.wheelbase
        return np.asarray(0.5 * lever)
