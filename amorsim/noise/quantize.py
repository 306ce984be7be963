"""Values in whole steps."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from amorsim.contracts import Noise, NoiseStep, parameter

__all__ = ["Quantize"]


@attrs.frozen(kw_only=True)
class Quantize(Noise):
    """Rounds every value to a multiple of a step; inf stays inf.

    Parameters
    ----------
    step
        Resolution, in the sensor's unit.
    rounding
        ``"nearest"``, halfway cases to the even multiple; or ``"floor"``, downwards, as a counter does.
    """

    step: float = parameter(unit="sensor", gt=0, help="between two neighbouring values")
    rounding: str = parameter(
        "nearest", choices=("nearest", "floor"), static=True, help="to the nearest multiple, or down to one"
    )

    def steps(self) -> Sequence[NoiseStep]:
        """Round."""
        return [NoiseStep.round(self.step) if self.rounding == "nearest" else NoiseStep.floor(self.step)]
