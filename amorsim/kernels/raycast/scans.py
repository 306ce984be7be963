"""Scans: many beams from one place, which share work; to the bit the same as each beam by itself.

Where the map has line features they say how far a beam is free (`amorsim.kernels.grid.segments`), and it is marched
only from there. Most beams then hit within the word of 8 x 8 cells in which they start. So a number of them goes there
together: starts are found for all, their words fetched, steps from cell to cell taken by all in lockstep, and distances
measured for all, in loops without a branch, which compilers make several beams wide, and whose fetches do not wait for
one another. Crossings are compared as `amorsim.kernels.raycast.rays` compares them; a beam that is in doubt, or leaves
its word, goes on by itself from where it is, by `march`.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Array, Ints, Ints32
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.grid.grid import Grid, is_occupied
from amorsim.kernels.grid.segments import RINGS, SAFETY, SegmentIndex, SortedBeams, bound_scan, bucket_of
from amorsim.kernels.raycast.rays import cell_of, direction, march, rounding, to_frame

__all__ = ["cast_scans", "sort_beams", "sorted_beams", "unsorted_beams"]


_FEW = 12  # beams of a scan, or rows of a table, below which preparing them costs more than it saves
FINE, COARSE = 256.0, 64.0  # sectors in a quarter turn, of a table for many rows and of one for few
LANES = 64  # beams that go together
_STEPS = 8  # cells they go at most; few need more

# Where the quantities of these beams start in the one array of numbers and the one of whole numbers. Constant distances
# tell the compiler that they do not overlap.
_DX, _DY, _BETWEEN_X, _BETWEEN_Y, _NEXT_X, _NEXT_Y, _COL, _ROW, _RANGE = (i * LANES for i in range(9))
_STATE, _WORD, _PLACE, _STEP_X, _STEP_Y, _FIRST, _SUPER, _TABLE, _PAGE = (i * LANES for i in range(9))
_LEFT = _FIRST  # in the end, whether a beam has to go on by itself
_ROOM = 9 * LANES

# States: on its way; has entered an occupied cell by a line of either axis; must go on alone, from its place in the
# word or from the start.
_LIVE, _BY_X, _BY_Y, _ALONE, _UNSTARTED = range(5)
# A place in a word is 256 * row + column; one that is not in it has other bits set.
_ROW_UNIT = 256
_BEYOND_WORD = ~0x0707


class _Room(NamedTuple):
    """Arrays that a scan works in."""

    blocks: Ints  # as long as the lines have blocks, like `away`
    away: Array
    rings: Ints
    nearness: Array  # one for each beam, filled up to whole lanes
    f: Array
    q: Ints


@part
def _sort_beams(cos_b: Array, sin_b: Array, into: SortedBeams) -> None:
    """Write beams (k,) in the order of their sectors, and at which of them each sector starts."""
    order, cos_s, sin_s, starts, scale = into
    for s in range(starts.shape[0]):
        starts[s] = 0
    for k in range(cos_b.shape[0]):
        starts[bucket_of(cos_b[k], sin_b[k], 0.0, scale) + 1] += 1
    for s in range(len(starts) - 1):
        starts[s + 1] += starts[s]
    for k in range(cos_b.shape[0]):
        s = bucket_of(cos_b[k], sin_b[k], 0.0, scale)
        i = starts[s]
        starts[s] = i + 1
        order[i] = k
        cos_s[i] = cos_b[k]
        sin_s[i] = sin_b[k]
    # Each start has moved on to that of the next sector.
    for s in range(len(starts) - 1, 0, -1):
        starts[s] = starts[s - 1]
    starts[0] = 0


@part
def _aim(
    grid: Grid,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    first: int,
    beams: SortedBeams,
    nearness: Array,
    beyond: float,
    slack: float,
    f: Array,
    q: Ints,
) -> None:
    """Write direction, cell and next crossings of the beams from number `first` on, one cell beyond the free ones.

    A beam no nearer than `beyond` goes nowhere. The cell in which what is free ends is free itself. Walls begin most
    often in the next one, which may be in another word.
    """
    resolution = grid.resolution
    start_x = x / resolution
    start_y = y / resolution
    cos_s, sin_s = beams.cos_b, beams.sin_b
    doubt = 2.0 * rounding(grid, 1.0, 1.0)
    for i in range(LANES):
        # Unsigned, for a number that could be negative would be looked at first, and what it counts gathered.
        beam = np.uint64(first) + np.uint64(i)
        dx, dy = direction(cos_h, sin_h, cos_s[beam], sin_s[beam])
        free = (1.0 - SAFETY) / (nearness[beam] * resolution)
        place_x = start_x + free * dx
        place_y = start_y + free * dy
        col = math.floor(place_x) * 1.0
        row = math.floor(place_y) * 1.0
        inverse_x = 1.0 / dx
        inverse_y = 1.0 / dy
        f[i + _DX] = dx
        f[i + _DY] = dy
        between_x = abs(inverse_x)
        between_y = abs(inverse_y)
        next_x = (col + (1.0 if dx > 0.0 else 0.0) - start_x) * inverse_x
        next_y = (row + (1.0 if dy > 0.0 else 0.0) - start_y) * inverse_y
        part_x = place_x - col
        part_y = place_y - row
        # Not so near a grid line that the cell is in doubt; false of nan.
        sure = (part_x > doubt) & (part_x < 1.0 - doubt) & (part_y > doubt) & (part_y < 1.0 - doubt)
        sure &= (place_x > 0.0) & (place_x < grid.cols) & (place_y > 0.0) & (place_y < grid.rows)
        by_x = next_x <= next_y
        then_col = col + ((1.0 if dx > 0.0 else -1.0) if by_x else 0.0)
        then_row = row + (0.0 if by_x else (1.0 if dy > 0.0 else -1.0))
        goes = (nearness[beam] > beyond) & (abs(next_x - next_y) > slack * (between_x + between_y))
        goes &= (then_col >= 0.0) & (then_col < grid.cols) & (then_row >= 0.0) & (then_row < grid.rows)
        f[i + _BETWEEN_X] = between_x
        f[i + _BETWEEN_Y] = between_y
        f[i + _NEXT_X] = next_x + (between_x if by_x else 0.0)
        f[i + _NEXT_Y] = next_y + (0.0 if by_x else between_y)
        col = then_col if goes else col
        row = then_row if goes else row
        f[i + _COL] = col if sure else 0.0
        f[i + _ROW] = row if sure else 0.0
        q[i + _FIRST] = _BY_X if by_x else _BY_Y
        q[i + _STATE] = (_LIVE if goes else _ALONE) if sure else _UNSTARTED
        q[i + _STEP_X] = 1 if dx > 0.0 else -1
        q[i + _STEP_Y] = _ROW_UNIT if dy > 0.0 else -_ROW_UNIT


@part
def _fetch(grid: Grid, f: Array, q: Ints) -> None:
    """Write the words that the beams are in, and their places in them; where all is free the word is 0."""
    for i in range(LANES):
        col = int(f[i + _COL])
        row = int(f[i + _ROW])
        q[i + _PLACE] = (row & 7) * _ROW_UNIT + (col & 7)
        q[i + _SUPER] = (row >> 12) * grid.super_cols + (col >> 12)
        q[i + _TABLE] = ((row >> 6) & 63) * 64 + ((col >> 6) & 63)
        q[i + _PAGE] = ((row >> 3) & 7) * 8 + ((col >> 3) & 7)
    for i in range(LANES):
        word: Any = np.uint64(0)
        entry: Any = np.int64(grid.supers[np.uint64(q[i + _SUPER])])
        if entry >= 0:
            entry = np.int64(grid.tables[np.uint64(entry), np.uint64(q[i + _TABLE])])
            if entry >= 0:
                word = grid.pages[np.uint64(entry), np.uint64(q[i + _PAGE])]
        q[i + _WORD] = np.int64(word)


@part
def _walk(slack: float, f: Array, q: Ints) -> None:
    """Go from cell to cell until one is occupied, the next is in another word, or the next one is in doubt.

    Conditions are whole numbers 0 and 1, and their negatives masks: what the compiler makes several beams wide.
    """
    for i in range(LANES):
        # Where the first cell is occupied that is the end.
        place = q[i + _PLACE]
        hits = (q[i + _WORD] >> (((place >> 5) & 56) + (place & 7))) & np.int64(q[i + _STATE] == _LIVE)
        q[i + _STATE] |= q[i + _FIRST] & -hits
    for step in range(_STEPS):
        if step in (1, 2, 4):
            alive = np.int64(0)
            for i in range(LANES):
                alive |= np.int64(q[i + _STATE] == _LIVE)
            if not alive:
                return
        for i in range(LANES):
            next_x = f[i + _NEXT_X]
            next_y = f[i + _NEXT_Y]
            between_x = f[i + _BETWEEN_X]
            between_y = f[i + _BETWEEN_Y]
            place = q[i + _PLACE]
            step_x = q[i + _STEP_X]
            step_y = q[i + _STEP_Y]
            live = np.int64(q[i + _STATE] == _LIVE)
            by_x = np.int64(next_x <= next_y)
            then = place + (step_y ^ ((step_x ^ step_y) & -by_x))
            sure = np.int64(abs(next_x - next_y) > slack * (between_x + between_y))
            goes = live & sure & np.int64((then & _BEYOND_WORD) == 0)
            hits = (q[i + _WORD] >> (((then >> 5) & 56) + (then & 7))) & goes
            ends = (-hits & (_BY_Y - by_x)) | (_ALONE & (goes - 1))
            q[i + _STATE] |= ends & -live
            q[i + _PLACE] = place ^ ((place ^ then) & -goes)
            f[i + _NEXT_X] = next_x + (between_x if goes & by_x else 0.0)
            f[i + _NEXT_Y] = next_y + (between_y if goes & (1 - by_x) else 0.0)


@part
def _measure(
    resolution: float,
    x: float,
    y: float,
    reach: float,
    beyond: float,
    first: int,
    count: int,
    nearness: Array,
    f: Array,
    q: Ints,
) -> bool:
    """Write the distances of the beams that entered an occupied cell, by the lines that they crossed into it.

    And inf for those that are bounded by no wall in reach. Returns whether any of the first `count` is left, to
    continue on its own.
    """
    left = np.int64(0)
    for i in range(LANES):
        state = q[i + _STATE]
        by_x = state == _BY_X
        hits = by_x | (state == _BY_Y)
        place = q[i + _PLACE]
        dx = f[i + _DX]
        dy = f[i + _DY]
        line_x = 8.0 * math.floor(f[i + _COL] * 0.125) + (place & 7) + (0.0 if dx > 0.0 else 1.0)
        line_y = 8.0 * math.floor(f[i + _ROW] * 0.125) + (place >> 8) + (0.0 if dy > 0.0 else 1.0)
        line = line_x if by_x else line_y
        distance = (line * resolution - (x if by_x else y)) / (dx if by_x else dy)
        f[i + _RANGE] = distance + 0.0 if hits & (distance <= reach) else np.inf
        # Nothing is known of a beam that is nan.
        is_near = nearness[np.uint64(first) + np.uint64(i)] > beyond
        is_left = (not hits) & (is_near | (dx != dx) | (dy != dy)) & (i < count)
        q[i + _LEFT] = np.int64(is_left)
        left |= np.int64(is_left)
    return bool(left)


@part
def _cast_scan(
    grid: Grid,
    lines: SegmentIndex,
    x: float,
    y: float,
    heading: float,
    reach: float,
    beams: SortedBeams,
    room: _Room,
    out: Array,
) -> None:
    """Write the distances (k,) of a scan from a pose in the map's frame."""
    resolution = grid.resolution
    order, cos_s, sin_s = beams.order, beams.cos_b, beams.sin_b
    nearness, f, q = room.nearness, room.f, room.q
    count = out.shape[0]
    cos_h = math.cos(heading)
    sin_h = math.sin(heading)
    is_nan = x != x or y != y or cos_h != cos_h
    inside = 0.0 <= x < grid.cols * resolution and 0.0 <= y < grid.rows * resolution
    col = cell_of(x, resolution) if inside else -1
    row = cell_of(y, resolution) if inside else -1
    if is_nan or is_occupied(grid, row, col):
        for k in range(count):
            out[k] = np.nan if is_nan else 0.0
        return
    slack = 2.0 * rounding(grid, 1.0, 1.0)
    # A beam no nearer than this has nothing within the range.
    beyond = 1.0 / (reach * (1.0 + 2.0 * SAFETY))
    bounded = lines.walls.shape[1] > 0 and count >= _FEW and reach > resolution
    if bounded:
        for k in range(nearness.shape[0]):
            nearness[k] = beyond
        bounded = bound_scan(lines, x, y, cos_h, sin_h, reach, beams, room.blocks, room.away, room.rings, f, nearness)
    for first in range(0, count, LANES):
        now = min(LANES, count - first)
        if bounded:
            _aim(grid, x, y, cos_h, sin_h, first, beams, nearness, beyond, slack, f, q)
            _fetch(grid, f, q)
            _walk(slack, f, q)
            some_left = _measure(resolution, x, y, reach, beyond, first, now, nearness, f, q)
            for i in range(now):
                out[np.uint64(order[np.uint64(first) + np.uint64(i)])] = f[i + _RANGE]
            if not some_left:
                continue
        for i in range(now):
            start_col = col
            start_row = row
            if bounded:
                if not q[i + _LEFT]:
                    continue
                if q[i + _STATE] != _UNSTARTED:
                    start_col = (int(f[i + _COL]) & -8) + (q[i + _PLACE] & 7)
                    start_row = (int(f[i + _ROW]) & -8) + (q[i + _PLACE] >> 8)
            dx, dy = direction(cos_h, sin_h, cos_s[first + i], sin_s[first + i])
            is_nan = dx != dx or dy != dy
            out[order[first + i]] = np.nan if is_nan else march(grid, x, y, start_col, start_row, dx, dy, reach)


