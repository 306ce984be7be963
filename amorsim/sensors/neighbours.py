"""Poses, speeds and sizes that nearby robots report of themselves."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter
from amorsim.kernels.sensing.heard import Senders, hear_nearest
from amorsim.sensors.slots import table_of

__all__ = ["Neighbours"]

_COLUMNS: Mapping[str, str] = types.MappingProxyType(
    {"range": "m", "x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "radius": "m"}
)


@attrs.frozen(kw_only=True)
class Neighbours(Sensor):
    """The other robots within reach of its radio, the nearest first, in a fixed number of slots.

    For each: range [m] from the sensor, place x (ahead) and y (to the left) [m] and velocity over ground [m/s], both
    in the frame of the mount, and the radius [m] of the circle around its base point that holds its footprint. An empty
    slot reads inf for range and place, and 0 for the rest. ``measured.reshape(-1, 6)`` is a table with a line for each
    slot. Walls do not matter, and obstacles report nothing.

    Parameters
    ----------
    slots
        Number of robots that a reading holds.
    range_max
        Longest distance between base points over which robots hear one another [m].
    """

    unit: ClassVar[str] = "mixed"

    slots: int = parameter(10, ge=1, le=1000, static=True, help="how many robots a reading has room for")
    range_max: float = parameter(5.0, unit="m", gt=0, help="how far robots hear one another")

    def size(self, drive: Drive) -> int:
        """Six values for each slot."""
        return 6 * self.slots

    def columns(self) -> Mapping[str, str]:
        """Range, place, velocity and radius."""
        return _COLUMNS

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """The table `(N, 6 * slots)`; for the chain also ``slot``, ``range``, ``empty``."""
        limits: Any = self.range_max
        near = view.neighbours(limits)
        sends = near.is_robot & (near.owner == np.arange(len(near.owner)))
        senders = Senders(near.own, near.first, near.body, near.poses, near.twists, near.reach, sends)
        values = np.empty((view.rows, self.slots, 6))
        hear_nearest(senders, view.pose, limits, values)
        return table_of(values, 0, (np.inf, np.inf, np.inf, 0.0, 0.0, 0.0))
