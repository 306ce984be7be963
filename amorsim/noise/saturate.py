"""Values within a device's range."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs

from amorsim.contracts import Noise, NoiseStep, parameter
from amorsim.core.parameters import ParameterError

__all__ = ["Saturate"]


@attrs.frozen(kw_only=True)
class Saturate(Noise):
    """Values beyond the range of a device read as its end; inf stays inf, as it means that nothing returned.

    Parameters
    ----------
    minimum, maximum
        The ends of the range, in the sensor's unit; none for no end.
    """

    minimum: float | None = parameter(None, unit="sensor", help="lowest value; none for no end")
    maximum: float | None = parameter(None, unit="sensor", help="highest value; none for no end")

    def __attrs_post_init__(self) -> None:
        low, high = self.minimum, self.maximum
        if low is not None and high is not None and low > high:
            raise ParameterError("minimum", f"expected no more than maximum {high!r}, got {low!r}")

    def steps(self) -> Sequence[NoiseStep]:
        """Cut off at the ends."""
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        return [NoiseStep.clip(low, high)]
