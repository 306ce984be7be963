"""A ring of infrared proximity sensors: how much of their own light comes back."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.sensors.response import check_table, respond, ring_poses

__all__ = ["Infrared"]

Array = npt.NDArray[np.float64]
_NOTHING: Mapping[str, Array] = types.MappingProxyType({})


@attrs.frozen(kw_only=True)
class Infrared(Sensor):
    """How much of its own infrared light comes back to each element of a ring, in counts; 0 where nothing does.

    An element looks along three rays: its axis and one to either side. The table of ``distances`` and ``values``
    gives the response along the axis, ``side_distances`` and ``side_values`` that of the side rays. The three are
    added and limited to ``saturation``. Tables are interpolated linearly. Nearer than the first point the first value
    holds; beyond the last point the response is 0.

    The defaults are the Khepera's, from the Khepera Simulator 2.0 of O. Michel (1995): the points at which it probes
    its map, 12 to 58 mm ahead and 5.7 to 43.9 mm to the sides. Its side points lie on a bent line, 45 to 24 degrees
    off the axis; here they lie at the same distances on a straight ray. Its noise, ten per cent either way, belongs
    in the chain.

    Parameters
    ----------
    elements
        Where each element sits and looks, in the frame of the ring's mount. One straight ahead by default.
    distances, values
        Table of the ray along the axis: increasing distances [m], and the response [counts] at each.
    side_distances, side_values
        Table of each of the two side rays.
    spread
        Angle between the axis and the side rays [rad].
    saturation
        Largest reading [counts].
    """

    unit: ClassVar[str] = "count"

    elements: tuple[Mount, ...] = parameter((Mount(),), help="where each element sits on the mount, and looks")
    distances: tuple[float, ...] = parameter(
        (0.012, 0.020, 0.032, 0.044, 0.058), unit="m", ge=0, help="distances ahead, growing"
    )
    values: tuple[float, ...] = parameter(
        (900.0, 750.0, 650.0, 160.0, 40.0), unit="count", ge=0, help="what comes back from each"
    )
    side_distances: tuple[float, ...] = parameter(
        (0.0057, 0.0113, 0.0189, 0.0295, 0.0439), unit="m", ge=0, help="distances along the two rays beside, growing"
    )
    side_values: tuple[float, ...] = parameter(
        (1023.0, 800.0, 600.0, 400.0, 60.0), unit="count", ge=0, help="what comes back from each"
    )
    spread: float = parameter(
        math.pi / 6.0, unit="rad", ge=0, le=math.pi / 2.0, help="between the axis and the rays next to it"
    )
    saturation: float = parameter(1023.0, unit="count", gt=0, help="which no reading passes")

    def __attrs_post_init__(self) -> None:
        if not self.elements:
            raise ParameterError("elements", "expected one element at least, got none")
        check_table(self.distances, self.values, ("distances", "values"))
        check_table(self.side_distances, self.side_values, ("side_distances", "side_values"))

    def size(self, drive: Drive) -> int:
        """One value for each element."""
        return int(self.bearings().shape[1])

    def bearings(self) -> Array:
        """Directions [rad] `(N, k)` of the elements' axes, from the mount's heading."""
        elements: Any = self.elements
        if isinstance(elements, Mount):  # over rows: a table of arrays
            return np.asarray(elements.heading)
        return np.array([[element.heading for element in elements]])

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Counts `(N, k)` from 0 to the saturation."""
        ahead, beside = np.asarray(self.distances), np.asarray(self.side_distances)
        spread: Any = self.spread
        origins = ring_poses(view, self.elements, aim)
        k = len(origins) // view.rows
        fan = np.repeat(spread * np.array([[-1.0, 0.0, 1.0]]), k, axis=0)
        reach = np.maximum(ahead[:, -1:], beside[:, -1:])
        ranges = view.cast(origins, fan, reach).reshape(view.rows, k, 3)
        answer = respond(ranges[:, :, 1], ahead, np.asarray(self.values))
        for side in (0, 2):
            answer = answer + respond(ranges[:, :, side], beside, np.asarray(self.side_values))
        return np.minimum(answer, self.saturation), _NOTHING