@kernel
def sort_beams(cos_b: Array, sin_b: Array, order: Ints, cos_s: Array, sin_s: Array, starts: Ints) -> None:
    """Sort the beams of scans for `cast_scans`; the scans may be taken from many places.

    Parameters
    ----------
    cos_b, sin_b
        (B, k): cosines and sines of the beams' bearings from the heading, in any order.
    order, cos_s, sin_s, starts
        Get the `SortedBeams` of each: (B, k), (B, L), (B, L) and (B, S + 1), of S sectors and k filled up to L, a whole
        number of lanes.
    """
    for b in range(cos_b.shape[0]):
        for k in range(cos_b.shape[1], cos_s.shape[1]):
            cos_s[b, k] = 1.0
            sin_s[b, k] = 0.0
        beams = SortedBeams(order[b], cos_s[b], sin_s[b], starts[b], (starts.shape[1] - 1) / 4.0)
        _sort_beams(cos_b[b], sin_b[b], beams)


def sorted_beams(cos_b: Array, sin_b: Array, poses: int) -> tuple[Ints, Array, Array, Ints]:
    """The beams (B, k) of scans as `cast_scans` takes them, for so many poses; see `sort_beams`."""
    beams = unsorted_beams(poses, *cos_b.shape)
    sort_beams(cos_b, sin_b, *beams)
    return beams


