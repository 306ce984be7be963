"""The beam model of probabilistic robotics, for ranges."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Noise, State, parameter
from amorsim.core.parameters import ParameterError
from amorsim.kernels import elementary

__all__ = ["BeamModel"]


_TOLERANCE = 1e-9  # of the sum of the weights, which are given in decimals


@attrs.frozen(kw_only=True)
class BeamModel(Noise):
    """Makes of each range, by chance, a hit, something in front of it, no return, or any number.

    Ranges are drawn from the mixture of S. Thrun, W. Burgard and D. Fox, "Probabilistic Robotics" (2005): the range
    with normal noise; an exponential distribution cut off at the range, for things that the map does not know; no
    return; and a uniform distribution over the device's range. No return is ``inf``, where the book has `range_max`;
    for a device that reports `range_max`, add a `dropout` or `saturate` after this element. A hit below 0 or above
    `range_max` is set to that end. Where nothing returned, a hit stays inf, and a thing in front may be anywhere in
    the range.

    Parameters
    ----------
    hit, short, max, random
        The weights of the four parts, which sum to 1.
    std
        Standard deviation of a hit [m].
    short_rate
        Rate of the exponential distribution [1/m]; a larger rate puts the things in front nearer.
    range_max
        Longest range of the device [m].
    """

    hit: float = parameter(1.0, ge=0, le=1, help="weight of the range itself with normal noise")
    short: float = parameter(0.0, ge=0, le=1, help="weight of things in front of what the map has")
    max: float = parameter(0.0, ge=0, le=1, help="weight of no return")
    random: float = parameter(0.0, ge=0, le=1, help="weight of any range at all")
    std: float = parameter(0.0, unit="m", ge=0, help="standard deviation of a hit")
    short_rate: float = parameter(
        1.0, unit="1/m", gt=0, help="rate of the exponential distribution of what is in front"
    )
    range_max: float = parameter(unit="m", gt=0, help="longest range of the device")

    def __attrs_post_init__(self) -> None:
        total = self.hit + self.short + self.max + self.random
        if abs(total - 1.0) > _TOLERANCE:
            raise ParameterError("hit", f"expected hit, short, max and random to sum to 1, got {total!r}")

    def corrupt(self, values: Array, side: Mapping[str, Array], elapsed: Array, state: State, draws: Draws) -> Array:
        """The ranges `(N, k)` [m], inf for no return."""
        k = values.shape[1]
        part, noise, place = draws.uniform(k), draws.normal(k) * self.std, draws.uniform(k)
        hit = np.minimum(np.maximum(values - (0.0 - noise), 0.0), self.range_max)
        # Without noise a hit is the value itself.
        hit = np.where((noise == 0.0) | np.isinf(values), values, hit)
        within = np.minimum(np.maximum(values, 0.0), self.range_max)
        # The inverse distribution function of an exponential cut off at the range.
        short = np.minimum(
            -elementary.log1p(place * elementary.expm1(-self.short_rate * within)) / self.short_rate, within
        )
        drawn = np.where(part < self.short + self.max + self.random, place * self.range_max, hit)
        drawn = np.where(part < self.short + self.max, np.inf, drawn)
        return np.where(part < self.short, short, drawn)
