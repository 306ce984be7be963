"""Exact ray casting: where a ray enters the first occupied cell, found in a few jumps.

The definition, which `tests/naive.py` walks cell by cell. In the map's frame a ray starts at (x, y) in
direction (dx, dy). It meets grid line i of an axis at ``(i * resolution - start) / direction``; a zero
component meets no line of its axis. The lines of both axes are crossed in the order of these computed
numbers, x first on a tie. Each axis's numbers never decrease along the ray, so the crossing that leaves a box
of free cells says how many lines of the other axis were crossed before it: those whose number is smaller (or
equal, where x goes first). That makes a jump as exact as a walk.

Most jumps need no division. Working in cells, with a reciprocal of the direction, the crossings are known to
within `slack`; only where two numbers, or a place and a grid line, are closer than that are the defining
quotients computed. A distance is always the defining quotient.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import ONE, Grid, is_occupied, word_mask

__all__ = ["cast", "cast_ray", "cell_of", "direction", "march", "occupied_points", "rounding", "to_frame"]

FLAT = 1e-100
"""A component below this has a reciprocal that says nothing; quotients decide every step of such a ray."""


@kernel
def to_frame(x: float, y: float, origin_x: float, origin_y: float, cos_yaw: float, sin_yaw: float) -> Any:
    """World coordinates [m] in the frame of a map: moved by its origin, then turned back by its yaw."""
    x -= origin_x
    y -= origin_y
    if sin_yaw == 0.0 and cos_yaw == 1.0:
        return x, y
    return cos_yaw * x + sin_yaw * y, cos_yaw * y - sin_yaw * x


@kernel
def direction(cos_h: float, sin_h: float, cos_b: float, sin_b: float) -> Any:
    """Direction (dx, dy) of a beam at a bearing b from a heading h."""
    return cos_h * cos_b - sin_h * sin_b, sin_h * cos_b + cos_h * sin_b


@kernel
def cell_of(start: float, resolution: float) -> int:
    """Cell i with ``i * resolution <= start < (i + 1) * resolution``, as computed; `start` is in the map."""
    i = math.floor(start / resolution)
    while i * resolution > start:
        i -= 1
    while (i + 1) * resolution <= start:
        i += 1
    return i


@kernel
def _meets(line: int, resolution: float, start: float, component: float) -> float:
    """The distance at which a ray meets a grid line, by definition."""
    if component == 0.0:
        return np.inf
    return (line * resolution - start) / component


@kernel
def _crossed(
    at: float, with_equal: bool, cell: int, exit_line: int, resolution: float, start: float, component: float
) -> int:
    """The cell of one axis at distance `at` along a ray: lines met before are crossed, with `with_equal` also at it.

    The line `exit_line` is known not to be, so the answer lies between `cell` and it.
    """
    if component == 0.0:
        return cell
    up = component > 0.0
    low = cell if up else exit_line
    high = exit_line - 1 if up else cell
    guess = (start + at * component) / resolution
    if guess >= high:
        i = high
    elif guess > low:
        i = int(guess)
    else:
        i = low
    # The line by which cell i was entered must be crossed, and the line ahead must not be.
    while i != cell:
        t = _meets(i if up else i + 1, resolution, start, component)
        if t < at or (with_equal and t == at):
            break
        i += -1 if up else 1
    while i != (high if up else low):
        t = _meets(i + 1 if up else i, resolution, start, component)
        if not (t < at or (with_equal and t == at)):
            break
        i += 1 if up else -1
    return i


@kernel
def _leave(
    resolution: float, x: float, y: float, dx: float, dy: float, col: int, row: int, line_x: int, line_y: int
) -> Any:
    """`(col, row, by_x)` of the cell a ray comes to by one of two lines out of a box, from the quotients."""
    tx = _meets(line_x, resolution, x, dx)
    ty = _meets(line_y, resolution, y, dy)
    # Quotients overflow for all but vanishing components: both may be inf, also that of no line at all.
    if tx <= ty and dx != 0.0:
        row = _crossed(tx, False, row, line_y, resolution, y, dy)
        return (line_x if dx > 0.0 else line_x - 1), row, True
    col = _crossed(ty, True, col, line_x, resolution, x, dx)
    return col, (line_y if dy > 0.0 else line_y - 1), False


@kernel
def _axis(start: float, component: float, error: float) -> Any:
    """`(inverse, offset, slack)`: line i is crossed at ``i * inverse + offset``, in cells ± `slack`."""
    if abs(component) > FLAT:
        inverse = 1.0 / component
        return inverse, -start * inverse, 2.0 * error * abs(inverse)
    return 0.0, np.inf, 0.0 if component == 0.0 else np.inf


@kernel
def rounding(grid: Grid, dx: float, dy: float) -> float:
    """Bound [cells] on the error of an estimated coordinate: 32 roundings of the largest one there is.

    All roundings on the way to an estimate and to the quotient it stands for add up to less than 20.
    """
    return 2.0**-48 * max(grid.rows, grid.cols) * (1.0 + abs(dx) + abs(dy))


@kernel
def march(grid: Grid, x: float, y: float, col: int, row: int, dx: float, dy: float, range_max: float) -> float:
    """Distance [m] from (x, y) to the first occupied cell; inf if out of range.

    (row, col) is the cell of (x, y), or any that the ray comes to before the one sought: a free one.
    """
    resolution = grid.resolution
    if dx == 0.0 and dy == 0.0:
        return np.inf
    error = rounding(grid, dx, dy)
    start_x = x / resolution
    start_y = y / resolution
    limit = range_max / resolution * (1.0 + 1e-9)
    inverse_x, offset_x, slack_x = _axis(start_x, dx, error)
    inverse_y, offset_y, slack_y = _axis(start_y, dy, error)
    slack = slack_x + slack_y
    left = dx < 0.0
    down = dy < 0.0
    quadrant = (1 if left else 0) + (2 if down else 0)
    step_x = -1 if left else 1
    step_y = -1 if down else 1
    # From a cell to the line ahead of it, and between lines.
    ahead_x = 0 if left else 1
    ahead_y = 0 if down else 1
    inverse_size_x = abs(inverse_x)
    inverse_size_y = abs(inverse_y)
    # From a line that is crossed to the cell behind it.
    back_x = -1 if left else 0
    back_y = -1 if down else 0
    by_x = True
    while True:
        if col < 0 or row < 0 or col >= grid.cols or row >= grid.rows:
            break
        word: Any = np.uint64(0)
        entry: Any = np.int64(grid.supers[np.uint64((row >> 12) * grid.super_cols + (col >> 12))])
        shift = 12
        if entry < 0:
            side = ((entry >> (7 * quadrant)) & 127) << 12
        else:
            entry = np.int64(grid.tables[np.uint64(entry), np.uint64(((row >> 6) & 63) * 64 + ((col >> 6) & 63))])
            if entry < 0:
                shift = 6
                side = ((entry >> (7 * quadrant)) & 127) << 6
            else:
                shift = 3
                at = np.uint64(((row >> 3) & 7) * 8 + ((col >> 3) & 7))
                page = np.uint64(entry)
                word = grid.pages[page, at]
                side = ((np.int64(grid.room[page, at]) >> (4 * quadrant)) & 15) << 3
                if word:
                    if (word >> np.uint64((row & 7) * 8 + (col & 7))) & ONE:
                        break
                    side = 8
        unit = 1 << shift
        # Lines by which the square is left: those beyond its far corner.
        line_x = (col & -unit) + (unit - side if left else side)
        line_y = (row & -unit) + (unit - side if down else side)
        tx = line_x * inverse_x + offset_x
        ty = line_y * inverse_y + offset_y
        old_col, old_row = col, row
        by_x = tx <= ty
        t = tx if by_x else ty
        # Where the crossing lies on the other axis.
        place = start_y + t * dy if by_x else start_x + t * dx
        doubt = slack_x if by_x else slack_y
        other: Any = np.int64(place)
        part = place - other
        if abs(tx - ty) > slack and doubt < part < 1.0 - doubt:
            col = line_x + back_x if by_x else other
            row = other if by_x else line_y + back_y
        else:
            col, row, by_x = _leave(resolution, x, y, dx, dy, old_col, old_row, line_x, line_y)
        if not word:
            # Which line was met first may have been in doubt, so both slacks count.
            if t - slack > limit:
                return np.inf
            continue
        # The word has occupied cells: is one in the box that holds the way through?
        last_col = col - step_x if by_x else col
        last_row = row if by_x else row - step_y
        box = word_mask(
            min(old_row, last_row) & 7,
            min(old_col, last_col) & 7,
            max(old_row, last_row) & 7,
            max(old_col, last_col) & 7,
        )
        if not word & box:
            continue
        # Then cell by cell, as far as the jump went short of its last step, which leaves the word.
        bit = (old_row & 7) * 8 + (old_col & 7)
        tx = (old_col + ahead_x) * inverse_x + offset_x
        ty = (old_row + ahead_y) * inverse_y + offset_y
        hit = False
        walk_x = by_x
        for _ in range(abs(col - old_col) + abs(row - old_row) - 1):
            if abs(tx - ty) > slack:
                walk_x = tx <= ty
            else:
                line_x = (old_col & -8) + (bit & 7) + ahead_x
                line_y = (old_row & -8) + (bit >> 3) + ahead_y
                walk_x = dx != 0.0 and _meets(line_x, resolution, x, dx) <= _meets(line_y, resolution, y, dy)
            tx += inverse_size_x if walk_x else 0.0
            ty += 0.0 if walk_x else inverse_size_y
            bit += step_x if walk_x else step_y * 8
            if (word >> np.uint64(bit)) & ONE:
                hit = True
                break
        if hit:
            col = (old_col & -8) + (bit & 7)
            row = (old_row & -8) + (bit >> 3)
            by_x = walk_x
            break
    distance = (
        _meets(col if not left else col + 1, resolution, x, dx)
        if by_x
        else _meets(row if not down else row + 1, resolution, y, dy)
    )
    return distance + 0.0 if distance <= range_max else np.inf


@kernel
def cast_ray(grid: Grid, x: float, y: float, dx: float, dy: float, range_max: float) -> float:
    """Distance [m] of one ray from (x, y) in direction (dx, dy), all in the map's frame, as in `cast`."""
    if x != x or y != y or dx != dx or dy != dy:
        return np.nan
    if not (0.0 <= x < grid.cols * grid.resolution and 0.0 <= y < grid.rows * grid.resolution):
        return 0.0
    col = cell_of(x, grid.resolution)
    row = cell_of(y, grid.resolution)
    if is_occupied(grid, row, col):
        return 0.0
    return march(grid, x, y, col, row, dx, dy, range_max)


