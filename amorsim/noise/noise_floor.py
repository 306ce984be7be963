"""A noise floor: small values are lost in it."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter

__all__ = ["NoiseFloor"]


@attrs.frozen(kw_only=True)
class NoiseFloor(Noise):
    """Replaces each value from 0 up to a level by a draw that is uniform from 0 up to that level.

    Other values stay as they are. The Khepera Simulator 2.0 of O. Michel (1995) does this to its infrared sensors, with
    a level of 7 counts.

    Parameters
    ----------
    level
        Level below which values are replaced, in the sensor's unit; 0 for none.
    """

    level: float = parameter(unit="sensor", ge=0, help="below which values drown")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The values `(N, k)`, those below the level replaced."""
        drowned = (values >= 0.0) & (values < self.level)
        return np.where(drowned, draws.uniform(values.shape[1]) * self.level, values)