def unsorted_beams(poses: int, scans: int, count: int) -> tuple[Ints, Array, Array, Ints]:
    """Arrays for `sort_beams`, of so many `scans` of `count` beams that are cast from so many `poses`."""
    scale = FINE if scans == 1 and poses >= _FEW else COARSE
    lanes = (count + LANES - 1) // LANES * LANES
    order, starts = np.empty((scans, count), np.int64), np.empty((scans, int(4.0 * scale) + 1), np.int64)
    return order, np.empty((scans, lanes)), np.empty((scans, lanes)), starts


@kernel
def cast_scans(
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
    walls: Array,
    origin_x: float,
    origin_y: float,
    yaw: float,
    poses: Array,
    order: Ints,
    cos_s: Array,
    sin_s: Array,
    starts: Ints,
    range_max: Array,
    out: Array,
) -> None:
    """Write the distance [m] along every beam of every pose to where it enters the first occupied cell.

    Parameters
    ----------
    resolution, rows, cols, super_cols, supers, tables, pages, free_room
        The map's `Grid`, whose lower left corner is at (origin_x, origin_y) [m] and turned by `yaw` [rad] in the
        world. Grid and index come field by field: to unpack a named tuple takes numba longer than a few beams take.
    boxes, first, walls
        The `SegmentIndex` of what the map was drawn from, in its frame; of `no_segments()` where that is not known.
    poses
        (N, 3): x, y [m] and heading [rad] in the world.
    order, cos_s, sin_s, starts
        What `sorted_beams` returns for the (B, k) beams, B = 1 or N.
    range_max
        (R,), R = 1 or N [m]; below 0 nothing is looked for, and all is inf.
    out
        (N, k): 0 from an occupied cell or from outside the map, inf where nothing is within the range, and
        nan where a pose or a bearing is.
    """
    grid = Grid(resolution, rows, cols, super_cols, supers, tables, pages, free_room)
    lines = SegmentIndex(boxes, first, walls)
    cos_yaw = math.cos(yaw)
    sin_yaw = math.sin(yaw)
    scale = (starts.shape[1] - 1) / 4.0
    blocks = boxes.shape[1]
    room = _Room(
        np.empty(blocks, dtype=np.int64),
        np.empty(blocks),
        np.empty(RINGS + 2, dtype=np.int64),
        np.empty(cos_s.shape[1]),
        np.empty(_ROOM),
        np.empty(_ROOM, dtype=np.int64),
    )
    for n in range(poses.shape[0]):
        reach = range_max[n if range_max.shape[0] > 1 else 0]
        if reach < 0.0:
            out[n] = np.inf
            continue
        x, y = to_frame(poses[n, 0], poses[n, 1], origin_x, origin_y, cos_yaw, sin_yaw)
        heading = poses[n, 2] - yaw
        b = n if order.shape[0] > 1 else 0
        beams = SortedBeams(order[b], cos_s[b], sin_s[b], starts[b], scale)
        _cast_scan(grid, lines, x, y, heading, reach, beams, room, out[n])
