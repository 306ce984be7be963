"""The heading of a robot in the world."""

from __future__ import annotations

import functools
import types
from collections.abc import Callable, Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Draws, Drive, Sensor, SensorBinding, State, View
from amorsim.kernels.sensing import readings

__all__ = ["Compass"]

_NOTHING: Mapping[str, Array] = types.MappingProxyType({})


@attrs.frozen(kw_only=True)
class Compass(Sensor):
    """The heading of the mount in the world [rad], anticlockwise from the world's x axis, in [-pi, pi].

    The measured heading may lie outside [-pi, pi]: the noise chain works on numbers, not on directions. Wrap
    the *difference* of two headings (`amorsim.core.poses.wrap_angle`). Near pi this is necessary even without
    noise.
    """

    unit: ClassVar[str] = "rad"

    def size(self, drive: Drive) -> int:
        """One value."""
        return 1

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Sense by a kernel."""
        return functools.partial(readings.wrap_headings, at.pose, at.out)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """Headings `(N, 1)` [rad] in [-pi, pi]."""
        out = np.empty((len(view.pose), 1))
        readings.wrap_headings(view.pose, out)
        return out, _NOTHING
