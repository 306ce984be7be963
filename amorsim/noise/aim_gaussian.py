"""Beams that do not look quite where they should."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Aim, Context, Draws, Noise, State, parameter

__all__ = ["AimGaussian"]


@attrs.frozen(kw_only=True)
class AimGaussian(Noise):
    """Bends each beam by a normal angle of its own, drawn again in every sample; leaves the values alone.

    Parameters
    ----------
    std
        Standard deviation of a beam's bearing [rad].
    """

    std: float = parameter(unit="rad", ge=0, help="standard deviation of each beam's bearing")

    def start(self, context: Context) -> State:
        """The bends of the last sample `(N, k)` [rad], one for each beam."""
        return {"bend": np.zeros((context.rows, context.size))}

    def aim(self, aim: Aim, elapsed: Array, state: State, draws: Draws) -> Aim:
        """The aim with the angles [rad] of this sample `(N, k)` added."""
        bend = draws.normal(state["bend"].shape[1])
        bend *= self.std
        state["bend"] = bend
        return aim._replace(bearing=bend if aim.bearing is None else aim.bearing + bend)
