"""A motion: an obstacle that goes to and fro."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Patrol"]


@attrs.frozen(kw_only=True)
class Patrol(am.Motion):
    """Moves along its own x axis, and turns back where something stops it.

    Parameters
    ----------
    speed
        Its speed [m/s].
    """

    speed: float = am.parameter(0.3, unit="m/s", ge=0, help="its speed")

    def start(self, context: am.Context) -> am.State:
        """The direction of each row `(N, 1)`: 1 or -1."""
        return {"direction": np.ones((context.rows, 1))}

    def propose(self, view: am.View, dt: float, state: am.State, draws: am.Draws) -> npt.NDArray[np.float64]:
        """The displacement `(N, 3)` of this step; `view.free` is the part of the last one that was possible."""
        state["direction"] = np.where(view.free < 1.0, -state["direction"], state["direction"])
        return np.concatenate((state["direction"] * self.speed * dt, np.zeros((view.rows, 2))), axis=1)
