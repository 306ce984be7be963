"""The contract of metrics, and what they are shown."""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import attrs
import numpy as np

from amorsim.array_types import AnyArray, Array
from amorsim.contracts.robot import Part
from amorsim.core.maps.map import Map
from amorsim.core.shapes import Shape

__all__ = ["Episode", "Metric"]


@attrs.frozen(kw_only=True, eq=False)
class Episode:
    """The run of one robot, in all replicas, from the start to the end. Do not change the arrays."""

    robot: str
    """Its name."""
    replicas: Sequence[int]
    """The replicas' numbers, in the order of the rows."""
    time: Array
    """(S,) [s], of the start and of each step."""
    kept: Mapping[str, AnyArray]
    """The quantities that the metric lists in `needs`, by name: (S, R, ...), a row for each replica."""
    events: Sequence[Any]
    """Events (`am.Event`) of the robot, of all these replicas, in order."""
    map: Map
    """The true world; that of replica 0 if replicas have worlds of their own, see `map_of`."""
    shape: Shape
    """The robot's footprint."""
    parts: Sequence[Part] = ()
    """Its other bodies, such as a trailer. Where they were, in this order, is the quantity ``"part_pose"``."""
    maps: Sequence[Map] = ()
    """(R,) the true world of each row, if replicas have worlds of their own; else empty."""

    def map_of(self, row: int) -> Map:
        """The true world of a row's replica."""
        return self.maps[row] if self.maps else self.map

    @property
    def dt(self) -> float:
        """The time between two steps [s]; nan if no step was made."""
        return float(self.time[1] - self.time[0]) if len(self.time) > 1 else np.nan


class Metric(abc.ABC):
    """A number for each replica of a run. Its fields are the parameters next to ``use`` in a study's file.

    It must not depend on how many replicas there are, to the bit: sum over steps one after another
    (``np.cumsum(..., axis=0)[-1]``), and never over rows.
    """

    unit: ClassVar[str]
    """The unit of its values; empty for a pure number."""
    better: ClassVar[str]
    """``"lower"`` or ``"higher"``, whichever is better; ``"neither"`` if neither is."""

    def needs(self) -> Sequence[str]:
        """The quantities that it reads, by the names of `Simulation.run`'s `keep`, such as ``"true_pose"``."""
        return ("true_pose", "estimated_pose")

    @abc.abstractmethod
    def measure(self, episode: Episode) -> Array:
        """Its value in each replica `(R,)`; nan where it has none."""
