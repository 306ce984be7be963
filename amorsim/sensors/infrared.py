"""A ring of infrared proximity sensors, which measure how much of their own light returns."""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, SensorBinding, State, View, parameter
from amorsim.core.execution.workers import in_turn
from amorsim.core.parameters import ParameterError
from amorsim.kernels.sensing import readings
from amorsim.sensors.response import check_table, ring_poses

__all__ = ["Infrared"]

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
        origins = ring_poses(view, self.elements, aim)
        k = len(origins) // view.rows
        counts = np.empty((view.rows, k))
        readings.add_responses(view.cast(origins, *self._rays(k)), *self._tables(), self.saturation, counts)
        return counts, _NOTHING

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Look along the rays from the engine's own arrays, unless something bends them."""
        if at.aim is not None:
            return super().bind(at)
        ring: Any = self.elements
        origins, ranges = np.empty((ring.x.size, 3)), np.empty((ring.x.size, 3))
        place = functools.partial(readings.place_ring, at.pose, ring.x, ring.y, ring.heading, origins)
        cast = at.view.bind_cast(origins, *self._rays(ring.x.size // at.rows), ranges)
        add = functools.partial(readings.add_responses, ranges, *self._tables(), self.saturation, at.out)
        return in_turn([place, cast, add])

    def _rays(self, elements: int) -> tuple[Array, Array]:
        """Bearings of each element's rays `(N * k, 3)` [rad], and how far the rows look `(N, 1)` [m]."""
        spread: Any = self.spread
        fan = np.repeat(spread * np.array([[-1.0, 0.0, 1.0]]), elements, axis=0)
        return fan, np.maximum(np.asarray(self.distances)[:, -1:], np.asarray(self.side_distances)[:, -1:])

    def _tables(self) -> tuple[Any, Any, Any, Any]:
        return self.distances, self.values, self.side_distances, self.side_values
