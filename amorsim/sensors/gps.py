"""Where a robot is, as satellites or a tracking system tell it."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter
from amorsim.kernels.sensing import readings

__all__ = ["Gps"]

Array = npt.NDArray[np.float64]
_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
_PLACE: Mapping[str, str] = types.MappingProxyType({"x": "m", "y": "m"})
_POSE: Mapping[str, str] = types.MappingProxyType({"x": "m", "y": "m", "heading": "rad"})


@attrs.frozen(kw_only=True)
class Gps(Sensor):
    """The place of the mount in the world, x and y [m]; with ``heading``, its heading [rad] in [-pi, pi] too.

    The mount is the antenna, not the robot's base point. How often there is a fix and how late it comes are the
    ``rate`` and ``latency`` that every sensor has; slow drift is a ``bias_instability`` in the chain, a lost fix a
    ``dropout``.

    Parameters
    ----------
    heading
        Whether the heading is told as well, as by two antennas or by a camera above the field.
    """

    unit: ClassVar[str] = "m"

    heading: bool = parameter(False, static=True, help="whether the heading is told as well")

    def size(self, drive: Drive) -> int:
        """Two values, or three."""
        return len(self.columns())

    def columns(self) -> Mapping[str, str]:
        """The coordinates, and the heading if it is told."""
        return _POSE if self.heading else _PLACE

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Coordinates `(N, 2)` [m], with the heading [rad] `(N, 3)`."""
        pose = view.pose
        if not self.heading:
            return pose[:, :2].copy(), _NOTHING
        heading = np.empty((len(pose), 1))
        readings.wrap_headings(pose, heading)
        return np.concatenate((pose[:, :2], heading), axis=1), _NOTHING
