"""The nearest return within a cone of rays: what a sonar hears first.

Where the map has line features, they bound every ray from below (`amorsim.kernels.lines`): the few rays that could be
the nearest by these bounds are cast, from where all are free, and mostly that is one, square to a wall or at its end.
The walls about a place are put in order once for all cones there, and those behind what is heard are passed over.

Without lines cells are asked.
The least distance over all rays is the least over all pairs of a ray and an occupied cell it enters, so the cells can
be asked instead of the rays. A few rays say how far away the nearest wall is at most; then only occupied cells nearer
than that count, and few are, for a wall that is met squarely leaves a sliver of them, and one that is met at a slant
is nearest at an edge of the cone, which is among the few. Whether a ray enters a cell, and at what distance, is told by
the same quotients that walking along it compares, so the result has the same bits.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid import NONE, ONE, Grid, is_occupied, word_at
from amorsim.kernels.lines import FACE, INSIDE, PASSED, RINGS, Lines, side_of, walls_about
from amorsim.kernels.rays import cast_ray, cell_of, direction, march, rounding, to_frame

__all__ = ["cast_cones"]

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_COARSE = 100  # every so many rays one is cast
_WIDEST = 1.5  # [rad] half a cone's angle; wider ones are cast ray by ray
_FEW = 8  # rays of a cone up to which all are cast
_STEPS = 12  # cells that a ray walks before it jumps
_NEARBY = 1.0  # [m] from one place walls are looked for so much farther out than need be, to serve cones beside it
_MOST = 64  # walls that a cone may hear
_FINE = 400  # cells in the range, from which on looking up walls is sooner done than asking cells
_NEXT = 0.05  # [rays] within which a wall that ends beside a ray counts as met; so rough are bearings
_AT_ONCE = 32  # walls that are looked at together
_SAFETY = 1e-9  # relative, on every bound that leaves something out


@part
def _entry(cell: int, own: int, resolution: float, start: float, component: float) -> float:
    """Where a ray from cell `own` of an axis comes into `cell`: -inf if it is there, inf if it never gets there."""
    if cell == own:
        return -np.inf
    if (component > 0.0) != (cell > own) or component == 0.0:
        return np.inf
    line = cell if cell > own else cell + 1
    return (line * resolution - start) / component


@part
def _exit(cell: int, resolution: float, start: float, component: float) -> float:
    """Where a ray leaves `cell` of an axis for good."""
    if component == 0.0:
        return np.inf
    line = cell + 1 if component > 0.0 else cell
    return (line * resolution - start) / component


@part
def _least_into(
    row: int,
    col: int,
    own_row: int,
    own_col: int,
    resolution: float,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    cos_b: Floats,
    sin_b: Floats,
    least: float,
) -> float:
    """The less of `least` and the distance at which any ray of the cone enters a cell."""
    rays = cos_b.shape[1]
    away_x = (col + 0.5) * resolution - x
    away_y = (row + 0.5) * resolution - y
    distance = math.sqrt(away_x * away_x + away_y * away_y)
    corner = 0.7072 * resolution  # from the middle of a cell, and a little
    first, last = 0, rays - 1
    if distance > 1.001 * corner:
        spread = math.asin(corner / distance)
        bearing = math.atan2(cos_h * away_y - sin_h * away_x, cos_h * away_x + sin_h * away_y)
        step = 2.0 * half_angle / (rays - 1)
        first = max(first, math.ceil((bearing - spread + half_angle) / step - 1e-3))
        last = min(last, math.floor((bearing + spread + half_angle) / step + 1e-3))
    for k in range(first, last + 1):
        dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
        into_x = _entry(col, own_col, resolution, x, dx)
        into_y = _entry(row, own_row, resolution, y, dy)
        # It gets into the cell if neither axis leaves it before the other is in; where both happen at once, x is first.
        into = max(into_x, into_y)
        if into < least and into_x <= _exit(row, resolution, y, dy) and into_y < _exit(col, resolution, x, dx):
            least = into
    return least


@part
def _is_near(x0: float, y0: float, side: float, cos_h: float, sin_h: float, edge: Floats, least: float) -> bool:
    """Whether a square, its lower left corner at (x0, y0) from the cone's point, may hold something nearer in the cone.

    `edge` holds cosine and sine of half the cone's angle.
    """
    near_x = max(x0, 0.0, -(x0 + side))
    near_y = max(y0, 0.0, -(y0 + side))
    # Where the cone's point all but touches something, roundings of places count too.
    within = least + _SAFETY * side
    if near_x * near_x + near_y * near_y > within * within * (1.0 + _SAFETY):
        return False
    middle_x = x0 + 0.5 * side
    middle_y = y0 + 0.5 * side
    ahead = cos_h * middle_x + sin_h * middle_y
    left = cos_h * middle_y - sin_h * middle_x
    outside = abs(left) * edge[0] - ahead * edge[1]
    return bool(outside <= 0.7072 * side + _SAFETY * (abs(ahead) + abs(left)))


@part
def _nearest(
    grid: Grid,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Floats,
    cos_b: Floats,
    sin_b: Floats,
    least: float,
) -> float:
    """The less of `least` and the distance to what else is in the cone, page by page, word by word, cell by cell."""
    resolution = grid.resolution
    own_row = cell_of(y, resolution)
    own_col = cell_of(x, resolution)
    # The box of the cone's sector: its point, the ends of its edges, and where its arc is farthest along an axis.
    low_x, high_x, low_y, high_y = 0.0, 0.0, 0.0, 0.0
    for side in (-1.0, 1.0):
        end_x = least * (cos_h * edge[0] - side * sin_h * edge[1])
        end_y = least * (sin_h * edge[0] + side * cos_h * edge[1])
        low_x, high_x = min(low_x, end_x), max(high_x, end_x)
        low_y, high_y = min(low_y, end_y), max(high_y, end_y)
    if cos_h >= edge[0]:
        high_x = least
    if -cos_h >= edge[0]:
        low_x = -least
    if sin_h >= edge[0]:
        high_y = least
    if -sin_h >= edge[0]:
        low_y = -least
    page = 64.0 * resolution
    word = 8.0 * resolution
    first_col = math.floor((x + low_x) / page - 1e-6)
    last_col = math.floor((x + high_x) / page + 1e-6)
    first_row = math.floor((y + low_y) / page - 1e-6)
    last_row = math.floor((y + high_y) / page + 1e-6)
    for page_row in range(first_row, last_row + 1):
        page_col = first_col - 1
        skip: Any = 1
        while page_col + skip <= last_col:
            page_col += skip
            skip = 1
            held: Any = 0  # wholly occupied, as outside the map
            if page_row >= 0 and page_col >= 0 and page_row * 64 < grid.rows and page_col * 64 < grid.cols:
                # What is free says how far it is free to the right, in its own units.
                table: Any = grid.supers[(page_row >> 6) * grid.super_cols + (page_col >> 6)]
                if table < 0:
                    skip = max(1, ((page_col >> 6) + np.int64(table & 127)) * 64 - page_col)
                    continue
                held = grid.tables[table, (page_row & 63) * 64 + (page_col & 63)]
                if held < 0:
                    skip = max(1, np.int64(held & 127))
                    continue
            if not _is_near(page_col * page - x, page_row * page - y, page, cos_h, sin_h, edge, least):
                continue
            for block_row in range(8 * page_row, 8 * page_row + 8):
                for block_col in range(8 * page_col, 8 * page_col + 8):
                    bits = grid.pages[held, (block_row & 7) * 8 + (block_col & 7)]
                    if bits == NONE or not _is_near(
                        block_col * word - x, block_row * word - y, word, cos_h, sin_h, edge, least
                    ):
                        continue
                    for bit in range(64):
                        if not (bits >> np.uint64(bit)) & ONE:
                            continue
                        row = 8 * block_row + (bit >> 3)
                        col = 8 * block_col + (bit & 7)
                        if _is_near(col * resolution - x, row * resolution - y, resolution, cos_h, sin_h, edge, least):
                            least = _least_into(
                                row,
                                col,
                                own_row,
                                own_col,
                                resolution,
                                x,
                                y,
                                cos_h,
                                sin_h,
                                half_angle,
                                cos_b,
                                sin_b,
                                least,
                            )
    return least


@part
def _look_along(
    ends: Floats,
    start: int,
    stop: int,
    x: float,
    y: float,
    left_x: float,
    left_y: float,
    right_x: float,
    right_y: float,
    maybe: NDArray[np.uint8],
) -> None:
    """Write whether walls start..stop-1 may be in a cone: not wholly beyond one of its edges.

    `ends` is of `lines.walls_about`; (left_x, left_y) and (right_x, right_y) are square to the edges, outward.
    """
    for i in range(start, stop):
        x0 = ends[0, i] - x
        y0 = ends[1, i] - y
        x1 = ends[2, i] - x
        y1 = ends[3, i] - y
        left = min(left_x * x0 + left_y * y0, left_x * x1 + left_y * y1)
        right = min(right_x * x0 + right_y * y0, right_x * x1 + right_y * y1)
        maybe[i - start] = max(left, right) <= ends[4, i]


@part
def _bearing(x: float, y: float) -> float:
    """The angle [rad] of a direction, to 4e-6: good for telling which rays are about it.

    The arc tangent of z up to 1 is z times a polynomial in z * z, here fitted at Chebyshev's points.
    """
    low = min(abs(x), abs(y))
    high = max(abs(x), abs(y))
    z = low / high if high > 0.0 else 0.0
    w = z * z
    angle = 0.05733179602962784 - 0.01342247840194614 * w
    angle = 0.19558996708261733 + w * (-0.12111113029350314 + w * angle)
    angle = z * (0.9999955182994817 + w * (-0.3329888274017294 + w * angle))
    if abs(y) > abs(x):
        angle = 0.5 * math.pi - angle
    if x < 0.0:
        angle = math.pi - angle
    return angle if y >= 0.0 else -angle


@part
def _rays_between(
    x0: float, y0: float, x1: float, y1: float, half_angle: float, step: float, rays: int
) -> tuple[int, int]:
    """First and last ray of a cone from one direction anticlockwise to another; the last before the first if none."""
    low = _bearing(x0, y0)
    high = _bearing(x1, y1)
    if high < low:
        if high >= -half_angle - step:
            low -= 2.0 * math.pi
        else:
            high += 2.0 * math.pi
    first = max(math.ceil((low + half_angle) / step - _NEXT), 0.0)
    last = min(math.floor((high + half_angle) / step + _NEXT), rays - 1.0)
    return int(first), int(last)


@part
def _crosses(a: float, b: float, near: float, start: float, stop: float, margin: float, dx: float, dy: float) -> bool:
    """Whether a ray goes through a wall's rectangle from one long side to the other, so that it must meet the wall."""
    # How far along the wall it gets for each metre across; the wall itself ends short of its rectangle.
    slope = (a * dy - b * dx) / (a * dx + b * dy)
    first = near * slope
    last = (near + 2.0 * margin) * slope
    return bool(min(first, last) > start + 3.0 * margin and max(first, last) < stop - 3.0 * margin)


