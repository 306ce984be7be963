"""A finder of marks: landmarks, and robots and obstacles that carry one."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter
from amorsim.sensors.slots import table_of

__all__ = ["Fiducial"]

_COLUMNS: Mapping[str, str] = types.MappingProxyType({"range": "m", "bearing": "rad", "id": "id"})


@attrs.frozen(kw_only=True)
class Fiducial(Sensor):
    """Range [m], bearing [rad] and identity of the marks in sight, the nearest first, in a fixed number of slots.

    Marks are the landmarks of the scenario and the robots and obstacles with a ``fiducial``. Walls and bodies hide
    them. The range is to the landmark or to the carrier's base point; the bearing counts from the mount's heading. An
    empty slot reads inf, inf, -1. A mark beyond ``range_max_id`` has the identity 0. ``measured.reshape(-1, 3)`` is a
    table with a line for each slot.

    Parameters
    ----------
    slots
        Number of marks that a reading holds.
    fov
        The field of view [rad], half of it to either side.
    range_max
        Longest range at which marks are seen [m].
    range_max_id
        Longest range at which they are identified [m].
    """

    unit: ClassVar[str] = "mixed"

    slots: int = parameter(8, ge=1, le=10_000, static=True, help="how many marks a reading has room for")
    fov: float = parameter(math.pi, unit="rad", gt=0, le=2.0 * math.pi, help="the field of view")
    range_max: float = parameter(8.0, unit="m", gt=0, help="how far marks are seen")
    range_max_id: float = parameter(5.0, unit="m", ge=0, help="largest distance at which their ids can be read")

    def size(self, drive: Drive) -> int:
        """Three values for each slot."""
        return 3 * self.slots

    def columns(self) -> Mapping[str, str]:
        """Range, bearing and identity."""
        return _COLUMNS

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Range, bearing, identity of each slot `(N, 3 * slots)`; for the chain also ``slot``, ``range``, ``empty``."""
        fov: Any = self.fov
        range_max: Any = self.range_max
        seen = view.landmarks(self.slots, range_max, 0.5 * fov)
        values = np.empty((view.rows, self.slots, 3))
        values[:, :, 0] = seen.range
        values[:, :, 1] = seen.bearing
        is_far = (seen.range > self.range_max_id) & (seen.id > 0)
        values[:, :, 2] = np.where(is_far, 0, seen.id)
        return table_of(values, 0, (np.inf, np.inf, -1.0))
