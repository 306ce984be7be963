"""The arguments of code for one robot: a pose and readings, in place of arrays over rows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.unknown_names import no_such

__all__ = ["PoseVector", "RobotReading", "RobotReadings"]

_Measured = tuple[Array, Ints, Array, Bools]  # measured, stamp, age, fresh


class PoseVector(np.ndarray[Any, np.dtype[np.float64]]):
    """A pose as an array `(3,)` whose elements also have names."""

    @property
    def x(self) -> float:
        """To the right in the world [m]."""
        return float(self[0])

    @property
    def y(self) -> float:
        """Up in the world [m]."""
        return float(self[1])

    @property
    def heading(self) -> float:
        """Anticlockwise from the world's x axis [rad]."""
        return float(self[2])


class RobotReading(NamedTuple):
    """A sensor's reading, of one robot."""

    measured: Array  # (k,) in the sensor's unit
    stamp: int  # the tick at which the values were taken
    age: float  # [s], since then
    fresh: bool  # whether they arrived in this step


class RobotReadings(Mapping[str, RobotReading]):
    """The readings of one robot by sensor, each copied at its first use; an unknown name's error lists the sensors.

    A robot's code uses few of its sensors in a step. `keep` copies the others, if the code kept this mapping.
    """

    __slots__ = ("__weakref__", "_made", "_of_all", "_row")

    def __init__(self, of_all: Mapping[str, _Measured], row: int) -> None:
        self._of_all = of_all
        self._row = row
        self._made: dict[str, RobotReading] = {}

    def __getitem__(self, name: str) -> RobotReading:
        if name not in self._made:
            if name not in self._of_all:
                raise KeyError(no_such("sensor", name, self._of_all))
            measured, stamp, age, fresh = self._of_all[name]
            row = self._row
            self._made[name] = RobotReading(measured[row].copy(), stamp.item(row), age.item(row), fresh.item(row))
        return self._made[name]

    def keep(self) -> None:
        """Copy all readings, before the arrays of all robots change."""
        for name in self._of_all:
            self[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._of_all)

    def __len__(self) -> int:
        return len(self._of_all)

    def __repr__(self) -> str:
        return repr(dict(self))