@part
def _walk(grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, range_max: float) -> float:
    """Distance along a ray from a free cell that it comes to, a few cells before what it meets: cell by cell at first.

    By definition (`amorsim.kernels.rays`); for so few cells that takes less than to make ready for jumps.
    """
    resolution = grid.resolution
    # From a cell to the line ahead, and to the next cell.
    ahead_x = 1 if dx > 0.0 else 0
    ahead_y = 1 if dy > 0.0 else 0
    step_x = 1 if dx > 0.0 else -1
    step_y = 1 if dy > 0.0 else -1
    tx = ((col + ahead_x) * resolution - x) / dx if dx != 0.0 else np.inf
    ty = ((row + ahead_y) * resolution - y) / dy if dy != 0.0 else np.inf
    block_col = col >> 3
    block_row = row >> 3
    word: Any = word_at(grid, block_row, block_col)
    for _ in range(_STEPS):
        if tx <= ty and dx != 0.0:
            distance = tx
            col += step_x
            tx = ((col + ahead_x) * resolution - x) / dx
        else:
            distance = ty
            row += step_y
            ty = ((row + ahead_y) * resolution - y) / dy if dy != 0.0 else np.inf
        if col >> 3 != block_col or row >> 3 != block_row:
            block_col = col >> 3
            block_row = row >> 3
            word = word_at(grid, block_row, block_col)
        if (word >> np.uint64((row & 7) * 8 + (col & 7))) & ONE:
            return distance + 0.0 if distance <= range_max else np.inf
    return march(grid, x, y, col, row, dx, dy, range_max)


