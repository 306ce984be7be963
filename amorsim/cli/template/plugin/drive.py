"""A drive: one wheel that rolls, and a motor that turns the robot on the spot."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Unicycle"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Unicycle(am.Drive):
    """A wheel under the base point, and a motor that turns the body about it.

    Parameters
    ----------
    wheel_radius
        Radius of the wheel [m].
    rate_max
        Fastest that the wheel and the motor turn [rad/s].
    """

    joints: ClassVar[tuple[am.Joint, ...]] = (am.Joint(name="wheel"), am.Joint(name="motor", rolls=False))
    channels: ClassVar[tuple[str, ...]] = ("wheel", "motor")  # rates [rad/s]

    wheel_radius: float = am.parameter(0.1, unit="m", gt=0, help="radius of the wheel")
    rate_max: float = am.parameter(10.0, unit="rad/s", gt=0, help="fastest that the wheel and the motor turn")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: am.State, draws: am.Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, 2)` [rad] and their rates [rad/s] a step later."""
        after = joints + np.clip(command, -self.rate_max, self.rate_max) * dt
        return after, (after - joints) / dt

    def twist(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward [m], left [m], turn [rad]) `(N, 3)` as the joints go from `before` to `after`."""
        way = (after - before) * np.concatenate(
            (self.wheel_radius + np.zeros((len(before), 1)), np.ones((len(before), 1))), axis=1
        )
        return np.stack((way[:, 0], np.zeros(len(before)), way[:, 1]), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """The command `(N, 2)` [rad/s] for a twist `(N, 3)` [m/s, m/s, rad/s], less its part to the left."""
        return np.concatenate((twist[:, 0:1] / self.wheel_radius, twist[:, 2:3]), axis=1)

    def rolling_radius(self) -> Array:
        """Radius of the wheel `(N, 1)` [m]."""
        return np.asarray(self.wheel_radius)
