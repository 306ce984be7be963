"""A constant error."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from amorsim.contracts import Noise, NoiseStep, parameter

__all__ = ["Bias"]


@attrs.frozen(kw_only=True)
class Bias(Noise):
    """Adds the same to every value; inf stays inf.

    Parameters
    ----------
    value
        The error, in the sensor's unit.
    """

    value: float = parameter(unit="sensor", help="what is added")

    def steps(self) -> Sequence[NoiseStep]:
        """Add the bias."""
        return [NoiseStep.add(self.value)]
