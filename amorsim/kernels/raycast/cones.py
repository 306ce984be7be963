"""The nearest return within a cone of rays, as a sonar hears it, and the ray that it is on.

Where the map has line features, the walls about a place are put in order once for all cones there, and asked
(`amorsim.kernels.raycast.cone_walls`); without them, or where a cone has few cells, cells are
(`amorsim.kernels.raycast.cone_cells`). Each has the bits that all rays have.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid, is_occupied
from amorsim.kernels.grid.segments import RINGS, SegmentIndex, walls_about
from amorsim.kernels.raycast.cone_cells import SAFETY, WIDEST, ask_cells
from amorsim.kernels.raycast.cone_walls import AT_ONCE, ROOM, Cone, Eye, WallRoom, hear_walls
from amorsim.kernels.raycast.rays import cast_ray, cell_of, direction, to_frame

__all__ = ["cast_cones"]


_FEW = 8  # rays of a cone up to which all are cast
_CLOSE = 1e-4  # [rad] from one ray to the next, below which all are cast: bearings of walls are too rough then
_NEARBY = 1.0  # [m] added to the search for walls around one place, to serve the cones near it
_FINE = 400  # cells in the range; from here on, looking up walls is always faster than testing cells


@part
def _cast_all(
    grid: Grid, x: float, y: float, cos_h: float, sin_h: float, cos_b: Array, sin_b: Array, range_max: float
) -> tuple[float, int]:
    """The least distance of all rays, each cast, and the first ray that has it."""
    least, nearest, limit = np.inf, 0, range_max
    for k in range(cos_b.shape[1]):
        dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
        found = cast_ray(grid, x, y, dx, dy, limit)
        if not found >= least:  # less, or nan
            least, nearest, limit = found, k, found
    return least, nearest


@part
def _hear(
    grid: Grid,
    lines: SegmentIndex,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    cone: Cone,
    range_max: Array,
    room: WallRoom,
    out: Array,
    ray: Ints,
) -> None:
    """`cast_cones`, with room to work in."""
    half_angle, edge, cos_b, sin_b = cone
    wants_ray = ray.shape[0] > 0
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    resolution = grid.resolution
    rays = cos_b.shape[1]
    is_close = 2.0 * half_angle < _CLOSE * (rays - 1)
    has_lines = lines.walls.shape[1] > 0 and half_angle < WIDEST and rays > _FEW and not is_close
    # Where walls were put in order, how far out, and how many there are.
    here_x, here_y, here_reach, count = 0.0, 0.0, -1.0, 0
    for n in range(poses.shape[0]):
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        cos_h = math.cos(poses[n, 2] - yaw)
        sin_h = math.sin(poses[n, 2] - yaw)
        reach = range_max[n]
        inside = 0.0 <= x < grid.cols * resolution and 0.0 <= y < grid.rows * resolution
        is_fine = _FINE * resolution < reach
        if has_lines and inside and cos_h == cos_h:  # not of nan
            col = cell_of(x, resolution)
            row = cell_of(y, resolution)
            if is_occupied(grid, row, col):
                out[n] = 0.0
                if wants_ray:
                    ray[n] = 0
                continue
            aside = math.sqrt((x - here_x) * (x - here_x) + (y - here_y) * (y - here_y))
            if not aside + reach <= here_reach:
                here_x, here_y, here_reach, aside = x, y, reach + _NEARBY, 0.0
                count = walls_about(
                    lines, x, y, here_reach, room.found, room.about, room.away, room.candidates, room.rings
                )
            eye = Eye(x, y, col, row, cos_h, sin_h)
            casts = is_fine or wants_ray
            heard, least, nearest = hear_walls(
                grid, lines, eye, cone, reach, room, count, aside * (1.0 + SAFETY), casts
            )
            if heard:
                out[n] = least
                if wants_ray:
                    ray[n] = nearest
                continue
        if wants_ray:
            out[n], ray[n] = _cast_all(grid, x, y, cos_h, sin_h, cos_b, sin_b, reach)
        else:
            out[n] = ask_cells(grid, x, y, cos_h, sin_h, half_angle, edge, cos_b, sin_b, reach)


@kernel
def cast_cones(
    resolution: float,
    rows: int,
    cols: int,
    super_cols: int,
    supers: Ints32,
    tables: Ints32,
    pages: NDArray[np.uint64],
    free_room: NDArray[np.uint16],
    boxes: Array,
    first: Ints,
    segments: Array,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    half_angle: float,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
    ray: Ints,
) -> None:
    """Write the least distance [m] over the rays of each cone (N,), to the bit what `rays.cast` and a minimum give.

    Map, poses and `out` are those of `scans.cast_scans`; `cos_b` and `sin_b` (1, k) are cosine and sine of bearings
    that are evenly spread from -half_angle to half_angle, and `range_max` is (N,). `ray` (N,) gets the first ray that
    has the least, 0 where nothing is within the range; not written if it is empty.
    """
    cone = Cone(half_angle, np.array([math.cos(half_angle), math.sin(half_angle)]), cos_b, sin_b)
    grid = Grid(resolution, rows, cols, super_cols, supers, tables, pages, free_room)
    lines = SegmentIndex(boxes, first, segments)
    walls = segments.shape[1]
    f = np.empty(ROOM)
    room = WallRoom(
        np.empty(walls, dtype=np.int64),
        np.empty((6, walls + AT_ONCE)),
        np.empty(walls),
        np.empty(walls, dtype=np.int64),
        np.empty(RINGS + 2, dtype=np.int64),
        f,
        f.view(np.int64),
    )
    _hear(grid, lines, origin_x, origin_y, yaw, poses, cone, range_max, room, out, ray)
