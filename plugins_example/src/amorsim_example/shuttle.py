"""A motion: an obstacle that goes to and fro."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Shuttle"]


@attrs.frozen(kw_only=True)
class Shuttle(am.Motion):
    """Moves along its own x axis, and the other way when something stops it or it has gone far enough.

    Parameters
    ----------
    speed
        Its speed [m/s].
    distance
        From where it starts to where it turns back [m].
    """

    speed: float = am.parameter(0.3, unit="m/s", ge=0, help="its speed")
    distance: float = am.parameter(2.0, unit="m", gt=0, help="from where it starts to where it turns back")

    def start(self, context: am.Context) -> am.State:
        """Each row's direction, 1 or -1, the displacement it proposed last, and where it is along its way [m]."""
        return {
            "direction": np.ones((context.rows, 1)),
            "proposed": np.zeros((context.rows, 1)),
            "place": np.zeros((context.rows, 1)),
        }

    def propose(self, view: am.View, dt: float, state: am.State, draws: am.Draws) -> npt.NDArray[np.float64]:
        """The displacement `(N, 3)` of this step; `view.free` is the part of the last one that was possible."""
        place = state["place"] + state["proposed"] * view.free
        was_stopped = view.free < 1.0
        is_at_end = (place >= self.distance) & (state["direction"] > 0) | (place <= 0.0) & (state["direction"] < 0)
        direction = np.where(was_stopped | is_at_end, -state["direction"], state["direction"])
        step = direction * self.speed * dt
        state["direction"], state["proposed"], state["place"] = direction, step, place
        return np.concatenate((step, np.zeros((view.rows, 2))), axis=1)
