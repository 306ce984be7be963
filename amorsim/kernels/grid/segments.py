"""Walls that a map was drawn from, as bounds on where a ray may first meet an occupied cell.

A segment occupies the cells that its closed line touches, so all of them lie in a rectangle: the segment, grown on
every side by what a cell reaches beyond a point of it; along an axis, the cells themselves. Seen from outside it, a
rectangle covers an interval of bearings, and lies beyond a line: that of its near side, or of its near end. Along a
beam of direction d the line n . q = c is met where 1/t = (n . d) / c. That is linear in d, so the greatest 1/t of all
rectangles over the beams of a scan is a one-dimensional depth buffer, filled without a division, several beams at a
time. Nothing is occupied before it. What it is good for depends on how tight it is; the bits of the grid decide what is
read.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import inlined, part

__all__ = [
    "AT_ONCE",
    "FACE",
    "INSIDE",
    "PASSED",
    "RINGS",
    "SAFETY",
    "SegmentIndex",
    "SortedBeams",
    "bound_scan",
    "bucket_of",
    "side_of",
    "walls_about",
]


SAFETY = 1e-9
"""Relative, on every bound: many times the roundings on the way to it."""
_MOST = 6  # segments seen by a scan, for each of its beams, from which on bounds cost more than they save
_EDGE = 1e-12  # [of a quarter turn] by which a rectangle covers more than it does

AT_ONCE = 16
"""The number of segments whose visible sides are found at once."""
# The offsets of the results in one array: what, a and b as from `side_of`, and the places of the ends.
_WHAT, _A, _B, _LOW, _HIGH = (i * AT_ONCE for i in range(5))

RINGS = 48
"""The number of rings that sort walls by distance."""

# What a segment shows: nothing within reach, its side, its end, or it is all around.
PASSED, FACE, END, INSIDE = range(4)


class SegmentIndex(NamedTuple):
    """Segments of a map in its own frame [m], in blocks of neighbours."""

    boxes: Array
    """(4, blocks) xmin, ymin, xmax, ymax of the occupied cells of a block's segments."""
    first: Ints
    """(blocks + 1,): a block's first segment, and one past its last, that of the next."""
    walls: Array
    """(10, M) x0, y0; unit vector along the segment; length; how far its cells reach beyond it; and of those that are
    boxes of occupied cells the grid lines that bound it, as `amorsim.kernels.grid.solids` has them."""


class SortedBeams(NamedTuple):
    """The beams of a scan in the order of their sectors (`bucket_of`)."""

    order: Ints  # (k,) which beam each is
    cos_b: Array  # (L,) cosines and sines of their bearings, filled up to whole lanes
    sin_b: Array
    starts: Ints  # beams starts[s] to starts[s + 1] - 1 are in sector s
    scale: float  # sectors in a quarter turn


@inlined
def _place(x: float, y: float) -> float:
    """In [0, 4], growing with the angle of (x, y): quarter turns, but not of equal steps, without an arc tangent."""
    sum_ = abs(x) + abs(y)
    part = y / sum_ if 0.0 < sum_ < math.inf else 0.0  # not of nan or inf, which are in no sector
    ahead = part if y >= 0.0 else 4.0 + part
    return ahead if x >= 0.0 else 2.0 - part


@inlined
def _bucket(place: float, scale: float) -> int:
    """The sector, of ``4 * scale``, of a position that may be up to a turn beyond the ends."""
    if place < 0.0:
        place += 4.0
    if place >= 4.0:
        place -= 4.0
    return min(int(place * scale), int(4.0 * scale) - 1)


@part
def bucket_of(x: float, y: float, beyond: float, scale: float) -> int:
    """The sector, of ``4 * scale``, of the direction (x, y); `beyond` is added to its position in quarter turns."""
    return _bucket(_place(x, y) + beyond, scale)


