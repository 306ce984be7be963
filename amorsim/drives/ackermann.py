"""A car: two front wheels that steer about one point, and a rear axle that rolls."""

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

__all__ = ["Ackermann"]


_PLACES = {"centre": steering.CENTRE, "rear": steering.REAR, "front": steering.FRONT}
_STEERING = Joint(name="steering", rolls=False)
_JOINTS = {
    "centre": (_STEERING, Joint(name="shaft")),
    "rear": (_STEERING, Joint(name="rear_left"), Joint(name="rear_right")),
    "front": (_STEERING, Joint(name="front_left"), Joint(name="front_right")),
}


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Ackermann(Steered):
    """A car; the base point is the middle of the rear axle.

    The steering angle s is that of an equivalent single wheel in the middle of the front axle. Each metre that the
    middle of the rear axle rolls turns the body by tan(s) / wheelbase: an arc of radius wheelbase / tan(s). The front
    wheels point along circles about one centre: the outer one's cotangent less the inner one's is track / wheelbase
    (`front_wheel_angles`). The steering moves evenly within a step. Then the heading has a closed form; the position is
    summed to the last digits.

    The car cannot turn in place, so it cannot follow a twist with a turn but no speed.

    Parameters
    ----------
    wheel_radius
        Radius of the wheels that are counted [m].
    wheelbase
        Distance from the rear axle to the front one [m].
    track
        Distance between left and right wheels, on both axles [m].
    steering_max
        Largest steering angle to either side [rad].
    steering_rate
        Fastest rate of the steering [rad/s].
    steering_lag
        Time constant with which the steering follows its command [s]; 0 for none.
    rate_max
        Fastest rate of the shaft, the mean of the rear wheels [rad/s].
    counted
        Which wheels are joints and have encoders: the ``"rear"`` ones, the ``"front"`` ones, or the shaft,
        ``"centre"``. The steering is always a joint.
    lag, acceleration_max
        How the shaft follows its command; see `Motors`.
    """

    channels: ClassVar[tuple[str, ...]] = ("steering", "wheels")  # an angle [rad], a rate [rad/s]

    wheel_radius: float = parameter(unit="m", ge=1e-4, le=10, help="radius of the wheels that are counted")
    wheelbase: float = parameter(unit="m", ge=1e-3, le=100, help="from the rear axle to the front one")
    track: float = parameter(unit="m", ge=1e-3, le=100, help="distance between left and right wheels")
    steering_max: float = parameter(unit="rad", gt=0, le=1.4, help="largest steering angle to either side")
    rate_max: float = parameter(
        unit="rad/s", gt=0, le=1e6, help="fastest that the shaft turns, the mean of the rear wheels"
    )
    counted: str = parameter(
        "rear", choices=("rear", "front", "centre"), static=True, help="which wheels are joints, and have encoders"
    )

    @property
    def joints(self) -> tuple[Joint, ...]:  # type: ignore[override]
        """The steering, and the wheels that are counted."""
        return _JOINTS[self.counted]

    @property
    def _place(self) -> int:
        return _PLACES[self.counted]

    def bind(self, at: DriveBinding) -> Callable[[], None]:
        """Move steering and wheels by a kernel."""
        lengths = self.wheelbase, self.track, self._place
        steered = self.steering_max, self.steering_rate, self.steering_lag
        rolled = self.rate_max, self._acceleration(at.rows), self.lag
        joints = at.joints, at.joint_rates, at.command
        return functools.partial(steering.ackermann_advance, *joints, *lengths, *steered, *rolled, at.dt, at.out)

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: State, draws: Draws
    ) -> tuple[Array, Array]:
        """Joints `(N, j)` [rad] and rates [rad/s] a step later; the command is steering [rad] and shaft [rad/s]."""
        out = np.empty((2, *joints.shape))
        steering.ackermann_advance(
            joints,
            rates,
            command,
            self.wheelbase,
            self.track,
            self._place,
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
        steering.ackermann_paths(
            before, after, fraction, self.wheel_radius, self.wheelbase, self.track, self._place, out
        )
        return out

    def bind_displacement(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the displacement by a kernel."""
        lengths, whole = (self.wheel_radius, self.wheelbase, self.track), np.ones((len(out), 1))
        return functools.partial(steering.ackermann_paths, before, after, whole, *lengths, self._place, out)

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        """The joints `(N, j)` after a stop at `fraction`."""
        out = np.empty(before.shape)
        steering.ackermann_stops(before, after, fraction, self.wheelbase, self.track, self._place, out)
        return out

    def travel(self, before: Array, after: Array) -> Array:
        """Bounds on the path `(N, 2)`: the body turns fastest at the largest steering angle of the step."""
        out = np.empty((len(before), 2))
        steering.ackermann_travel(before, after, self.wheel_radius, self.wheelbase, self.track, self._place, out)
        return out

    def bind_travel(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the bounds by a kernel."""
        lengths = self.wheel_radius, self.wheelbase, self.track
        return functools.partial(steering.ackermann_travel, before, after, *lengths, self._place, out)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """Steering and shaft `(N, 2)` [rad, rad/s] for `twist` `(N, 3)`; at rest it steers to the side of the turn."""
        out = np.empty((len(twist), 2))
        steering.ackermann_commands(twist, joints, self.wheel_radius, self.wheelbase, self.steering_max, out)
        return out

    def rolling_radius(self) -> Array:
        """Radii of the wheels that are counted `(N, r)` [m]."""
        radius: Any = self.wheel_radius
        return np.array(radius) if self.counted == "centre" else np.concatenate((radius, radius), axis=1)

    def contacts(self, joints: Array) -> Array:
        """Where the wheels that are counted touch the ground `(N, r, 2)` [m]; the shaft does at the base point."""
        found = np.zeros((len(joints), len(self.joints) - 1, 2))
        if self.counted != "centre":
            half = 0.5 * np.asarray(self.track)[:, 0]
            found[:, 0, 1], found[:, 1, 1] = half, -half
        if self.counted == "front":
            found[:, :, 0] = np.asarray(self.wheelbase)
        return found

    def curvature_max(self) -> Array:
        """Largest curvature `(N, 1)` [1/m]: that of the largest steering angle."""
        cos, sin = self.steering_end()
        return np.asarray(sin / cos / self.wheelbase)

    def top_speeds(self) -> Array:
        """Top speed and turning rate, and the largest change of each, `(N, 4)`."""
        fastest: Any = self.rate_max * self.wheel_radius
        change = self._acceleration(len(fastest)) * self.wheel_radius
        return np.concatenate((fastest, fastest * self.curvature_max(), change, np.full_like(fastest, np.inf)), axis=1)

    def front_wheel_angles(self, steering_angle: Array) -> Array:
        """Angles `(N, 2)` [rad] of the left and the right front wheel when the steering is at `(N, 1)` [rad]."""
        out = np.empty((len(steering_angle), 2))
        steering.ackermann_wheels(np.array(steering_angle), self.wheelbase, self.track, out)
        return out
