"""Side information on a sensor's values, computed only when an element of its chain reads it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from amorsim.array_types import Array

__all__ = ["Side"]


class Side(Mapping[str, Array]):
    """Arrays `(N, k)` by name, each computed at its first use; valid for the step in which it was made.

    Parameters
    ----------
    makers
        Functions by name; each returns its array.
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
