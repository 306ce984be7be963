"""A sequence of random numbers for one world."""

from __future__ import annotations

import math
from collections.abc import MutableSequence
from typing import Any

from amorsim.array_types import Array
from amorsim.core.draws import Draws

__all__ = ["Numbers"]

_AT_ONCE = 256


class Numbers:
    """Draws of one row, taken one at a time; only sums, products and comparisons, so equal on all machines."""

    def __init__(self, draws: Draws) -> None:
        self._draws = draws
        self._left: list[float] = []

    def uniform(self) -> float:
        """A number in (0, 1)."""
        if not self._left:
            self._left = self._draws.uniform(_AT_ONCE)[0].tolist()
            self._left.reverse()
        return self._left.pop()

    def below(self, count: int) -> int:
        """A whole number from 0 to `count` - 1."""
        return min(int(self.uniform() * count), count - 1)

    def between(self, low: int, high: int) -> int:
        """A whole number from `low` to `high`; `low` if the range is empty."""
        return low + self.below(max(high - low + 1, 1))

    def chance(self, probability: float) -> bool:
        """True with this probability."""
        return self.uniform() < probability

    def shuffle(self, things: MutableSequence[Any]) -> None:
        """Put things into a random order."""
        for last in range(len(things) - 1, 0, -1):
            other = self.below(last + 1)
            things[last], things[other] = things[other], things[last]

    def many(self, *shape: int) -> Array:
        """An array of numbers in (0, 1)."""
        found: Array = self._draws.uniform(math.prod(shape))[0].reshape(shape)
        return found
