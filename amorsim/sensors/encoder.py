"""The angles that joints have turned by, in counts."""

from __future__ import annotations

import functools
import math
import types
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, SensorBinding, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.kernels.sensing import readings

__all__ = ["Encoder"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
_TURN = 2.0 * math.pi


@attrs.frozen(kw_only=True)
class Encoder(Sensor):
    """The cumulative count of every joint of the drive, in the order of the drive's joints.

    The ideal count is not an integer; a ``quantize`` of step 1 in the chain rounds it. White noise on a count
    does not accumulate, because each reading is a new look at the same wheel. ``gaussian`` with ``per =
    "increment"`` accumulates.

    Parameters
    ----------
    counts_per_revolution
        Counts in a full turn of a joint, all edges and the gear included: one number for all joints, or one for each,
        in the order of the drive's joints.
    """

    unit: ClassVar[str] = "count"

    counts_per_revolution: float | tuple[float, ...] = parameter(
        gt=0, help="counts in a full turn of a joint; a list: of each of the drive's joints"
    )

    def size(self, drive: Drive) -> int:
        """One value for each joint.

        Raises
        ------
        ParameterError
            If the number of counts is not the number of joints.
        """
        given = np.shape(self.counts_per_revolution)[-1:]  # (j,) as made, (N, j) over rows
        joints = drive.joints
        if given and given[0] not in (1, len(joints)):
            names = ", ".join(joint.name for joint in joints)
            raise ParameterError(
                "counts_per_revolution",
                f"expected one number, or one for each of the drive's {len(joints)} joints ({names}), got {given[0]}",
            )
        return len(joints)

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Count the joints of the engine's own array."""
        counts: Any = self.counts_per_revolution
        return functools.partial(readings.count_turns, at.joints, counts, at.out)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Counts `(N, j)` since all joints stood at 0."""
        counts: Any = self.counts_per_revolution
        return view.joints / _TURN * counts, _NOTHING

    def angles(self, values: Array) -> Array:
        """Joint angles `(N, j)` [rad] for counts `(N, j)`: the inverse of `sense`."""
        counts: Any = self.counts_per_revolution
        result: Array = values / counts * _TURN
        return result
