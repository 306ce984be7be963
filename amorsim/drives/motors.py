"""What drives with motors share: how a motor follows the rate it is told."""

from __future__ import annotations

import functools
from typing import Any

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Drive, parameter

__all__ = ["Motors", "over_rows", "own_first"]

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

    lag: float = parameter(0.0, unit="s", ge=0, help="time constant with which a wheel's rate follows its command")
    acceleration_max: float | None = parameter(
        None, unit="rad/s^2", gt=0, help="most that a wheel's rate changes in a second; none for no limit"
    )

    def _acceleration(self, rows: int) -> Array:
        """The limit on acceleration over rows `(N, 1)`, inf for none."""
        return over_rows(self.acceleration_max, rows)
