"""An error in proportion to the value."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from amorsim.contracts import Noise, NoiseStep, parameter

__all__ = ["Scale"]


@attrs.frozen(kw_only=True)
class Scale(Noise):
    """Multiplies every value by the same factor; inf stays inf.

    Parameters
    ----------
    factor
        The factor; 1 changes nothing.
    """

    factor: float = parameter(gt=0, help="what every value is multiplied by")

    def steps(self) -> Sequence[NoiseStep]:
        """Multiply by the factor."""
        return [NoiseStep.multiply(self.factor)]