@kernel
def cast(
    grid: Grid,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
) -> None:
    """Write the distance [m] along every beam of every pose to where it enters the first occupied cell.

    Every beam for itself: what `amorsim.kernels.raycast.scans.cast_scans`, which is faster, agrees with to the bit.

    Parameters
    ----------
    grid
        The map, whose lower left corner is at (origin_x, origin_y) [m] and turned by `yaw` [rad] in the
        world.
    poses
        (N, 3): x, y [m] and heading [rad] in the world.
    cos_b, sin_b
        (B, k), B = 1 or N: cosine and sine of the beams' bearings from the heading.
    range_max
        (R,), R = 1 or N [m]; below 0 nothing is looked for, and all is inf.
    out
        (N, k): 0 from an occupied cell or from outside the map, inf where nothing is within the range, and
        nan where a pose or a bearing is.
    """
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    width = grid.cols * grid.resolution
    height = grid.rows * grid.resolution
    for n in range(poses.shape[0]):
        reach = range_max[n if range_max.shape[0] > 1 else 0]
        if reach < 0.0:
            out[n] = np.inf
            continue
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        heading = poses[n, 2] - yaw
        cos_h = math.cos(heading)
        sin_h = math.sin(heading)
        b = n if cos_b.shape[0] > 1 else 0
        is_nan = x != x or y != y or cos_h != cos_h
        inside = 0.0 <= x < width and 0.0 <= y < height
        col = cell_of(x, grid.resolution) if inside else -1
        row = cell_of(y, grid.resolution) if inside else -1
        blocked = is_occupied(grid, row, col)
        if is_nan or blocked:
            out[n] = np.nan if is_nan else 0.0
            continue
        for k in range(out.shape[1]):
            dx, dy = direction(cos_h, sin_h, cos_b[b, k], sin_b[b, k])
            out[n, k] = np.nan if dx != dx or dy != dy else march(grid, x, y, col, row, dx, dy, reach)


@kernel
def occupied_points(
    grid: Grid,
    origin_x: float,
    origin_y: float,
    yaw: float,
    points: Array,
    out: Bools,
) -> None:
    """Write whether each point (N, 2) [m] of the world is in an occupied cell; nan and outside are."""
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    for n in range(points.shape[0]):
        x, y = to_frame(points[n, 0], points[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        out[n] = True
        if 0.0 <= x < grid.cols * grid.resolution and 0.0 <= y < grid.rows * grid.resolution:
            out[n] = is_occupied(grid, cell_of(y, grid.resolution), cell_of(x, grid.resolution))