@inlined
def _distance(boxes: Array, block: int, x: float, y: float) -> float:
    """Lower bound of the distance [m] from a point to anything that a block's segments occupy."""
    away_x = max(max(boxes[0, block] - x, x - boxes[2, block]), 0.0)
    away_y = max(max(boxes[1, block] - y, y - boxes[3, block]), 0.0)
    return math.sqrt(away_x * away_x + away_y * away_y)


@part
def _near_blocks(lines: SegmentIndex, x: float, y: float, reach: float, found: Ints, away: Array, ends: Ints) -> int:
    """The number of blocks that may occupy something within reach; `found` gets them by rings, the nearest first.

    `away` gets how far [m] each block is; both are as long as there are blocks. `ends` (RINGS + 2,) is room to work in.
    """
    for ring in range(ends.shape[0]):
        ends[ring] = 0
    scale = RINGS / reach
    boxes = lines.boxes
    for block in range(boxes.shape[1]):
        away[block] = _distance(boxes, block, x, y)
    for block in range(boxes.shape[1]):
        if away[block] <= reach:
            ends[min(int(away[block] * scale), RINGS) + 1] += 1
    for ring in range(RINGS + 1):
        ends[ring + 1] += ends[ring]
    for block in range(lines.boxes.shape[1]):
        if away[block] <= reach:
            ring = min(int(away[block] * scale), RINGS)
            found[ends[ring]] = block
            ends[ring] += 1
    return int(ends[RINGS])


@part
def walls_about(
    lines: SegmentIndex,
    x: float,
    y: float,
    reach: float,
    found: Ints,
    about: Array,
    away: Array,
    candidates: Ints,
    ends: Ints,
) -> int:
    """The number of segments that may occupy cells within reach of a point; `found` gets them, nearest rings first.

    Parameters
    ----------
    about
        (6, M or more) gets of each what `Lines.walls` has of it first.
    away
        (M,) gets how far [m] each is at least; never less than the one before.
    candidates, ends
        (M,) and (RINGS + 2,): room to work in. There are M segments.
    """
    walls = lines.walls
    blocks = lines.boxes.shape[1]
    scale = RINGS / reach
    squares = about[0]
    for block in range(blocks):
        away[block] = _distance(lines.boxes, block, x, y)
    count = 0
    for block in range(blocks):
        if away[block] > reach:
            continue
        first = np.uint64(lines.first[block])
        end = np.uint64(lines.first[block + 1])
        for m in range(first, end):
            to_x = walls[0, m] - x
            to_y = walls[1, m] - y
            along = walls[2, m] * to_x + walls[3, m] * to_y
            across = max(abs(walls[3, m] * to_x - walls[2, m] * to_y) - walls[5, m], 0.0)
            beside = max(max(along, -along - walls[4, m]) - walls[5, m], 0.0)
            squares[m] = across * across + beside * beside
        for m in range(first, end):
            candidates[count] = m
            count += 1 if squares[m] <= reach * reach else 0
    for ring in range(ends.shape[0]):
        ends[ring] = 0
    for c in range(count):
        at = np.uint64(candidates[c])
        ring = min(int(math.sqrt(squares[at]) * scale), RINGS)
        squares[at] = ring
        ends[ring + 1] += 1
    for ring in range(RINGS + 1):
        ends[ring + 1] += ends[ring]
    for c in range(count):
        ring = int(squares[np.uint64(candidates[c])])
        at = np.uint64(ends[ring])
        ends[ring] += 1
        found[at] = candidates[c]
        away[at] = ring / scale * (1.0 - SAFETY) if ring > 0 else 0.0  # of an infinite reach too
    for i in range(6):
        for c in range(count):
            about[i, c] = walls[i, np.uint64(found[c])]
    return count


