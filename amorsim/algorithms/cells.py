"""The cells in which a footprint may be, which planners on cells search."""

from __future__ import annotations

import math
from collections.abc import Sequence
from weakref import WeakKeyDictionary

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints32
from amorsim.core.errors import MapError, PlanError
from amorsim.core.maps.cell_lines import placed
from amorsim.core.maps.map import Map, Place
from amorsim.kernels.search.cell_clearance import squared_gaps

__all__ = ["Cells", "free_cells", "gaps_to_walls", "place_of", "usual_side"]


_MOST_CELLS = 50_000_000
_MANY_CELLS = 4_000_000  # searched in a second or so
_USUAL_SIDES = (0.001, 0.002, 0.005, 0.01, 0.02, 0.05)  # [m]
_KEPT = 4  # arrays of cells of a map


@attrs.frozen(kw_only=True, eq=False)
class Cells:
    """Square cells of a map, in flat arrays with a border of blocked cells: ``cell = (row + 1) * width + col + 1``."""

    origin: Place
    """The map's lower left corner in the world, and its rotation about it."""
    side: float
    """Side of a cell [m]."""
    width: int
    """Cells in a row, with the border's two."""
    free: npt.NDArray[np.uint8]
    """(n,) 1 where the footprint may be."""
    gaps: Ints32 | None
    """(rows, cols) squared gap [cells^2] to the nearest occupied cell, as far as the footprint reaches; -1 in one. None
    for a point."""
    occupied: npt.NDArray[np.uint8]
    """(n,) 1 where a cell of the map is occupied, and in the border."""
    reach: float
    """[m] that a free cell keeps from all occupied ones, in every point of it."""

    @property
    def rows(self) -> int:
        """Rows, without the border's."""
        return len(self.free) // self.width - 2

    @property
    def cols(self) -> int:
        """Columns, without the border's."""
        return self.width - 2

    def in_cells(self, x: float, y: float) -> tuple[float, float]:
        """A place [m] of the world in the map's frame [cells], from its lower left corner."""
        origin_x, origin_y, yaw = self.origin
        dx, dy = x - origin_x, y - origin_y
        if yaw != 0.0:
            c, s = math.cos(yaw), math.sin(yaw)
            dx, dy = c * dx + s * dy, c * dy - s * dx
        return dx / self.side, dy / self.side

    def cell_at(self, x: float, y: float) -> int | None:
        """The cell of a place [m] of the world; None outside the map."""
        across, up = self.in_cells(x, y)
        if not (0.0 <= across < self.cols and 0.0 <= up < self.rows):
            return None
        return (int(up) + 1) * self.width + int(across) + 1

    def places(self, cells: npt.NDArray[np.integer]) -> Array:
        """Centres (M, 2) [m] of cells in the world."""
        middles = np.empty((len(cells), 2))
        middles[:, 0] = cells % self.width - 0.5
        middles[:, 1] = cells // self.width - 0.5
        middles *= self.side
        return placed(self.origin, middles)

    def gap(self, cell: int) -> float:
        """Gap [m] between a cell and the nearest occupied one, as far as the footprint reaches; 0 in one."""
        if self.gaps is None:
            return 0.0
        return math.sqrt(max(int(self.gaps[cell // self.width - 1, cell % self.width - 1]), 0)) * self.side

    def narrowed(self, squared_gap: int) -> npt.NDArray[np.uint8]:
        """`free` for a smaller footprint: the cells with this squared gap [cells^2] or more."""
        assert self.gaps is not None
        return _flat(self.gaps >= squared_gap)


# Maps never change, so their cells are made once. `Cells` do not refer to their map, which would keep it here for ever.
_cells_of: WeakKeyDictionary[Map, dict[tuple[float, float, bool], Cells]] = WeakKeyDictionary()


def free_cells(world: Map, reach: float, *, side: float | None = None, avoid_unknown: bool = False) -> Cells:
    """The cells of a map in which a body that reaches `reach` [m] from its base point may be.

    A cell is free if every point of it keeps `reach` from every occupied cell; touching is free. So a body whose base
    point moves along any line through free cells touches no wall, whatever its heading.

    Parameters
    ----------
    side
        Side of a cell [m]; if not given, `usual_side`. A coarser cell is occupied if any cell of the map in it is.
    avoid_unknown
        Whether unknown cells count as occupied.

    Raises
    ------
    PlanError
        If there are more than 50 million cells, or it is not a map.
    """
    check_map(world)
    side = usual_side(world) if side is None else side
    key = (reach, side, avoid_unknown)
    kept = _cells_of.setdefault(world, {})
    found = kept.get(key)
    if found is None:
        found = _made(world, reach, side, avoid_unknown)
        while len(kept) >= _KEPT:
            kept.pop(next(iter(kept)), None)
        kept[key] = found
    return found


def usual_side(world: Map) -> float:
    """The side of cells [m] to plan on: the map's, or of a map of more than four million finer ones up to 0.05 m.

    Of 1, 2 and 5 mm, 1, 2 and 5 cm it is then the first that makes no more than four million cells, or else 5 cm: a
    robot's way does not depend on the millimetres that its sensors see.
    """
    width, height = world.size
    for side in (world.resolution, *(side for side in _USUAL_SIDES if side > world.resolution)):
        if width / side * (height / side) <= _MANY_CELLS:
            return side
    return max(world.resolution, _USUAL_SIDES[-1])


def _made(world: Map, reach: float, side: float, avoid_unknown: bool) -> Cells:
    width, height = world.size
    if width / side * (height / side) > _MOST_CELLS:
        coarser = math.sqrt(width * height / _MOST_CELLS)
        raise PlanError(
            f"the map has {height / side:.6g} x {width / side:.6g} cells of {side:g} m; expected {_MOST_CELLS} at "
            f"most: set the planner's cell to {_rounded_up(coarser)} m or more"
        )
    try:
        free = world.to_array(resolution=side) == 0
        if avoid_unknown and world.unknown is not None:
            free &= world.unknown_array(resolution=side) == 0
    except MapError as error:
        raise PlanError(f"the map's cells cannot be had: {error}") from error
    gaps = None
    occupied = 1 - _flat(free)
    if reach > 0.0:
        # A wall that the footprint just touches is not an obstacle, however its distance is rounded.
        needed = reach / side * (1.0 - 1e-12)
        most = min(math.ceil(needed), max(free.shape) + 1)
        gaps = np.empty(free.shape, np.int32)
        squared_gaps(free.view(np.uint8), most, np.empty(free.shape, np.int32), gaps)
        free = (gaps >= 0) & (gaps >= min(needed, most) ** 2)
    return Cells(
        origin=world.origin,
        side=side,
        width=free.shape[1] + 2,
        free=_flat(free),
        gaps=gaps,
        occupied=occupied,
        reach=reach,
    )


def check_map(world: Map) -> None:
    """Raise `PlanError` if this is not a map."""
    if not isinstance(world, Map):
        raise PlanError(f"world is a {type(world).__name__}; expected a Map, as am.Map.from_array makes of an array")


def gaps_to_walls(cells: Cells) -> Ints32:
    """Squared gap (n,) [cells^2] between each cell and the nearest occupied one, however far; -1 in one."""
    shape = (cells.rows, cells.cols)
    free = np.ascontiguousarray(1 - cells.occupied.reshape(-1, cells.width)[1:-1, 1:-1])
    found = np.empty(shape, np.int32)
    squared_gaps(free, max(shape) + 1, np.empty(shape, np.int32), found)
    return np.pad(found, 1, constant_values=-1).reshape(-1)


def _flat(free: Bools) -> npt.NDArray[np.uint8]:
    return np.ascontiguousarray(np.pad(free, 1)).view(np.uint8).reshape(-1)


def _rounded_up(side: float) -> float:
    """A side of two digits, not smaller than the given one."""
    unit = 10.0 ** (math.floor(math.log10(side)) - 1)
    return round(math.ceil(side / unit) * unit, 12)


def place_of(given: Sequence[float], what: str) -> tuple[float, float, float | None]:
    """x, y [m] and heading [rad] of a start or goal, None for a heading that is not given.

    Raises
    ------
    PlanError
        If it is not two or three finite numbers.
    """
    try:
        numbers = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        numbers = np.empty(0)
    if numbers.shape not in ((2,), (3,)) or not np.isfinite(numbers).all():
        raise PlanError(
            f"{what} is {given!r}; expected (x, y) or (x, y, heading), finite numbers in metres and radians"
        )
    values = numbers.tolist()
    return values[0], values[1], values[2] if len(values) == 3 else None
