"""A wheel that slips for a while."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Noise, State, parameter
from amorsim.kernels.sensing import noise_elements
from amorsim.noise.joints import chosen

__all__ = ["Slip"]


@attrs.frozen(kw_only=True)
class Slip(Noise):
    """Lets wheels slip from a given time on for a given time: over the ground they go only a part of what they roll.

    For the `ground` chain of any drive; encoders do not see the slip. An element is one event; a chain may have any
    number of them, each with its own name. In the steps where it begins or ends, wheels slip for the part of the
    step that the event covers, so the way does not depend on the step.

    Parameters
    ----------
    at
        Time at which it begins [s], from the start of the episode.
    duration
        Its length [s].
    factor
        Way over the ground per metre rolled: 1 for no slip, 0 for a wheel that spins on the spot.
    joint
        Name of the joint that slips; without one, all rolling joints.
    """

    for_ground: ClassVar[bool] = True

    at: float = parameter(unit="s", ge=0, help="when it begins, from the start of the episode")
    duration: float = parameter(unit="s", ge=0, help="how long it lasts")
    factor: float = parameter(ge=0, help="way over the ground for each metre rolled")
    joint: str = parameter(
        "", static=True, refers="joints", help="name of the joint that slips; empty for all that roll"
    )

    def start(self, context: Context) -> State:
        """State: the number of steps made `(N, 1)`, and which of the rolling joints slip `(N, r)`, 1 or 0."""
        steps = np.zeros((context.rows, 1), dtype=np.int64)
        return {"steps": steps, "slips": chosen("Slip", self.joint, context)}

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The travels `(N, r)` [m] over the ground."""
        out = np.empty(values.shape)
        noise_elements.slip(values, state["steps"], elapsed, self.at, self.duration, self.factor, state["slips"], out)
        state["steps"] = state["steps"] + 1
        return out
