"""The plan of a study: its axes, its points, and the chunks that are computed at once."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping
from typing import Any

import attrs

from amorsim.contracts import Metric

__all__ = ["COLUMNS", "Axis", "Chunk", "Measured", "Plan"]

COLUMNS = ("point", "seed", "replica", "digest", "error")
"""The columns of a study's table besides its axes and metrics."""

Label = float | int | str | bool


@attrs.frozen(kw_only=True)
class Axis:
    """An axis of a study: its name, and for each value the label, the settings and the files that it names."""

    name: str
    labels: tuple[Label, ...]
    settings: tuple[tuple[str, ...], ...]
    files: tuple[tuple[str, ...], ...]

    def __len__(self) -> int:
        return len(self.labels)


@attrs.frozen(kw_only=True)
class Measured:
    """A metric of a study, with its name there and its robot; without one, the only robot.

    `source` is ``FILE.py:NAME`` of a metric in a file.
    """

    name: str
    metric: Metric
    robot: str = ""
    source: str = ""


@attrs.frozen(kw_only=True)
class Chunk:
    """A chunk, computed at once: all replicas of a point for one seed."""

    index: int
    point: int
    seed: int
    labels: tuple[Label, ...]
    settings: tuple[str, ...]


@attrs.frozen(kw_only=True)
class Plan:
    """A study as in its file.

    Attributes
    ----------
    scenario
        The path of its file, or the name of a bundled one.
    replicas
        Of each point and seed.
    duration
        In place of the scenario's [s].
    stop
        When a replica ends before that: ``"never"``; ``"still"``, when none of its robots has moved for a second, after
        one had; ``"collision"``, at a robot's first one.
    tables
        The study's file, as plain values.
    """

    name: str
    scenario: str
    replicas: int
    seeds: tuple[int, ...]
    axes: tuple[Axis, ...]
    metrics: tuple[Measured, ...]
    duration: float | None = None
    stop: str = "never"
    tables: Mapping[str, Any] = attrs.field(factory=dict)

    @property
    def points(self) -> int:
        """The number of points."""
        return math.prod(len(axis) for axis in self.axes)

    @property
    def chunks(self) -> int:
        """The number of chunks: one for each point and seed."""
        return self.points * len(self.seeds)

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of the columns of the table."""
        axes, metrics = (tuple(each.name for each in kind) for kind in (self.axes, self.metrics))
        return ("point", *axes, "seed", "replica", *metrics, "digest", "error")

    def chunk(self, index: int) -> Chunk:
        """The chunk of that number; the last axis changes first, and the seed before it."""
        point, seed = divmod(index, len(self.seeds))
        places, rest = [], point
        for axis in reversed(self.axes):
            rest, place = divmod(rest, len(axis))
            places.append(place)
        places.reverse()
        pairs = list(zip(self.axes, places, strict=True))
        return Chunk(
            index=index,
            point=point,
            seed=self.seeds[seed],
            labels=tuple(axis.labels[place] for axis, place in pairs),
            settings=tuple(itertools.chain.from_iterable(axis.settings[place] for axis, place in pairs)),
        )

    def settings_of(self, labels: Mapping[str, int]) -> Iterator[str]:
        """The settings of the values of some axes, by the axis's name and the value's place."""
        for axis in self.axes:
            if axis.name in labels:
                yield from axis.settings[labels[axis.name]]
