"""A map: its occupied cells, its place in the world, and the walls that it was drawn from."""

from __future__ import annotations

import functools
import hashlib
import math
from collections.abc import Iterable, Sequence
from typing import Any, Self

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from amorsim.array_types import Array, Bools, Ints
from amorsim.core.arguments import checked, texts
from amorsim.core.display import in_notebook
from amorsim.core.errors import MapError
from amorsim.core.maps.map_limits import refuse_not_finite, refuse_too_far, refuse_too_large, refuse_too_much_memory
from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.grid import Grid, occupied_boxes
from amorsim.kernels.grid.outlines import MOST_STRIPS, outline_lines
from amorsim.kernels.grid.rasterise import grid_from_segments, snapped
from amorsim.kernels.grid.segment_boxes import index_segments, no_segments
from amorsim.kernels.grid.segments import SegmentIndex
from amorsim.kernels.raycast.rays import occupied_points
from amorsim.kernels.raycast.scans import cast_scans, sorted_beams

__all__ = ["Map", "drawn_alike"]

_MOST_BYTES = 10**9
_FARTHEST = 2.0**62  # of the cells that are looked up: beyond any map, and still a whole number of 64 bits

Window = tuple[float, float, float, float]
"""xmin, ymin, xmax, ymax [m]."""
Place = tuple[float, float, float]
"""x, y [m], heading [rad]."""
_Ends = tuple[Ints, Ints]


