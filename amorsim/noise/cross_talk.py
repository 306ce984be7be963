"""Sound of others taken for one's own echo."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.errors import ComponentError

__all__ = ["CrossTalk"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class CrossTalk(Noise):
    """Takes what a sonar hears of others for its own echo, where it comes first.

    For a sonar with a `medium`, which tells what each element hears: the sound of other elements of the ring, of other
    rings, of other robots, that fire into the same medium; straight across or by way of a wall or a body other than the
    robot that emits it. A nearer range that has been made so far stands; a lost echo, an inf, gives way.

    Parameters
    ----------
    probability
        That a sound of others is strong enough to be taken for an echo, drawn for each value anew.
    """

    probability: float = parameter(1.0, ge=0, le=1, help="that a sound of others is taken for an echo")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The ranges `(N, k)` [m]; `ComponentError` where the sensor does not tell what it hears."""
        if "heard" not in side:
            raise ComponentError(
                "CrossTalk: expected a sonar that tells what it hears, one with a medium such as medium = "
                '"ultrasound"; got one that does not. Give it a medium, or take the element out of its chain'
            )
        takes = draws.uniform(values.shape[1]) < self.probability
        heard = side["heard"]
        return np.where(takes & (heard < values), heard, values)
