"""What a sensor can tell of its values beside them, worked out only if an element of its chain asks."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np
import numpy.typing as npt

__all__ = ["Side"]

Array = npt.NDArray[np.float64]


class Side(Mapping[str, Array]):
    """Arrays `(N, k)` by name, each made when it is first asked for; good for the step in which it was made.

    Parameters
    ----------
    makers
        By name, what makes the array.
    """

    __slots__ = ("_made", "_makers")

    def __init__(self, **makers: Callable[[], Array]) -> None:
        self._makers = makers
        self._made: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        if name not in self._made:
            self._made[name] = self._makers[name]()
        return self._made[name]

    def __contains__(self, name: object) -> bool:
        return name in self._makers

    def __iter__(self) -> Iterator[str]:
        return iter(self._makers)

    def __len__(self) -> int:
        return len(self._makers)
