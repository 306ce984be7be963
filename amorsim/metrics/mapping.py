"""How well the map that an estimator has drawn fits the true walls."""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.map_scores import MapScores, map_scores
from amorsim.array_types import Array
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.maps.map import Map
from amorsim.core.poses import compose, relative

__all__ = ["MapAccuracy", "MapCompleteness", "MapIou"]

Cells = npt.NDArray[np.uint8]

_FREE, _OCCUPIED, _NOT_JUDGED = 0, 1, 2
_PARTS = 4  # of a cell's side, into which the true world is divided


@attrs.frozen(kw_only=True)
class _OfMap(Metric, abc.ABC):
    """A score of an estimator's map at the end, on the surfaces of the true walls: nobody sees into a wall."""

    estimator: str = parameter(
        "mapping", refers="estimators", help="which estimator; it must have a map among its beliefs"
    )

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        whose = f"last.beliefs.{self.estimator}"
        return (f"{whose}.occupancy", f"{whose}.occupancy_origin", f"{whose}.occupancy_resolution")

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        occupancy, origins, sides = (episode.kept[name][-1] for name in self.needs())
        found = np.full(len(episode.replicas), np.nan)
        for row, cells in enumerate(occupancy):
            side = float(sides.reshape(len(found), -1)[row, 0])
            truth = _surfaces(episode.map_of(row), origins[row, :2], cells.shape, side)
            found[row] = self._score(map_scores(np.clip(cells, 0.0, 1.0), truth, side))
        return found

    @staticmethod
    @abc.abstractmethod
    def _score(scores: MapScores) -> float:
        """The one of the scores that it is."""


@attrs.frozen(kw_only=True)
class MapAccuracy(_OfMap):
    """Mean distance of the cells that a map calls occupied to the nearest true wall; nan for a map without any.

    It grows with walls that are drawn twice or in the wrong place, and not with those that are missing.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    @staticmethod
    def _score(scores: MapScores) -> float:
        """See `_OfMap`."""
        return scores.accuracy


@attrs.frozen(kw_only=True)
class MapCompleteness(_OfMap):
    """Mean distance of the true walls' cells to the nearest that a map calls occupied; inf for a map without any.

    It grows with walls that are missing, and not with those that are too many.
    """

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    @staticmethod
    def _score(scores: MapScores) -> float:
        """See `_OfMap`."""
        return scores.completeness


@attrs.frozen(kw_only=True)
class MapIou(_OfMap):
    """Intersection over union of the cells that a map calls occupied and the true walls' cells: 1 for a perfect map.

    A wall that is one cell off counts as missing, and as one too many.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    @staticmethod
    def _score(scores: MapScores) -> float:
        """See `_OfMap`."""
        return scores.iou


def _surfaces(world: Map, origin: Array, shape: tuple[int, ...], side: float) -> Cells:
    """The true cells of a map's area: `_OCCUPIED` on surfaces, `_NOT_JUDGED` within walls; free outside the world."""
    base = np.array([world.origin])
    middles = np.stack(np.meshgrid(*(side * (np.arange(n) + 0.5) for n in shape[::-1])), axis=-1).reshape(-1, 2)
    poses = np.column_stack((middles + origin, np.zeros(len(middles))))
    within = relative(np.repeat(base, len(poses), axis=0), poses)[:, :2]
    outside = ((within < 0.0) | (within > world.size)).any(axis=1).reshape(shape)
    truth = np.full(shape, _FREE, np.uint8)
    fine = side / _PARTS
    places = (np.argwhere(world.to_array(resolution=fine))[:, ::-1] + 0.5) * fine
    walls = compose(np.repeat(base, len(places), axis=0), np.column_stack((places, np.zeros(len(places)))))
    cells = np.floor((walls[:, :2] - origin) / side).astype(np.int64)
    cells = cells[((cells >= 0) & (cells < shape[::-1])).all(axis=1)]
    truth[cells[:, 1], cells[:, 0]] = _OCCUPIED
    around = np.pad((truth == _FREE) & ~outside, 1)
    shown = around[:-2, 1:-1] | around[2:, 1:-1] | around[1:-1, :-2] | around[1:-1, 2:]
    truth[(truth == _OCCUPIED) & ~shown] = _NOT_JUDGED
    return truth