@part
def _block_span(lines: SegmentIndex, block: int, x: float, y: float) -> tuple[bool, float, float, float, float]:
    """Whether a point is outside a block's box, and then the corners of the box that are farthest right and left of it.

    They are relative to the point, x and y of the right one first.
    """
    x0 = lines.boxes[0, block] - x
    y0 = lines.boxes[1, block] - y
    x1 = lines.boxes[2, block] - x
    y1 = lines.boxes[3, block] - y
    if x0 > 0.0:
        return True, (x1 if y0 > 0.0 else x0), y0, (x1 if y1 < 0.0 else x0), y1
    if x1 < 0.0:
        return True, (x0 if y1 < 0.0 else x1), y1, (x0 if y0 > 0.0 else x1), y0
    if y0 > 0.0:
        return True, x1, y0, x0, y0
    return y1 < 0.0, x0, y1, x1, y1


@inlined
def side_of(
    walls: Array, m: int, x: float, y: float, cos_h: float, sin_h: float, reach: float
) -> tuple[int, float, float, float, float, float, float, float, float, float]:
    """What can be seen of a segment's cells from a point: ``(what, a, b, x0, y0, x1, y1, near, start, stop)``.

    `what` is `PASSED` where nothing of them is within reach, and `INSIDE` where the point may be among them; then the
    rest says nothing. Else they are within bearings from that of (x0, y0) anticlockwise to that of (x1, y1), and a beam
    of direction (dx, dy) does not meet them before 1 / (a * dx + b * dy). Directions count from the heading
    (cos_h, sin_h). Where `what` is `FACE`, that is where it meets the line `near` [m] across the segment, which goes
    from `start` to `stop` along it.

    Cases are chosen, not branched to: so a loop over segments goes several wide.
    """
    tx = walls[2, m]
    ty = walls[3, m]
    margin = walls[5, m]
    to_x = walls[0, m] - x
    to_y = walls[1, m] - y
    # Across and along the segment, so turned that it runs anticlockwise as seen from here.
    across = ty * to_x - tx * to_y
    along = tx * to_x + ty * to_y
    length = walls[4, m]
    turned = across < 0.0
    along = -along - length if turned else along
    tx = -tx if turned else tx
    ty = -ty if turned else ty
    across = abs(across)
    near = across - margin
    start = along - margin
    stop = along + length + margin
    far = across + margin
    passed = (near > reach) | (start > reach) | (stop < -reach)
    # Seen from its side far off, from before its start or beyond its end, or from its side close by; or from within.
    beside = near > margin
    before = (start > 0.0) & (not beside)
    beyond = (stop < 0.0) & (start <= 0.0) & (not beside)
    face = beside | ((near > 0.0) & (start <= 0.0) & (stop >= 0.0))
    # The segment's direction as the beams count bearings.
    ux = cos_h * tx + sin_h * ty
    uy = cos_h * ty - sin_h * tx
    to_line = near if face else (start if before else stop)
    a = (uy if face else ux) / to_line
    b = (-ux if face else uy) / to_line
    first_n = far if start > 0.0 else near
    last_n = far if stop < 0.0 else near
    first = stop if beyond & (near <= 0.0) else start
    last = start if before & (near <= 0.0) else stop
    x0 = first_n * uy + first * ux
    y0 = first * uy - first_n * ux
    x1 = last_n * uy + last * ux
    y1 = last * uy - last_n * ux
    seen = FACE if face else (END if before | beyond else INSIDE)
    what = PASSED if passed else seen
    return what, a, b, x0, y0, x1, y1, near, start, stop


@part
def _sides(
    walls: Array, first: int, last: int, x: float, y: float, cos_h: float, sin_h: float, reach: float, f: Array
) -> None:
    """Write what can be seen of segments first..last-1, and between which places, as `bound_scan` lays it out."""
    for m in range(np.uint64(first), np.uint64(last)):
        i = m - np.uint64(first)
        what, a, b, x0, y0, x1, y1, _, _, _ = side_of(walls, m, x, y, cos_h, sin_h, reach)
        f[i + np.uint64(_WHAT)] = what
        f[i + np.uint64(_A)] = a
        f[i + np.uint64(_B)] = b
        f[i + np.uint64(_LOW)] = _place(x0, y0)
        f[i + np.uint64(_HIGH)] = _place(x1, y1)


