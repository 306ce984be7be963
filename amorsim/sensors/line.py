"""Sensors that look at the floor for lines."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.sensors.response import ring_poses, ring_size

__all__ = ["Line"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})

# Sample points in a spot of radius 1: along a spiral, so that each point stands for an equal area.
_PLACES = 32
_TURN = math.pi * (3.0 - math.sqrt(5.0))
_RADII = np.sqrt((np.arange(_PLACES) + 0.5) / _PLACES)
_SPOT = np.stack((_RADII * np.cos(_TURN * np.arange(_PLACES)), _RADII * np.sin(_TURN * np.arange(_PLACES))), axis=1)


@attrs.frozen(kw_only=True)
class Line(Sensor):
    """How much light the floor returns below each element of a row: from 0, all dark, to 1.

    The reading is the mean reflectance of the floor with its markings, over a round spot below the element. A drop
    returns nothing. The mean is taken over 32 points of the spot.

    Parameters
    ----------
    elements
        Where each element sits, in the frame of the sensor's mount. By default two, 1 cm to the left and to the right.
    spot
        Diameter [m] of the spot that an element sees.
    """

    unit: ClassVar[str] = "reflectance"

    elements: tuple[Mount, ...] = parameter(
        (Mount(y=0.01), Mount(y=-0.01)), help="where each element sits on the mount, looking down"
    )
    spot: float = parameter(0.005, unit="m", ge=0, le=10, help="diameter of what an element sees of the floor")

    def __attrs_post_init__(self) -> None:
        if not self.elements:
            raise ParameterError("elements", "expected one element at least, got none")

    def size(self, drive: Drive) -> int:
        """One value for each element."""
        return ring_size(self.elements)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Reflectances `(N, k)`, from 0 to 1."""
        origins = ring_poses(view, self.elements, aim)
        k = len(origins) // view.rows
        radius = np.repeat(np.broadcast_to(self.spot, (view.rows, 1)) / 2.0, k, axis=0)
        places = origins[:, None, :2] + radius[:, :, None] * _SPOT
        found = view.floor(places.reshape(view.rows, -1, 2)).reflectance.reshape(view.rows, k, _PLACES)
        total = np.zeros((view.rows, k))
        for i in range(_PLACES):  # in order, whatever the number of rows
            total = total + found[:, :, i]
        return total / _PLACES, _NOTHING
