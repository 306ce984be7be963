"""A map: which cells of the plane are occupied, their place in the world, and the walls they were drawn from."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Self

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from amorsim.core.errors import MapError
from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.grid import Grid, occupied_boxes
from amorsim.kernels.grid.outlines import outline_lines
from amorsim.kernels.grid.rasterise import MOST_CELLS, grid_from_segments, snapped
from amorsim.kernels.grid.segment_boxes import index_segments, no_segments
from amorsim.kernels.grid.segments import SegmentIndex
from amorsim.kernels.raycast.rays import occupied_points
from amorsim.kernels.raycast.scans import cast_scans

__all__ = ["Map"]

_MOST_BYTES = 10**9
# A double still resolves a thousandth of a cell there.
_FARTHEST_CELL = 2**43
_MOST_TABLES = 2**23
_TABLE_CELLS = 4096
# A page of 64 x 64 cells takes 512 bytes of bits and 128 of room.
_PAGE_CELLS = 64
_PAGE_BYTES = 640
# Of a table: 4 bytes for each of its pages.
_TABLE_BYTES = 16_384
# The limit for the cells of one map; with the memory needed to draw them, that is 1 GB.
_MOST_GRID_BYTES = 400_000_000

Window = tuple[float, float, float, float]
"""xmin, ymin, xmax, ymax [m]."""
Place = tuple[float, float, float]
"""x, y [m], heading [rad]."""


@attrs.frozen(kw_only=True, eq=False, repr=False)
class Map:
    """Cells of the plane, each free or occupied; outside the map everything is occupied.

    Made by `from_segments` or `from_array`. It never changes, so copies are the map itself.
    """

    grid: Grid
    """The cells, as kernels read them; never written to."""
    origin: Place
    """The lower left corner in the world, and the map's rotation about it."""
    segments: NDArray[np.float64] | None = None
    """(M, 4) x0, y0, x1, y1 [m] in the world: the walls the cells were drawn from, or None."""
    segment_index: SegmentIndex = attrs.field(factory=no_segments)
    """Walls in the map's frame, as scans look them up: `segments`, or outlines of the cells; never written to."""
    start: Place | None = None
    """The start pose of a robot that the map gives, in the world, or None."""
    warnings: tuple[str, ...] = ()
    """What its file contains that was ignored, one message each."""
    name: str = ""
    source: Any = None
    """The file it was read from, with the loader and its options (`amorsim.scenario.maps.MapFile`), or None."""

    @classmethod
    def from_segments(
        cls,
        segments: ArrayLike,
        *,
        resolution: float = 0.001,
        extent: Sequence[float] | None = None,
        start: Sequence[float] | None = None,
        warnings: Iterable[str] = (),
        name: str = "",
    ) -> Self:
        """The map whose cells are those that closed line segments touch.

        Parameters
        ----------
        segments
            (M, 4) x0, y0, x1, y1 [m] in the world; with an extent, an empty array makes an empty room.
        resolution
            Side of a cell [m]. Borders of cells lie at whole multiples of it in the world.
        extent
            xmin, ymin, xmax, ymax [m]: the map covers this and all walls, outward to whole cells.
        start
            x, y [m] and heading [rad] of a robot's start.

        Raises
        ------
        MapError
            If a number is not finite, the resolution is not positive, there is nothing to cover, or the map
            would be too large.
        """
        side = _resolution(resolution)
        walls = _numbers(segments, "segments")
        if walls.size == 0:
            walls = walls.reshape(0, 4)
        if walls.ndim != 2 or walls.shape[1] != 4:
            raise MapError(f"segments have shape {walls.shape}; expected (M, 4): x0, y0, x1, y1 in metres")
        _refuse_not_finite(walls, "segment")
        corners = walls.reshape(-1, 2)
        if extent is not None:
            xmin, ymin, xmax, ymax = _finite(extent, 4, "extent", "xmin, ymin, xmax, ymax in metres")
            if xmin > xmax or ymin > ymax:
                raise MapError(
                    f"extent ({xmin}, {ymin}, {xmax}, {ymax}) is empty; expected xmin, ymin, xmax, ymax with "
                    "xmin < xmax and ymin < ymax"
                )
            corners = np.concatenate([corners, [[xmin, ymin], [xmax, ymax]]])
        if len(corners) == 0:
            raise MapError("the map is empty: no wall and no extent; give at least one of them")
        with np.errstate(over="ignore", invalid="ignore"):  # overflow is rejected below
            low = np.floor(snapped(corners.min(axis=0) / side))
            high = np.ceil(snapped(corners.max(axis=0) / side))
            cols, rows = (float(n) for n in np.maximum(high - low, 1.0))
        _refuse_too_large(rows, cols, side)
        _refuse_too_far(low, high, side)
        offset = (int(low[0]), int(low[1]))
        _refuse_too_much_memory(walls, int(rows), int(cols), side, offset)
        kept = walls.copy()
        kept.flags.writeable = False
        grid = grid_from_segments(walls, int(rows), int(cols), side, offset)
        return cls(
            grid=grid,
            origin=(offset[0] * side, offset[1] * side, 0.0),
            segments=kept,
            segment_index=index_segments(
                walls - np.tile(np.array(offset) * side, 2), int(rows), int(cols), side, grid=grid
            ),
            start=_start(start),
            warnings=tuple(warnings),
            name=name,
        )

    @classmethod
    def from_array(
        cls,
        array: ArrayLike,
        *,
        resolution: float,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        start: Sequence[float] | None = None,
        warnings: Iterable[str] = (),
        name: str = "",
    ) -> Self:
        """The map of an array (rows, cols), row 0 lowest, whose cells that are not zero are occupied.

        Parameters
        ----------
        resolution
            Side of a cell [m].
        origin
            x, y [m] of the lower left corner in the world, and the yaw [rad] of the rows.
        start
            x, y [m] and heading [rad] of a robot's start in the world.

        Raises
        ------
        MapError
            If a number is not finite, the resolution is not positive, or the array is not of two dimensions
            or is empty.
        """
        side = _resolution(resolution)
        place = _finite(origin, 3, "origin", "x, y in metres and yaw in radians")
        cells = np.asarray(array)
        if cells.ndim != 2 or cells.size == 0:
            raise MapError(f"the array has shape {cells.shape}; expected (rows, cols), at least one of each")
        if cells.dtype.kind not in "buif":
            raise MapError(f"the array holds {cells.dtype}; expected numbers, 0 where a cell is free")
        if cells.dtype.kind == "f" and np.isnan(cells).any():
            raise MapError("the array has nan in it; expected numbers, 0 where a cell is free")
        rows, cols = cells.shape
        _refuse_too_large(rows, cols, side)
        taken = np.ascontiguousarray(cells != 0).view(np.uint8)
        grid = grid_from_array(taken, side)
        return cls(
            grid=grid,
            segment_index=outline_lines(grid, taken),
            origin=(place[0], place[1], place[2]),
            start=_start(start),
            warnings=tuple(warnings),
            name=name,
        )

    @property
    def resolution(self) -> float:
        """Side of a cell [m]."""
        return float(self.grid.resolution)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.grid.rows, self.grid.cols

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        return self.grid.cols * self.resolution, self.grid.rows * self.resolution

    def to_array(self, window: Sequence[float] | None = None, resolution: float | None = None) -> NDArray[np.uint8]:
        """Cells as an array (rows, cols), row 0 lowest, 1 where occupied.

        Parameters
        ----------
        window
            xmin, ymin, xmax, ymax [m] in the map's frame (the lower left corner is 0, 0); the whole map if
            not given. Outside the map it is occupied.
        resolution
            Side [m] of the array's cells, the map's if not given. A coarser cell is occupied if any cell
            in it is.

        Raises
        ------
        MapError
            If the array would take more than 1 GB, or a number makes no sense.
        """
        side = self.resolution if resolution is None else _resolution(resolution)
        if window is None:
            window = (0.0, 0.0, *self.size)
        xmin, ymin, xmax, ymax = _finite(window, 4, "window", "xmin, ymin, xmax, ymax in metres")
        if not (xmin < xmax and ymin < ymax):
            raise MapError(f"window ({xmin}, {ymin}, {xmax}, {ymax}) is empty; expected xmin < xmax and ymin < ymax")
        wide, high = (xmax - xmin) / side, (ymax - ymin) / side
        if wide * high > _MOST_BYTES or max(wide, high) > _MOST_BYTES:
            coarser = max(side * math.sqrt(wide * high / _MOST_BYTES), side * max(wide, high) / _MOST_BYTES)
            raise MapError(
                f"an array of {high:.6g} x {wide:.6g} cells takes more than 1 GB; pass a smaller window [m], "
                f"or a resolution of {coarser:.3g} m or coarser"
            )
        cols, rows = np.ceil(snapped(np.array([wide, high]))).astype(int).tolist()
        row0, row1 = self._fine(ymin, side, rows)
        col0, col1 = self._fine(xmin, side, cols)
        out = np.empty((rows, cols), dtype=np.uint8)
        occupied_boxes(self.grid, row0, row1, col0, col1, out)
        return out

    def _fine(self, low: float, side: float, count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """First and last cell of the map in each of `count` spans of `side` [m], from `low` [m] on."""
        edges = snapped((low + np.arange(count + 1, dtype=np.float64) * side) / self.resolution)
        first = np.floor(edges[:-1]).astype(np.int64)
        last = np.ceil(edges[1:]).astype(np.int64) - 1
        return first, np.maximum(first, last)

    def occupied(self, points: ArrayLike) -> NDArray[np.bool_]:
        """Whether each of the points (M, 2) [m] of the world is in an occupied cell; nan and outside are."""
        places = np.ascontiguousarray(points, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 2:
            raise MapError(f"points have shape {places.shape}; expected (M, 2): x, y in metres")
        out = np.empty(len(places), dtype=np.bool_)
        occupied_points(self.grid, *self.origin, places, out)
        return out

    def cast_rays(self, poses: ArrayLike, bearings: ArrayLike, range_max: float) -> NDArray[np.float64]:
        """Distance [m] along each beam to where it enters the first occupied cell, (N, k); inf beyond
        `range_max`.

        Parameters
        ----------
        poses
            (N, 3) x, y [m] and heading [rad] in the world. From an occupied cell or outside the map distances
            are 0.
        bearings
            (k,) [rad], anticlockwise from the heading.
        range_max
            [m]; may be inf.
        """
        places = np.ascontiguousarray(poses, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 3:
            raise MapError(f"poses have shape {places.shape}; expected (N, 3): x, y in metres, heading in radians")
        angles = np.asarray(bearings, dtype=np.float64)
        if angles.ndim != 1:
            raise MapError(f"bearings have shape {angles.shape}; expected (k,) radians")
        if not range_max >= 0.0:
            raise MapError(f"range_max is {range_max} m; expected 0 or more")
        out = np.empty((len(places), len(angles)))
        with np.errstate(invalid="ignore"):  # an infinite bearing has no cosine, and so no distance: nan
            cosines, sines = np.cos(angles)[None], np.sin(angles)[None]
        reach = np.array([range_max], dtype=np.float64)
        cast_scans(self.grid, self.segment_index, *self.origin, places, cosines, sines, reach, out)
        return out

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Map):
            return NotImplemented
        return self is other or (self._said() == other._said() and self._same_arrays(other))

    def __hash__(self) -> int:
        return hash(self._said())

    def _said(self) -> tuple[object, ...]:
        return self.resolution, self.shape, self.origin, self.start, self.warnings, self.name

    def _same_arrays(self, other: Map) -> bool:
        if (self.segments is None) != (other.segments is None):
            return False
        if self.segments is not None and not np.array_equal(self.segments, np.asarray(other.segments)):
            return False
        # The same walls in the same order number pages alike, so the arrays themselves can be compared.
        ours, theirs = self.grid, other.grid
        return all(
            np.array_equal(mine, its)
            for mine, its in (
                (ours.supers, theirs.supers),
                (ours.tables, theirs.tables),
                (ours.pages, theirs.pages),
            )
        )

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    def __repr__(self) -> str:
        rows, cols = self.shape
        return f"Map({self.name!r}, {rows} x {cols} cells of {self.resolution:g} m, origin {self.origin})"


def _resolution(given: float) -> float:
    try:
        side = float(given)
    except (TypeError, ValueError):
        side = math.nan
    if not (math.isfinite(side) and side > 0.0):
        raise MapError(f"resolution is {given!r}; expected a positive number of metres, such as 0.001")
    return side


def _numbers(given: ArrayLike, what: str) -> NDArray[np.float64]:
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise MapError(f"{what} are not numbers: {error}") from None


def _finite(given: Sequence[float], count: int, what: str, meaning: str) -> tuple[float, ...]:
    values = _numbers(given, what)
    if values.shape != (count,) or not np.isfinite(values).all():
        raise MapError(f"{what} is {given!r}; expected {count} finite numbers: {meaning}")
    return tuple(values.tolist())


def _start(given: Sequence[float] | None) -> Place | None:
    if given is None:
        return None
    x, y, heading = _finite(given, 3, "start", "x, y in metres and heading in radians")
    return x, y, heading


def _refuse_not_finite(walls: NDArray[np.float64], what: str) -> None:
    bad = ~np.isfinite(walls).all(axis=1)
    if bad.any():
        m = int(np.argmax(bad))
        raise MapError(f"{what} {m} is {tuple(walls[m].tolist())}; expected finite x0, y0, x1, y1 in metres")


def _refuse_too_large(rows: float, cols: float, side: float) -> None:
    # Also true of rows or columns that overflowed to inf or nan.
    tables = (rows // _TABLE_CELLS + 1) * (cols // _TABLE_CELLS + 1)
    if not (rows <= MOST_CELLS and cols <= MOST_CELLS and tables <= _MOST_TABLES):
        raise MapError(
            f"the map is {cols * side:.6g} m x {rows * side:.6g} m: too large for cells of {side:g} m; "
            "pass a coarser resolution, or leave out what lies far away"
        )


def _refuse_too_far(low: NDArray[np.float64], high: NDArray[np.float64], side: float) -> None:
    farthest = float(np.maximum(np.abs(low), np.abs(high)).max())
    if farthest > _FARTHEST_CELL:
        raise MapError(
            f"the map reaches to {farthest * side:.6g} m from the world's origin, where doubles do not tell "
            f"cells of {side:g} m apart; move it nearer"
        )


def _refuse_too_much_memory(
    walls: NDArray[np.float64], rows: int, cols: int, side: float, offset: tuple[int, int]
) -> None:
    needed = _grid_bytes(walls, rows, cols, side, offset)
    if needed <= _MOST_GRID_BYTES:
        return
    scale = 1.0  # of the cells, for as much as may be taken
    size = needed
    while size > _MOST_GRID_BYTES:
        scale *= 1.2
        corner = math.floor(offset[0] / scale), math.floor(offset[1] / scale)
        size = _grid_bytes(walls, math.ceil(rows / scale), math.ceil(cols / scale), side * scale, corner)
    length = float((np.abs(walls[:, 2] - walls[:, 0]) + np.abs(walls[:, 3] - walls[:, 1])).sum())
    raise MapError(
        f"{len(walls)} walls of {length:.6g} m in all, on a map of {cols * side:.6g} m x {rows * side:.6g} m, would "
        f"take about {needed / 1e9:.3g} GB in cells of {side:g} m; pass a resolution of {side * scale:.3g} m or coarser"
    )


def _grid_bytes(walls: NDArray[np.float64], rows: int, cols: int, side: float, offset: tuple[int, int]) -> float:
    """Upper bound of the memory [bytes] of the cells that walls touch: every wall counts its own pages."""
    low = np.minimum(walls[:, :2], walls[:, 2:]) / side - offset
    high = np.maximum(walls[:, :2], walls[:, 2:]) / side - offset
    size = 0.0
    for cells, each in ((_PAGE_CELLS, _PAGE_BYTES), (_TABLE_CELLS, _TABLE_BYTES)):
        # A wall along a grid line touches the cells on both sides of it, which may be in different pages.
        first, last = np.floor((np.ceil(low) - 1.0).clip(0.0) / cells), np.floor(high / cells)
        across, up = (last - first + 1.0).T
        straight = (walls[:, 0] == walls[:, 2]) | (walls[:, 1] == walls[:, 3])
        touched = float(np.where(straight, across * up, across + up).sum())
        width, height = cols // cells + 1, rows // cells + 1
        # The outside is occupied, so pages along the right and the upper edge are always needed.
        size += each * min(touched + width + height, width * height)
    return size
