"""A robot's position from satellites or a tracking system."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter
from amorsim.kernels.sensing import readings

__all__ = ["Gps"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
_PLACE: Mapping[str, str] = types.MappingProxyType({"x": "m", "y": "m"})
_POSE: Mapping[str, str] = types.MappingProxyType({"x": "m", "y": "m", "heading": "rad"})


@attrs.frozen(kw_only=True)
class Gps(Sensor):
    """The place of the mount in the world, x and y [m]; with ``heading``, its heading [rad] in [-pi, pi] too.

    The reading is the position of the antenna (the mount), not of the robot's base point. As for every sensor,
    ``rate`` sets how often there is a fix and ``latency`` how late it arrives. Put a ``bias_instability`` into the
    chain for slow drift and a ``dropout`` for lost fixes.

    Parameters
    ----------
    heading
        Whether the heading is measured too, as with two antennas or a camera above the field.
    """

    unit: ClassVar[str] = "m"

    heading: bool = parameter(False, static=True, help="whether the heading is measured as well")

    def size(self, drive: Drive) -> int:
        """Two values, or three."""
        return len(self.columns())

    def columns(self) -> Mapping[str, str]:
        """The coordinates, and the heading if it is measured."""
        return _POSE if self.heading else _PLACE

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Coordinates `(N, 2)` [m], with the heading [rad] `(N, 3)`."""
        pose = view.pose
        if not self.heading:
            return pose[:, :2].copy(), _NOTHING
        heading = np.empty((len(pose), 1))
        readings.wrap_headings(pose, heading)
        return np.concatenate((pose[:, :2], heading), axis=1), _NOTHING
