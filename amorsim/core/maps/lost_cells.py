"""The loss of a map that was written and read again, in numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator

import attrs
import numpy as np
import shapely
from numpy.typing import NDArray

from amorsim.array_types import Bools
from amorsim.core.maps.cell_lines import to_world
from amorsim.core.maps.map import Map
from amorsim.core.maps.same_cells import have_same_cells

__all__ = ["Lost", "lost_cells"]

_STRIP = 2**21  # cells that are looked at together
_MOST_CELLS = 2 * 10**6  # of those that distances are measured between

Points = NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Lost:
    """How a copy of a map differs from it."""

    cells: int
    """Cells of the original whose middle is free in one and occupied in the other."""
    of: int
    """Cells of the original."""
    farthest: float | None
    """The farthest [m] that an occupied cell of one is from the nearest occupied cell of the other; None if there are
    too many to tell, inf if only one has any."""
    unknown: int
    """Cells that are unknown in the original, and known in the copy or outside it."""
    has_start: bool
    """Whether the original gives a start, and the copy does not, or another one."""

    @property
    def is_nothing(self) -> bool:
        """Whether nothing was lost."""
        return not (self.cells or self.farthest or self.unknown or self.has_start)


def lost_cells(original: Map, copy: Map) -> Lost:
    """The loss of a copy of a map, in cells of the original; their frames may differ."""
    rows, columns = original.shape
    has_start = original.start is not None and (
        copy.start is None or math.dist(original.start, copy.start) > 1e-9 * (1.0 + math.hypot(*original.start))
    )
    if have_same_cells(original, copy):
        return Lost(cells=0, of=rows * columns, farthest=0.0, unknown=0, has_start=has_start)
    count, unknown = 0, 0
    missing: list[Points] = []
    for places, occupied, is_unknown in _strips(original):
        differs = copy.occupied(places) != occupied
        count += int(differs.sum())
        missing.append(places[differs & occupied])
        unknown += int((is_unknown & ~_unknown_at(copy, places)).sum())
    added = [places[occupied & ~original.occupied(places)] for places, occupied, _ in _strips(copy)]
    farthest = _farthest(np.concatenate(missing), copy, np.concatenate(added), original)
    return Lost(
        cells=count,
        of=rows * columns,
        farthest=None if farthest is None else max(farthest, _shift(original, copy)),
        unknown=unknown,
        has_start=has_start,
    )


def _strips(world: Map) -> Iterator[tuple[Points, Bools, Bools]]:
    """Some rows at a time: the middles (n, 2) of their cells in the world, which are occupied and which unknown."""
    rows, columns = world.shape
    side = world.resolution
    step = max(1, _STRIP // columns)
    for first in range(0, rows, step):
        count = min(step, rows - first)
        window = (0.0, first * side, columns * side, (first + count) * side)
        cells, unknown = world.to_array(window) != 0, world.unknown_array(window) != 0
        row, column = np.divmod(np.arange(count * columns), columns)
        yield (
            to_world(world, np.stack((column + 0.5, row + first + 0.5), axis=-1) * side),
            cells.ravel(),
            unknown.ravel(),
        )


def _unknown_at(world: Map, places: Points) -> Bools:
    if world.unknown is None:
        return np.zeros(len(places), np.bool_)
    return attrs.evolve(world, grid=world.unknown).occupied(places)


def _farthest(missing: Points, copy: Map, added: Points, original: Map) -> float | None:
    """The largest distance [m] of one of these occupied cells from those of the other map."""
    farthest = 0.0
    for places, other in ((missing, copy), (added, original)):
        if len(places) == 0:
            continue
        if len(places) > _MOST_CELLS:
            return None
        count, occupied = 0, []
        for middles, cells, _ in _strips(other):
            occupied.append(middles[cells])
            count += len(occupied[-1])
            if count > _MOST_CELLS:
                return None
        if count == 0:
            return math.inf
        tree = shapely.STRtree(shapely.points(np.concatenate(occupied)))
        _, distances = tree.query_nearest(shapely.points(places), return_distance=True, all_matches=False)
        farthest = max(farthest, float(distances.max()))
    return farthest


def _shift(one: Map, other: Map) -> float:
    """How far the cells of two maps are shifted [m], where they are of the same side and direction."""
    if (one.resolution, one.origin[2]) != (other.resolution, other.origin[2]) or one.origin[2] != 0.0:
        return 0.0
    apart = [(a - b) / one.resolution for a, b in zip(one.origin[:2], other.origin[:2], strict=True)]
    return math.hypot(*(cells - round(cells) for cells in apart)) * one.resolution