@part
def _raise(low: int, high: int, a: float, b: float, cos_b: Array, sin_b: Array, nearness: Array) -> None:
    """Let beams low..high-1 be at least as near as a line with a * x + b * y = 1."""
    for i in range(np.uint64(low), np.uint64(high)):
        value = a * cos_b[i] + b * sin_b[i]
        nearness[i] = value if value > nearness[i] else nearness[i]


@part
def _is_hidden(low: int, high: int, most: float, nearness: Array) -> bool:
    """Whether beams low..high-1 are all bounded nearer than a wall whose nearness is `most` could bound them."""
    least = np.inf
    for i in range(np.uint64(low), np.uint64(high)):
        least = nearness[i] if nearness[i] < least else least
    return least >= most


@part
def _block_is_hidden(
    lines: SegmentIndex,
    block: int,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    away: float,
    starts: Ints,
    scale: float,
    nearness: Array,
) -> bool:
    """Whether no beam can meet what a block's segments occupy sooner than what bounds it already."""
    outside, x0, y0, x1, y1 = _block_span(lines, block, x, y)
    if not outside or away <= 0.0:
        return False
    low = bucket_of(cos_h * x0 + sin_h * y0, cos_h * y0 - sin_h * x0, -_EDGE, scale)
    high = bucket_of(cos_h * x1 + sin_h * y1, cos_h * y1 - sin_h * x1, _EDGE, scale)
    most = (1.0 + SAFETY) / away
    if low <= high:
        return _is_hidden(starts[low], starts[high + 1], most, nearness)
    last = len(starts) - 2
    return _is_hidden(starts[low], starts[last + 1], most, nearness) and _is_hidden(
        starts[0], starts[high + 1], most, nearness
    )


@part
def bound_scan(
    lines: SegmentIndex,
    x: float,
    y: float,
    cos_h: float,
    sin_h: float,
    reach: float,
    beams: SortedBeams,
    blocks: Ints,
    away: Array,
    rings: Ints,
    sides: Array,
    nearness: Array,
) -> bool:
    """Raise `nearness` (k,) [1/m] to 1/t, where no beam meets an occupied cell before t.

    Blocks are visited from near to far. Hidden ones are skipped: they lie wholly behind the bounds of all beams that
    could hit them. Returns False, with `nearness` undefined, if a wall is too close to the beam's start to
    be distinguished from it, or if too many walls are in sight for this to be faster.

    Parameters
    ----------
    x, y, cos_h, sin_h
        Where the scan is taken from, and its heading, in the map's frame.
    reach
        [m]: walls farther away are passed over.
    blocks, away, rings, sides
        Room to work in: two as long as there are blocks, one for each of the `RINGS` and two, and five times `AT_ONCE`.
    """
    _, cos_b, sin_b, starts, scale = beams
    last = len(starts) - 2
    walls = lines.walls
    left = _MOST * len(cos_b)
    for i in range(_near_blocks(lines, x, y, reach, blocks, away, rings)):
        block = blocks[i]
        if _block_is_hidden(lines, block, x, y, cos_h, sin_h, away[block], starts, scale, nearness):
            continue
        for m in range(lines.first[block], lines.first[block + 1], AT_ONCE):
            count = min(AT_ONCE, lines.first[block + 1] - m)
            _sides(walls, m, m + count, x, y, cos_h, sin_h, reach, sides)
            for n in range(count):
                if sides[n + _WHAT] == PASSED:
                    continue
                left -= 1
                if left < 0 or sides[n + _WHAT] == INSIDE:
                    return False
                low = _bucket(sides[n + _LOW] - _EDGE, scale)
                high = _bucket(sides[n + _HIGH] + _EDGE, scale)
                a = sides[n + _A]
                b = sides[n + _B]
                if low <= high:
                    _raise(starts[low], starts[high + 1], a, b, cos_b, sin_b, nearness)
                else:
                    _raise(starts[low], starts[last + 1], a, b, cos_b, sin_b, nearness)
                    _raise(starts[0], starts[high + 1], a, b, cos_b, sin_b, nearness)
    return True
