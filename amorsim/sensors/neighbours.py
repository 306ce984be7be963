"""What the robots nearby tell of themselves: where they are, how fast they go, and how large they are."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter
from amorsim.kernels.kinematics.poses import directions
from amorsim.sensors.tables import table_of

__all__ = ["Neighbours"]

Array = npt.NDArray[np.float64]
_COLUMNS: Mapping[str, str] = types.MappingProxyType(
    {"range": "m", "x": "m", "y": "m", "vx": "m/s", "vy": "m/s", "radius": "m"}
)


@attrs.frozen(kw_only=True)
class Neighbours(Sensor):
    """The other robots within reach of its radio, the nearest first, in a fixed number of slots.

    For each: range [m] from the sensor, place x (ahead) and y (to the left) [m] and velocity over ground [m/s], both
    in the frame of the mount, and the radius [m] of the circle around its base point that holds its footprint. An empty
    slot reads inf for range and place, and 0 for the rest. ``measured.reshape(-1, 6)`` is a table with a line for each
    slot. Walls do not matter, and obstacles tell nothing.

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
        rows = view.rows
        range_max: Any = self.range_max
        values = np.zeros((rows, self.slots, 6))
        values[:, :, :3] = np.inf
        near = view.neighbours(range_max)
        row, body = near.row, near.body
        heard = near.is_robot[body] & (near.owner[body] == body)
        row, body = row[heard], body[heard]
        off = near.poses[body, :2] - view.body_pose[row, :2]
        square = off[:, 0] ** 2 + off[:, 1] ** 2
        heard = square <= range_max[row, 0] ** 2
        row, body, square = row[heard], body[heard], square[heard]
        order = np.lexsort((body, square, row))
        row, body = row[order], body[order]
        place = np.arange(len(row)) - np.searchsorted(row, row)  # among those of its row
        first = place < self.slots
        row, body, place = row[first], body[first], place[first]
        pose = view.pose
        own_c, own_s = _directions(pose[:, 2])
        c, s = _directions(near.poses[body, 2])
        twist = near.twists[body]
        moved = np.stack((c * twist[:, 0] - s * twist[:, 1], s * twist[:, 0] + c * twist[:, 1]), axis=1)
        off = near.poses[body, :2] - pose[row, :2]
        values[row, place, 0] = np.sqrt(off[:, 0] ** 2 + off[:, 1] ** 2)
        for column, vector in ((1, off), (3, moved)):
            values[row, place, column] = own_c[row] * vector[:, 0] + own_s[row] * vector[:, 1]
            values[row, place, column + 1] = own_c[row] * vector[:, 1] - own_s[row] * vector[:, 0]
        values[row, place, 5] = near.reach[body]
        return table_of(values, 0, (np.inf, np.inf, np.inf, 0.0, 0.0, 0.0))


def _directions(headings: Array) -> tuple[Array, Array]:
    """Cosine and sine of each heading, to the same bits for any number of them."""
    column = np.ascontiguousarray(headings)[:, None]
    cosine, sine = np.empty_like(column), np.empty_like(column)
    directions(column, cosine, sine)
    return cosine[:, 0], sine[:, 0]
