"""How fast a robot turns."""

from __future__ import annotations

import functools
import types
from collections.abc import Callable, Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, SensorBinding, State, View

__all__ = ["Gyro"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})


@attrs.frozen(kw_only=True)
class Gyro(Sensor):
    """The rate of turn [rad/s], anticlockwise, as the mean over the last step; 0 before the first.

    Model the device's range with a ``saturate`` in the chain, and the drift of its zero with a ``gaussian``
    with ``per = "increment"``.
    """

    unit: ClassVar[str] = "rad/s"

    def size(self, drive: Drive) -> int:
        """One value."""
        return 1

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Copy the rates of turn."""
        return functools.partial(np.copyto, at.out, at.twist[:, 2:])

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Rates of turn `(N, 1)` [rad/s]."""
        return view.twist[:, 2:].copy(), _NOTHING
