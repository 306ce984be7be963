"""A sensor that measures the distance straight ahead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Feeler"]

Array = npt.NDArray[np.float64]
_AHEAD = np.zeros((1, 1))  # bearing of the one beam [rad]


@attrs.frozen(kw_only=True)
class Feeler(am.Sensor):
    """The range [m] to a wall or body straight ahead; inf where nothing is within `range_max`.

    Parameters
    ----------
    range_max
        Longest range that is seen [m].
    """

    unit: ClassVar[str] = "m"

    range_max: float = am.parameter(2.0, unit="m", gt=0, help="longest range that is seen")

    def size(self, drive: am.Drive) -> int:
        """One value."""
        return 1

    def sense(self, view: am.View, aim: am.Aim, state: am.State, draws: am.Draws) -> tuple[Array, Mapping[str, Array]]:
        """Ranges `(N, 1)` [m], and nothing for the noise chain."""
        limits: Any = self.range_max  # over rows: (N, 1)
        return view.cast(view.pose, _AHEAD, limits), {}