@part
def _cast_from(
    grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, free: float, range_max: float
) -> float:
    """Distance along a ray that is free so far [m] at least, from (x, y) in the free cell (row, col)."""
    inverse = 1.0 / grid.resolution
    place_x = (x + free * dx) * inverse
    place_y = (y + free * dy) * inverse
    start_col = math.floor(place_x)
    start_row = math.floor(place_y)
    part_x = place_x - start_col
    part_y = place_y - start_row
    doubt = 2.0 * rounding(grid, 1.0, 1.0)
    if doubt < part_x < 1.0 - doubt and doubt < part_y < 1.0 - doubt:
        return _walk(grid, x, y, int(start_col), int(start_row), dx, dy, range_max)
    return march(grid, x, y, col, row, dx, dy, range_max)


@part
def _hear(
    grid: Grid,
    lines: Lines,
    x: float,
    y: float,
    col: int,
    row: int,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: float,
    found: Integers,
    ends: Floats,
    away: Floats,
    count: int,
    aside: float,
    maybe: NDArray[np.uint8],
    walls: Floats,
    spans: Integers,
) -> tuple[bool, float]:
    """The least over all rays, from a free cell, by the walls about it; or False where they cannot tell.

    The first `count` of `found`, `ends` and `away` are of `lines.walls_about`, told from `aside` [m] of here.
    `walls` (most, 3) and `spans` (most, 3) are room for what of them may be heard: the line that bounds rays, and how
    near it comes; first and last ray, and the one to which it is nearest.
    """
    rays = cos_b.shape[1]
    step = 2.0 * half_angle / (rays - 1)
    # Nothing farther than this is heard: out of range, or behind a wall that fills the way.
    most = range_max * (1.0 + _SAFETY)
    held = 0
    # Square to the edges, outward.
    left_x = -sin_h * edge[0] - cos_h * edge[1]
    left_y = cos_h * edge[0] - sin_h * edge[1]
    right_x = sin_h * edge[0] - cos_h * edge[1]
    right_y = -cos_h * edge[0] - sin_h * edge[1]
    for chunk in range(0, count, _AT_ONCE):
        if away[chunk] - aside > most:
            break
        following = min(count, chunk + _AT_ONCE)
        _look_along(ends, chunk, following, x, y, left_x, left_y, right_x, right_y, maybe)
        for i in range(chunk, following):
            if not maybe[i - chunk]:
                continue
            m = found[i]
            what, a, b, x0, y0, x1, y1, near, start, stop = side_of(lines.walls, m, x, y, cos_h, sin_h, most)
            if what == PASSED:
                continue
            if what == INSIDE:
                return False, 0.0
            beside = max(start, -stop, 0.0)
            if near > 0.0 and near * near + beside * beside > most * most:
                continue
            first, last = _rays_between(x0, y0, x1, y1, half_angle, step, rays)
            if first > last:
                continue
            # The nearness of the line is a sine over the rays, and less than half of its turn is here.
            best = first
            if a * sin_b[0, first] < b * cos_b[0, first]:
                best = last
                if a * sin_b[0, last] > b * cos_b[0, last]:
                    best = min(max(int(np.rint((_bearing(a, b) + half_angle) / step)), first), last)
            dx = cos_b[0, best]
            dy = sin_b[0, best]
            nearness = a * dx + b * dy
            if nearness * most < 1.0:
                continue
            if held == walls.shape[0]:
                return False, 0.0
            walls[held, 0] = a
            walls[held, 1] = b
            walls[held, 2] = nearness
            spans[held, 0] = first
            spans[held, 1] = last
            spans[held, 2] = best
            held += 1
            margin = lines.walls[m, 5]
            if what == FACE and _crosses(a, b, near, start, stop, margin, dx, dy):
                most = min(most, (1.0 + 2.0 * margin / near) / nearness * (1.0 + _SAFETY))
    least = np.inf
    if held == 0:
        return True, least
    limit = range_max * (1.0 + _SAFETY)
    for _ in range(held):
        nearest = 0
        for i in range(1, held):
            if walls[i, 2] > walls[nearest, 2]:
                nearest = i
        a = walls[nearest, 0]
        b = walls[nearest, 1]
        nearness = walls[nearest, 2]
        if nearness * min(least, limit) * (1.0 + _SAFETY) < 1.0:
            break
        free = (1.0 - _SAFETY) / nearness
        # From the nearest ray outward to either side, as far as the bound stays below what was found.
        for way in (-1, 1):
            k = spans[nearest, 2] + (way + 1) // 2
            while spans[nearest, 0] <= k <= spans[nearest, 1]:
                if (a * cos_b[0, k] + b * sin_b[0, k]) * min(least, limit) * (1.0 + _SAFETY) < 1.0:
                    break
                dx, dy = direction(cos_h, sin_h, cos_b[0, k], sin_b[0, k])
                least = min(least, _cast_from(grid, x, y, col, row, dx, dy, free, range_max))
                k += way
        walls[nearest, 2] = -np.inf
    return True, least


