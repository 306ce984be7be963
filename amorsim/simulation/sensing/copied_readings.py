"""Readings for components that are not bound: copies, as they may keep them or write into them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from amorsim.contracts import Measurement

__all__ = ["Copies"]


class Copies(Mapping[str, Measurement]):
    """Readings by sensor, each copied from the arrays of the current one when it is looked up."""

    def __init__(self, live: Mapping[str, Measurement]) -> None:
        self._live = live

    def __getitem__(self, name: str) -> Measurement:
        measured, stamp, age, fresh = self._live[name]
        return Measurement(measured.copy(), stamp.copy(), age.copy(), fresh.copy())

    def __iter__(self) -> Iterator[str]:
        return iter(self._live)

    def __len__(self) -> int:
        return len(self._live)
