"""Cross-talk: a sonar mistakes the sound of other transducers for its echo."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.errors import ComponentError

__all__ = ["CrossTalk"]


@attrs.frozen(kw_only=True)
class CrossTalk(Noise):
    """Takes what a sonar hears of others for its own echo, where it comes first.

    For a sonar with a `medium`. Each element hears the other elements in that medium: of its ring, of other rings and
    of other robots. Sound comes straight or is reflected by a wall or by a body other than the emitting robot. A nearer
    range in the chain so far is kept; a lost echo (inf) is replaced.

    Parameters
    ----------
    probability
        Probability that such a sound is strong enough to be taken for an echo, drawn separately for each value.
    """

    probability: float = parameter(1.0, ge=0, le=1, help="that a sound of others is taken for an echo")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The ranges `(N, k)` [m]; `ComponentError` if the sensor gives no ``heard`` ranges."""
        if "heard" not in side:
            raise ComponentError(
                "CrossTalk: expected a sonar that reports what it hears, one with a medium such as medium = "
                '"ultrasound"; got one that does not. Give it a medium, or take the element out of its chain'
            )
        takes = draws.uniform(values.shape[1]) < self.probability
        heard = side["heard"]
        return np.where(takes & (heard < values), heard, values)
