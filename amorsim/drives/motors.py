"""Shared by drives with motors: how a motor follows its rate and a steering its angle, and paths that are not arcs."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Drive, parameter
from amorsim.core.execution.workers import in_turn
from amorsim.core.parameters import own_first
from amorsim.core.poses import logarithm
from amorsim.kernels.kinematics import poses

__all__ = ["Motors", "Steered", "Winding", "over_rows"]


@functools.cache
def _no_limit(rows: int) -> Array:
    unlimited = np.full((rows, 1), np.inf)
    unlimited.flags.writeable = False  # like the fields; otherwise numba would compile the kernel twice
    return unlimited


def over_rows(limit: Any, rows: int) -> Array:
    """A limit over rows `(N, 1)`: inf where a component has none."""
    return _no_limit(rows) if limit is None else limit


@attrs.frozen(kw_only=True)
class Motors(Drive):
    """A drive whose motors have a lag and a limit on acceleration: the base of all that come with amorsim.

    The rate of a motor follows its command by ``rate' = (wanted - rate) / lag``, limited by `acceleration_max`: a
    ramp, then an exponential, solved in closed form. Neither angles nor rates depend on the length of the steps.

    Parameters
    ----------
    lag
        Time constant of each motor [s]; 0 for none.
    acceleration_max
        Largest change of a wheel's rate per second [rad/s^2]; none for no limit.
    """

    lag: float = parameter(
        0.0, unit="s", ge=0, le=1e4, help="time constant with which a wheel's rate follows its command"
    )
    acceleration_max: float | None = parameter(
        None, unit="rad/s^2", gt=0, le=1e9, help="most that a wheel's rate changes in a second; none for no limit"
    )

    def _acceleration(self, rows: int) -> Array:
        """The limit on acceleration over rows `(N, 1)`, inf for none."""
        return over_rows(self.acceleration_max, rows)


class Winding(Motors):
    """A drive whose path in a step is not a single arc, because its wheels steer; subclasses give `displacement`."""

    def twist(self, before: Array, after: Array) -> Array:
        """The mean motion `(N, 3)`: that of the single arc to the same pose."""
        return logarithm(self.displacement(before, after, np.ones((len(before), 1))))

    def bind_twist(self, before: Array, after: Array, out: Array) -> Callable[[], None]:
        """Compute the mean motion from the displacement."""
        moved = np.empty_like(out)
        displace = self.bind_displacement(before, after, moved)
        return in_turn([displace, functools.partial(poses.logarithm, moved, out)])


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Steered(Winding):
    """A drive that is steered by an angle, the first of its joints, with a `wheelbase` and a `steering_max`.

    Parameters
    ----------
    steering_rate
        Fastest rate of the steering [rad/s].
    steering_lag
        Time constant with which the steering follows its command [s]; 0 for none.
    """

    steering_rate: float = parameter(unit="rad/s", gt=0, le=1e6, help="how fast the steering moves at most")
    steering_lag: float = parameter(
        0.0, unit="s", ge=0, le=1e4, help="time constant with which the steering follows its command"
    )

    def steering_end(self) -> tuple[Array, Array]:
        """Cosine and sine `(N, 1)` of the largest steering angle."""
        angle = np.array(self.steering_max)  # type: ignore[attr-defined]  # a field of each drive, with its own bounds
        cos, sin = np.empty_like(angle), np.empty_like(angle)
        poses.directions(angle, cos, sin)
        return cos, sin
