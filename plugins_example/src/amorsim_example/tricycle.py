"""A drive: three wheels, of which the front one is steered and driven."""

from __future__ import annotations

from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Tricycle"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Tricycle(am.Drive):
    """A front wheel that is steered and driven, and two rear wheels that follow, as under many a fork lift.

    The base point is the middle of the rear axle. With the steering at an angle s, a metre that the front wheel rolls
    takes the base cos(s) metres forward and turns it by sin(s) / wheelbase: an arc of a circle of radius
    wheelbase / tan(s). In a step in which the steering moves, s is the middle of its way.

    Parameters
    ----------
    wheel_radius
        Radius of the front wheel [m].
    wheelbase
        From the rear axle to the front wheel [m].
    steering_max
        Largest steering angle to either side [rad]; at a right angle the base turns in place.
    steering_rate
        How fast the steering moves [rad/s].
    rate_max
        Fastest that the front wheel rolls [rad/s].
    """

    joints: ClassVar[tuple[am.Joint, ...]] = (
        am.Joint(name="steering", rolls=False),
        am.Joint(name="front_wheel"),
    )
    channels: ClassVar[tuple[str, ...]] = ("steering", "front_wheel")  # an angle [rad], a rate [rad/s]

    wheel_radius: float = am.parameter(unit="m", gt=0, help="radius of the front wheel")
    wheelbase: float = am.parameter(unit="m", gt=0, help="from the rear axle to the front wheel")
    steering_max: float = am.parameter(
        np.pi / 2, unit="rad", gt=0, le=np.pi / 2, help="largest steering angle to either side"
    )
    steering_rate: float = am.parameter(2.0, unit="rad/s", gt=0, help="how fast the steering moves")
    rate_max: float = am.parameter(unit="rad/s", gt=0, help="fastest that the front wheel rolls")

    def advance(
        self, joints: Array, rates: Array, command: Array, dt: float, state: am.State, draws: am.Draws
    ) -> tuple[Array, Array]:
        """Steering and front wheel `(N, 2)` [rad] and their rates [rad/s] a step later, within their limits."""
        wanted = np.clip(command[:, 0:1], -self.steering_max, self.steering_max)
        most = self.steering_rate * dt
        steering = np.clip(wanted, joints[:, 0:1] - most, joints[:, 0:1] + most)
        # The wheel waits for the steering, or the robot would set off in the direction of a moment ago.
        rate = np.where(steering == wanted, np.clip(command[:, 1:2], -self.rate_max, self.rate_max), 0.0)
        after = np.concatenate((steering, joints[:, 1:2] + rate * dt), axis=1)
        return after, (after - joints) / dt

    def twist(self, before: Array, after: Array) -> Array:
        """Motion of the body (forward [m], 0, turn [rad]) `(N, 3)` as the joints go from `before` to `after`.

        `Drive.displacement` follows it in closed form: the exponential of a constant twist is an arc.
        """
        steering = 0.5 * (before[:, 0:1] + after[:, 0:1])
        way = (after[:, 1:2] - before[:, 1:2]) * self.wheel_radius
        forward, turn = way * np.cos(steering), way * np.sin(steering) / self.wheelbase
        return np.concatenate((forward, np.zeros_like(way), turn), axis=1)

    def between(self, before: Array, after: Array, fraction: Array) -> Array:
        """The joints `(N, 2)` after a stop: a wall stops the wheel, but not the steering, which gets where it went.

        So the middle of its way, and with it the arc, is that of the whole step.
        """
        wheel = before[:, 1:2] + (after[:, 1:2] - before[:, 1:2]) * fraction
        return np.concatenate((after[:, 0:1], wheel), axis=1)

    def command_for(self, twist: Array, joints: Array) -> Array:
        """The command `(N, 2)` [rad, rad/s] for `twist` `(N, 3)` [m/s, m/s, rad/s], less its part to the left.

        At rest the steering stays. Where it cannot go as far as it should, it goes to its end, and the wheel at the
        rate that brings its velocity nearest to the wanted one.
        """
        ahead, aside = twist[:, 0:1], twist[:, 2:3] * self.wheelbase  # velocity of the front wheel
        backward = ahead < 0.0
        wanted = np.where(backward, np.arctan2(-aside, -ahead), np.arctan2(aside, ahead))
        steering = np.clip(wanted, -self.steering_max, self.steering_max)
        speed = np.sqrt(ahead * ahead + aside * aside) * np.cos(wanted - steering)
        steering = np.where(speed == 0.0, joints[:, 0:1], steering)
        return np.concatenate((steering, np.where(backward, -speed, speed) / self.wheel_radius), axis=1)

    def rolling_radius(self) -> Array:
        """Radius of the front wheel `(N, 1)` [m]."""
        return np.asarray(self.wheel_radius)
