"""Three wheels; the front one is steered and driven."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, DriveBinding, Joint, State, parameter
from amorsim.core.parameters import own_first
from amorsim.drives.motors import Steered
from amorsim.kernels.kinematics import steering

__all__ = ["Tricycle"]


_RIGHT = np.pi / 2.0
_NEARLY_RIGHT = _RIGHT - 1e-9  # [rad] from this steering angle on, the base turns in place


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Tricycle(Steered):
    """A front wheel that is steered and driven, and two rear wheels that follow, as under many a fork lift.

    The base point is the middle of the rear axle. With the steering at an angle s, each metre that the front wheel
    rolls moves the base cos(s) metres forward and turns it by sin(s) / wheelbase: an arc of radius wheelbase / tan(s);
    at a right angle it turns in place. The steering moves evenly within a step. Then the heading has a closed form; the
    position is summed to the last digits.

    While the steering approaches its command, the wheel rolls slower the larger the difference. From 20 degrees on it
    waits.

    Parameters
    ----------
    wheel_radius
        Radius of the front wheel [m].
    wheelbase
        Distance from the rear axle to the front wheel [m].
    steering_max
        Largest steering angle to either side [rad].
    steering_rate
        Fastest rate of the steering [rad/s].
    steering_lag
        Time constant with which the steering follows its command [s]; 0 for none.
    rate_max
        Fastest rate of the front wheel [rad/s].
    lag, acceleration_max
        How the front wheel follows its command; see `Motors`.
    """

    joints: ClassVar[tuple[Joint, ...]] = (Joint(name="steering", rolls=False), Joint(name="front_wheel"))
    channels: ClassVar[tuple[str, ...]] = ("steering", "front_wheel")  # an angle [rad], a rate [rad/s]

    wheel_radius: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the front wheel")
    wheelbase: float = parameter(unit="m", ge=1e-3, le=100, help="from the rear axle to the front wheel")
    steering_max: float = parameter(_RIGHT, unit="rad", gt=0, le=_RIGHT, help="largest steering angle to either side")
    rate_max: float = parameter(unit="rad/s", gt=0, le=1e6, help="fastest that the front wheel turns")

    def bind(self, at: DriveBinding) -> Callable[[], None]:
        """Move steering and wheel by a kernel."""
        steered = self.steering_max, self.steering_rate, self.steering_lag
        rolled = self.rate_max, self._acceleration(at.rows), self.lag
        joints = at.joints, at.joint_rates, at.command
        return functools.partial(steering.tricycle_advance, *joints, *steered, *rolled, at.dt, at.out)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, 2)` [rad] and rates [rad/s] a step later; the command is steering [rad] and wheel [rad/s]."""
        out = np.empty((2, *joints.shape))
        steering.tricycle_advance(
            joints,
            rates,
            command,
            self.steering_max,
            self.steering_rate,
            self.steering_lag,
            self.rate_max,
            self._acceleration(len(joints)),
            self.lag,
            dt,
            out,
        )
        return out[0], out[1]

    def displacement(self, before: Array, after: Array, fraction: Array) -> Array:
        """The body's displacement `(N, 3)` at a fraction `(N, 1)` of the step."""
        out = np.empty((len(before), 3))
        steering.tricycle_paths(before, after, fraction, self.wheel_radius, self.wheelbase, out)
        return out

    def bind_displacement(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the displacement by a kernel."""
        lengths, whole = (self.wheel_radius, self.wheelbase), np.ones((len(out), 1))
        return functools.partial(steering.tricycle_paths, before, after, whole, *lengths, out)

    def travel(self, before: Array, after: Array) -> Array:
        """Bounds on the path `(N, 2)`: the way of the front wheel, and its turn with the wheel at a right angle."""
        way = np.abs(after[:, 1:2] - before[:, 1:2]) * self.wheel_radius
        return np.concatenate((way, way / self.wheelbase), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """Steering and front wheel `(N, 2)` [rad, rad/s] for `twist` `(N, 3)`, less its part to the left."""
        out = np.empty((len(twist), 2))
        steering.tricycle_commands(twist, joints, self.wheel_radius, self.wheelbase, self.steering_max, out)
        return out

    def rolling_radius(self) -> Array:
        """Radius of the front wheel `(N, 1)` [m]."""
        return np.array(self.wheel_radius)

    def contacts(self, joints: Array) -> Array:
        """Where the front wheel touches the ground `(N, 1, 2)` [m]."""
        found = np.zeros((len(joints), 1, 2))
        found[:, :, 0] = np.asarray(self.wheelbase)
        return found

    def curvature_max(self) -> Array:
        """Largest curvature `(N, 1)` [1/m]; inf where the steering reaches a right angle."""
        cos, sin = self.steering_end()
        return np.where(
            np.asarray(self.steering_max) >= _NEARLY_RIGHT, np.inf, sin / np.maximum(cos, 1e-9) / self.wheelbase
        )

    def top_speeds(self) -> Array:
        """Top speed and turning rate, and the largest change of each, `(N, 4)`."""
        _, sin = self.steering_end()
        fastest: Any = self.rate_max * self.wheel_radius
        change = self._acceleration(len(fastest)) * self.wheel_radius
        lever = sin / self.wheelbase
        return np.concatenate((fastest, fastest * lever, change, change * lever), axis=1)
