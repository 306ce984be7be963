"""Sensors that look down for drops."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.sensors.response import ring_poses, ring_size

__all__ = ["Cliff"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})


@attrs.frozen(kw_only=True)
class Cliff(Sensor):
    """Whether the floor drops below each element: 1 where it does, 0 where it does not.

    Parameters
    ----------
    elements
        Where each element sits, in the frame of the sensor's mount. One at the mount by default.
    depth_min
        Shallower drops [m] are not reported.
    """

    unit: ClassVar[str] = "drop"

    elements: tuple[Mount, ...] = parameter((Mount(),), help="where each element sits on the mount, looking down")
    depth_min: float = parameter(0.03, unit="m", gt=0, help="shallower drops are not reported")

    def __attrs_post_init__(self) -> None:
        if not self.elements:
            raise ParameterError("elements", "expected one element at least, got none")

    def size(self, drive: Drive) -> int:
        """One value for each element."""
        return ring_size(self.elements)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """1 where the floor drops, else 0 `(N, k)`."""
        origins = ring_poses(view, self.elements, aim)
        depth = view.floor(origins[:, :2].reshape(view.rows, -1, 2)).depth
        return (depth >= self.depth_min).astype(np.float64), _NOTHING