@attrs.frozen(kw_only=True, eq=False, repr=False)
class Map:
    """Cells of the plane, each free or occupied; outside the map everything is occupied.

    Made by `from_segments` or `from_array`. It never changes, so copies are the map itself.

    A cell may also be *unknown*. It is free or occupied all the same, and that alone is what rays and bodies meet.
    Starts are looked for among known cells, and writers and planners may ask for the unknown ones.
    """

    grid: Grid
    """The cells, as kernels read them; never written to."""
    origin: Place
    """The lower left corner in the world, and the map's rotation about it."""
    segments: Array | None = None
    """(M, 4) x0, y0, x1, y1 [m] in the world: the walls the cells were drawn from, or None."""
    segment_index: SegmentIndex = attrs.field(factory=no_segments)
    """Walls in the map's frame, as scans look them up: `segments`, or outlines of the cells; never written to."""
    unknown: Grid | None = None
    """The cells of which is not known whether they are free, as a grid in which they are set; None if all are known."""
    start: Place | None = None
    """The start pose of a robot that the map gives, in the world, or None."""
    warnings: tuple[str, ...] = ()
    """The parts of its file that were ignored, one message each."""
    name: str = ""
    source: Any = None
    """The file it was read from, with the loader and its options (`amorsim.scenario.files.maps.MapFile`), or None."""

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
        refuse_not_finite(walls, "segment")
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
        refuse_too_large(rows, cols, side)
        refuse_too_far(low, high, side)
        offset = (int(low[0]), int(low[1]))
        refuse_too_much_memory(walls, int(rows), int(cols), side, offset)
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
            warnings=texts(warnings, "warnings", "remarks"),
            name=name,
        )

    @classmethod
    def from_array(
        cls,
        array: ArrayLike,
        *,
        resolution: float,
        origin: Sequence[float] = (0.0, 0.0, 0.0),
        unknown: ArrayLike | None = None,
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
        unknown
            (rows, cols), not zero where a cell is unknown. `array` has what rays and bodies meet there.
        start
            x, y [m] and heading [rad] of a robot's start in the world.

        Raises
        ------
        MapError
            If a number is not finite, the resolution is not positive, or an array is not of two dimensions, is
            empty or of another shape than the other, the map lies too far from the world's origin, or its cells are
            noise, which takes more memory than any plan.
        """
        side = _resolution(resolution)
        place = _finite(origin, 3, "origin", "x, y in metres and yaw in radians")
        taken = _cells(array, "the array")
        rows, cols = taken.shape
        refuse_too_large(rows, cols, side)
        mask = None if unknown is None else _cells(unknown, "the array of unknown cells")
        if mask is not None and mask.shape != taken.shape:
            raise MapError(
                f"the array of unknown cells has shape {mask.shape}; expected that of the cells, {taken.shape}"
            )
        with np.errstate(over="ignore"):  # refused below
            low = np.array(place[:2]) / side
        refuse_too_far(low, low + np.array([cols, rows]), side)
        grid = grid_from_array(taken, side)
        return cls(
            grid=grid,
            segment_index=_outlines(grid, taken),
            origin=(place[0], place[1], place[2]),
            unknown=None if mask is None or not mask.any() else grid_from_array(mask, side),
            start=_start(start),
            warnings=texts(warnings, "warnings", "remarks"),
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
        return self._boxes(self.grid, window, resolution)

    def unknown_array(
        self, window: Sequence[float] | None = None, resolution: float | None = None
    ) -> NDArray[np.uint8]:
        """Which cells are unknown, 1 where they are, as `to_array` gives the occupied ones.

        A coarser cell is unknown if any cell in it is. Outside the map nothing is known.
        """
        if self.unknown is None:
            rows, cols, _, _ = self._spans(window, resolution)
            return np.zeros((rows, cols), dtype=np.uint8)
        return self._boxes(self.unknown, window, resolution)

    def _boxes(self, grid: Grid, window: Sequence[float] | None, resolution: float | None) -> NDArray[np.uint8]:
        rows, cols, row_ends, col_ends = self._spans(window, resolution)
        out = np.empty((rows, cols), dtype=np.uint8)
        occupied_boxes(grid, *row_ends, *col_ends, out)
        return out

    def _spans(self, window: Sequence[float] | None, resolution: float | None) -> tuple[int, int, _Ends, _Ends]:
        """Rows and columns of an array of a window, and the first and last cells of the map in each."""
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
        # There is a cell even where the window is so much smaller that it snaps to none.
        cols, rows = np.maximum(np.ceil(snapped(np.array([wide, high]))), 1.0).astype(int).tolist()
        return rows, cols, self._fine(ymin, side, rows), self._fine(xmin, side, cols)

    def _fine(self, low: float, side: float, count: int) -> _Ends:
        """First and last cell of the map in each of `count` spans of `side` [m], from `low` [m] on."""
        with np.errstate(over="ignore"):  # limited next
            edges = (low + np.arange(count + 1, dtype=np.float64) * side) / self.resolution
        edges = snapped(np.clip(edges, -_FARTHEST, _FARTHEST))
        first = np.floor(edges[:-1]).astype(np.int64)
        last = np.ceil(edges[1:]).astype(np.int64) - 1
        return first, np.maximum(first, last)

    @checked
    def occupied(self, points: ArrayLike) -> Bools:
        """Whether each of the points (M, 2) [m] of the world is in an occupied cell; nan and outside are."""
        places = np.ascontiguousarray(points, dtype=np.float64)
        if places.ndim != 2 or places.shape[1] != 2:
            raise MapError(f"points have shape {places.shape}; expected (M, 2): x, y in metres")
        out = np.empty(len(places), dtype=np.bool_)
        occupied_points(self.grid, *self.origin, places, out)
        return out

    @checked
    def cast_rays(self, poses: ArrayLike, bearings: ArrayLike, range_max: float) -> Array:
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
        walls = *self.grid, *self.segment_index, *self.origin
        given: Any = *walls, places, *sorted_beams(cosines, sines, len(places)), reach, out
        cast_scans(*given)
        return out

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Map):
            return NotImplemented
        return self is other or (self._said() == other._said() and self._fingerprint == other._fingerprint)

    def __hash__(self) -> int:
        return hash(self._said())

    def _said(self) -> tuple[object, ...]:
        return self.resolution, self.shape, self.origin, self.start, self.warnings, self.name

    @functools.cached_property
    def _fingerprint(self) -> bytes:
        """A digest of walls and cells. Equal maps are compared again and again where a map is the key of a table."""
        digest = hashlib.blake2b(digest_size=32)
        # The same walls in the same order number pages alike, so the arrays themselves can be compared.
        grids = [() if grid is None else (grid.supers, grid.tables, grid.pages) for grid in (self.grid, self.unknown)]
        for arrays in ((() if self.segments is None else (self.segments + 0.0,)), *grids):  # -0.0 is 0.0
            digest.update(repr([(array.dtype.str, array.shape) for array in arrays]).encode())
            for array in arrays:
                digest.update(np.ascontiguousarray(array).data)
        return digest.digest()

    def __copy__(self) -> Self:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return self

    _repr_mimebundle_ = in_notebook

    def __repr__(self) -> str:
        rows, cols = self.shape
        return f"Map({self.name!r}, {rows} x {cols} cells of {self.resolution:g} m, origin {self.origin})"


def drawn_alike(one: Grid | None, other: Grid | None) -> bool:
    """Whether two grids have the same cells in the same pages; their order of drawing decides about pages."""
    if one is None or other is None:
        return one is other
    pairs = ((one.supers, other.supers), (one.tables, other.tables), (one.pages, other.pages))
    return all(np.array_equal(mine, its) for mine, its in pairs)


def _cells(given: ArrayLike, what: str) -> NDArray[np.uint8]:
    """An array that is 0 where the given one is 0; without a copy if possible."""
    try:
        cells = np.asarray(given)
    except ValueError:
        raise MapError(f"{what} has rows of different lengths; expected (rows, cols), a number for each cell") from None
    if cells.ndim != 2 or cells.size == 0:
        raise MapError(f"{what} has shape {cells.shape}; expected (rows, cols), at least one of each")
    if cells.dtype.kind not in "buif":
        raise MapError(f"{what} holds {cells.dtype}; expected numbers, 0 where a cell is free")
    if cells.dtype.kind == "f" and np.isnan(cells).any():
        raise MapError(f"{what} has nan in it; expected numbers, 0 where a cell is free")
    if cells.dtype not in (np.uint8, np.bool_):
        cells = cells != 0
    # Kernels are compiled for arrays that may be written to, and none of them writes to this one.
    return np.require(cells, requirements=["C", "W"]).view(np.uint8)


def _outlines(grid: Grid, cells: NDArray[np.uint8]) -> SegmentIndex:
    try:
        return outline_lines(grid, cells)
    except OverflowError as error:
        raise MapError(
            f"free and occupied cells alternate as in noise: their outlines are more than {MOST_STRIPS} lines; smooth "
            "or shrink the picture, or choose another threshold"
        ) from error


def _resolution(given: float) -> float:
    try:
        side = float(given)
    except (TypeError, ValueError, OverflowError):
        side = math.nan
    if not (math.isfinite(side) and side > 0.0):
        raise MapError(f"resolution is {given!r}; expected a positive number of metres, such as 0.001")
    return side


def _numbers(given: ArrayLike, what: str) -> Array:
    try:
        return np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
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
