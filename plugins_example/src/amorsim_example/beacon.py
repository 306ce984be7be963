"""A sensor: which way a beacon is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Beacon"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Beacon(am.Sensor):
    """The bearing [rad] of a light beacon from where the sensor looks, anticlockwise, in [-pi, pi].

    Reads inf, "nothing returns", where a wall or another body hides the beacon, or where it is too far away.

    Parameters
    ----------
    x, y
        Where the beacon stands in the world [m].
    range_max
        Farthest that the beacon is seen [m].
    """

    unit: ClassVar[str] = "rad"

    x: float = am.parameter(unit="m", frame="world", help="where the beacon stands, to the right in the world")
    y: float = am.parameter(unit="m", frame="world", help="where the beacon stands, up in the world")
    range_max: float = am.parameter(20.0, unit="m", gt=0, help="farthest that the beacon is seen")

    def size(self, drive: am.Drive) -> int:
        """One value."""
        return 1

    def sense(self, view: am.View, aim: am.Aim, state: am.State, draws: am.Draws) -> tuple[Array, Mapping[str, Array]]:
        """Bearings `(N, 1)` [rad], and for the noise chain the `distance` `(N, 1)` [m] to the beacon."""
        dx = self.x - view.pose[:, 0:1]
        dy = self.y - view.pose[:, 1:2]
        distance = np.sqrt(dx * dx + dy * dy)
        bearing = am.wrap_angle(np.arctan2(dy, dx) - view.pose[:, 2:3])
        # A ray towards the beacon and no longer than that: what it meets stands between.
        hidden = np.isfinite(view.cast(view.pose, bearing, distance))
        return np.where(hidden | (distance > self.range_max), np.inf, bearing), {"distance": distance}