@part
def _ask(
    grid: Grid,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    half_angle: float,
    edge: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: float,
) -> float:
    """The least over all rays by a few of them, and then by cells; by all rays where cones are wide."""
    rays = cos_b.shape[1]
    stride = _COARSE if half_angle < _WIDEST and rays > 2 else 1
    least = np.inf
    limit = range_max
    for k in range(0, rays - 1 + stride, stride):
        beam = min(k, rays - 1)
        dx, dy = direction(cos_h, sin_h, cos_b[0, beam], sin_b[0, beam])
        found = cast_ray(grid, x, y, dx, dy, limit)
        if not found >= least:  # less, or nan
            least = found
            limit = found
    if stride > 1 and least > 0.0:
        # With no wall on any of the few rays the range is the bound, and what is just there still counts.
        bound = least if least <= limit else np.nextafter(limit, np.inf)
        nearest = _nearest(grid, x, y, cos_h, sin_h, half_angle, edge, cos_b, sin_b, bound)
        if nearest <= limit:
            least = nearest
    return least


@kernel
def cast_cones(
    grid: Grid,
    lines: Lines,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Floats,
    half_angle: float,
    cos_b: Floats,
    sin_b: Floats,
    range_max: Floats,
    out: Floats,
) -> None:
    """Write the least distance [m] over the rays of each cone (N,), to the bit what `rays.cast` and a minimum give.

    Arguments are those of `scans.cast_scans`, with the bearings (1, k), evenly spread from -half_angle to half_angle,
    and `range_max` (N,).
    """
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    resolution = grid.resolution
    edge = np.array([math.cos(half_angle), math.sin(half_angle)])
    has_lines = lines.walls.shape[0] > 0 and half_angle < _WIDEST and cos_b.shape[1] > _FEW
    found = np.empty(lines.walls.shape[0], dtype=np.int64)
    following = np.empty(lines.walls.shape[0], dtype=np.int64)
    ends = np.empty((5, lines.walls.shape[0]))
    away = np.empty(lines.walls.shape[0])
    rings = np.empty(RINGS + 2, dtype=np.int64)
    maybe = np.empty(_AT_ONCE, dtype=np.uint8)
    walls = np.empty((_MOST, 3))
    spans = np.empty((_MOST, 3), dtype=np.int64)
    # Where walls were put in order, how far out, and how many there are.
    here_x, here_y, here_reach, count = 0.0, 0.0, -1.0, 0
    for n in range(poses.shape[0]):
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        cos_h = math.cos(poses[n, 2] - yaw)
        sin_h = math.sin(poses[n, 2] - yaw)
        reach = range_max[n]
        inside = 0.0 <= x < grid.cols * resolution and 0.0 <= y < grid.rows * resolution
        if has_lines and inside and _FINE * resolution < reach and cos_h == cos_h:  # not of nan
            col = cell_of(x, resolution)
            row = cell_of(y, resolution)
            if is_occupied(grid, row, col):
                out[n] = 0.0
                continue
            aside = math.sqrt((x - here_x) * (x - here_x) + (y - here_y) * (y - here_y))
            if not aside + reach <= here_reach:
                here_x, here_y, here_reach, aside = x, y, reach + _NEARBY, 0.0
                count = walls_about(lines, x, y, here_reach, found, ends, away, following, rings)
            heard, least = _hear(
                grid,
                lines,
                x,
                y,
                col,
                row,
                cos_h,
                sin_h,
                half_angle,
                edge,
                cos_b,
                sin_b,
                reach,
                found,
                ends,
                away,
                count,
                aside * (1.0 + _SAFETY),
                maybe,
                walls,
                spans,
            )
            if heard:
                out[n] = least
                continue
        out[n] = _ask(grid, x, y, cos_h, sin_h, half_angle, edge, cos_b, sin_b, reach)
