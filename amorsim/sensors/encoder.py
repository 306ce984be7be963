"""How far the joints have turned, in counts."""

from __future__ import annotations

import math
import types
from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Aim, Draws, Drive, Sensor, State, View, parameter

__all__ = ["Encoder"]

Array = npt.NDArray[np.float64]
_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
_TURN = 2.0 * math.pi


@attrs.frozen(kw_only=True)
class Encoder(Sensor):
    """The cumulative count of every joint of the drive, in the order of the drive's joints.

    The ideal count is no whole number; a chain with ``quantize`` of step 1 makes it one. White noise on a
    count does not accumulate, for each reading is a new look at the same wheel; ``gaussian`` with ``per =
    "increment"`` does.

    Parameters
    ----------
    counts_per_revolution
        Counts in a full turn of a joint, all edges and the gear included.
    """

    unit: ClassVar[str] = "count"

    counts_per_revolution: float = parameter(gt=0, help="counts in a full turn of a joint")

    def size(self, drive: Drive) -> int:
        """One value for each joint."""
        return len(drive.joints)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Counts `(N, j)` since all joints stood at 0."""
        return view.joints / _TURN * self.counts_per_revolution, _NOTHING

    def angles(self, values: Array) -> Array:
        """Joints `(N, j)` [rad] that counts `(N, j)` stand for: the inverse of `sense`."""
        return values / self.counts_per_revolution * _TURN
