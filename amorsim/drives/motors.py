"""What drives with motors share: how a motor follows the rate it is told; a steering its angle; and paths that wind."""

from __future__ import annotations

import functools
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Drive, parameter
from amorsim.core.poses import logarithm
from amorsim.kernels.kinematics import poses

__all__ = ["Motors", "Steered", "Winding", "over_rows", "own_first"]

Array = npt.NDArray[np.float64]


@functools.cache
def _no_limit(rows: int) -> Array:
    unlimited = np.full((rows, 1), np.inf)
    unlimited.flags.writeable = False  # as the fields are, or the kernel would be compiled twice
    return unlimited


def over_rows(limit: Any, rows: int) -> Array:
    """A limit over rows `(N, 1)`: inf where a component has none."""
    return _no_limit(rows) if limit is None else limit


def own_first(_: type, fields: list[Any]) -> list[Any]:
    """A class's own fields before those it inherits, for forms and pages: attrs' hook `field_transformer`."""
    return sorted(fields, key=lambda field: field.inherited)


@attrs.frozen(kw_only=True)
class Motors(Drive):
    """A drive whose motors have a lag and a limit on acceleration: the base of all that come with amorsim.

    The rate of a motor follows what it is told as ``rate' = (wanted - rate) / lag``, changing by no more than
    `acceleration_max`: a ramp, then an exponential, solved in closed form. So neither angles nor rates depend on how
    finely time is cut.

    Parameters
    ----------
    lag
        Time constant of each motor [s]; 0 for none.
    acceleration_max
        Most that a wheel's rate changes in a second [rad/s^2]; none for no limit.
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
    """A drive whose path in a step is no single arc, for its wheels steer meanwhile: it tells `displacement` itself."""

    def twist(self, before: Array, after: Array) -> Array:
        """The mean motion `(N, 3)`: that of the one arc which leads to the same place."""
        return logarithm(self.displacement(before, after, np.ones((len(before), 1))))


@attrs.frozen(kw_only=True, field_transformer=own_first)
class Steered(Winding):
    """A drive that is steered by an angle, the first of its joints, with a `wheelbase` and a `steering_max`.

    Parameters
    ----------
    steering_rate
        How fast the steering moves at most [rad/s].
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
