"""Rays against the outlines of bodies: robots and obstacles as sensors see them.

Every body is first turned and moved so that the ray starts at the origin. Circles around bodies, and a scan's
order by angle, only ever leave out what cannot be hit, so neither changes a bit of the result.

Work on many bodies or beams is done in loops without a branch, which compilers vectorise: the bodies near a scan are
gathered, then the beams that might hit each are found for all of them, and then the beams of one body are processed
together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.collision.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.collision.footprints import Bodies, rounding_slack
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.raycast.meet_body import BEAM_ROWS, DX, DY, FOUND, meet_body

__all__ = ["cast_bodies"]


_SECTORS = 256  # of a turn, by which beams are found
_PER_TURN = _SECTORS / 4.0  # `_turn` counts quarters
_TOGETHER = 64  # bodies whose possible beams are found at once
_WIDE = 8  # beams

# Rows of the room to work in for the bodies near a scan: where each is as seen from there, its circle [m], how far off
# it is [m], and between which turns the beams are that might meet it.
_X, _Y, _CIRCLE, _AWAY, _RIGHT, _LEFT = range(6)


class _Room(NamedTuple):
    """Arrays that casting works in."""

    edges: Array  # (vertices of the largest body, 5)
    starts: Ints  # (_SECTORS + 2,)
    beams: Array  # (BEAM_ROWS, k)
    which: Ints  # (_TOGETHER,)
    near: Array  # (6, _TOGETHER)
    box: Array  # (4, _WIDE)


class _Eye(NamedTuple):
    """The origin of beams [m], and the cosine and sine of the direction that bearings are measured from."""

    x: float
    y: float
    cos: float
    sin: float


@part
def _turn(cos: float, sin: float) -> float:
    """A number in [0, 4] that grows with the angle of (cos, sin) over [0, 2 pi): cheap, for ordering only."""
    along = cos / (abs(cos) + abs(sin))
    return 1.0 - along if sin >= 0.0 else 3.0 + along


@part
def _order(cos_b: Array, sin_b: Array, row: int, starts: Ints) -> bool:
    """Write the first beam of each sector, sectors counted from the first beam's; return whether beams are in order."""
    c = cos_b[row, 0]
    s = sin_b[row, 0]
    before = 0.0
    sector = 0
    for j in range(cos_b.shape[1]):
        turn = _turn(c * cos_b[row, j] + s * sin_b[row, j], c * sin_b[row, j] - s * cos_b[row, j])
        if not turn >= before:
            return False
        before = turn
        while sector <= int(turn * _PER_TURN):
            starts[sector] = j
            sector += 1
    for rest in range(sector, starts.shape[0]):
        starts[rest] = cos_b.shape[1]
    return True


@part
def _lower(found: Array, limit: float, ranges: Array) -> None:
    for b in range(found.shape[0]):
        nearer = (found[b] <= limit) & (found[b] < ranges[b])
        ranges[b] = found[b] if nearer else ranges[b]


@part
def _lower_and_tell(found: Array, limit: float, body: int, ranges: Array, hit: Ints) -> None:
    for b in range(found.shape[0]):
        if found[b] <= limit:
            # In whatever order bodies come, the same one wins.
            if found[b] < ranges[b]:
                ranges[b] = found[b]
                hit[b] = body
            elif found[b] == ranges[b] and body < hit[b]:
                hit[b] = body


@part
def _find_beams(count: int, cos_0: float, sin_0: float, near: Array) -> None:
    """Write how far off bodies are, and between which turns from the direction (cos_0, sin_0) they lie."""
    for c in range(count):
        x = near[_X, c]
        y = near[_Y, c]
        away = math.sqrt(x * x + y * y)
        circle = near[_CIRCLE, c]
        # The circle's centre as seen from the first beam, then both its tangents; of no use from inside it.
        sin_a = circle / away
        cos_a = math.sqrt((1.0 - sin_a) * (1.0 + sin_a))
        cos_c = cos_0 * x + sin_0 * y
        sin_c = cos_0 * y - sin_0 * x
        near[_RIGHT, c] = _turn(cos_c * cos_a + sin_c * sin_a, sin_c * cos_a - cos_c * sin_a)
        near[_LEFT, c] = _turn(cos_c * cos_a - sin_c * sin_a, sin_c * cos_a + cos_c * sin_a)
        near[_AWAY, c] = away


@part
def _meet_bodies(
    bodies: Bodies,
    body_pose: Array,
    which: Ints,
    near: Array,
    starts: Ints,
    in_order: bool,
    limit: float,
    edges: Array,
    beams: Array,
    ranges: Array,
    hit: Ints,
) -> None:
    """Find where a scan meets the bodies gathered in `which` and `near`."""
    count = beams.shape[1]
    for c in range(which.shape[0]):
        away = near[_AWAY, c]
        circle = near[_CIRCLE, c]
        start = 0
        stop = count
        resume = count
        if in_order and circle < away:
            right = near[_RIGHT, c]
            left = near[_LEFT, c]
            start = starts[int(right * _PER_TURN)]
            stop = starts[int(left * _PER_TURN) + 1]
            if right > left:  # the circle lies across the first beam
                resume = max(start, stop)
                start = 0
        while True:
            # Beams at either end that have met something nearer already.
            while start < stop and ranges[start] <= away - circle:
                start += 1
            while start < stop and ranges[stop - 1] <= away - circle:
                stop -= 1
            if start < stop:
                j = which[c]
                meet_body(bodies, j, body_pose[j], near[_X, c], near[_Y, c], edges, beams, start, stop)
                if hit.shape[0] == 0:
                    _lower(beams[FOUND, start:stop], limit, ranges[start:stop])
                else:
                    _lower_and_tell(beams[FOUND, start:stop], limit, j, ranges[start:stop], hit[start:stop])
            if resume >= count:
                break
            start = resume
            stop = count
            resume = count


@part
def _bounds(beams: Array, ranges: Array, limit: float, box: Array) -> None:
    """Write the least and the greatest x and y [m] that beams come to from the origin into the first of `box` (4, 8).

    Eight beams side by side, and those eight in the end: a single least number would be a chain of comparisons, each of
    which waits for the one before.
    """
    count = beams.shape[1]
    for b in range(box.shape[0]):
        box[b] = 0.0
    for first in range(0, count, _WIDE):
        for b in range(_WIDE):
            # The last ones again where their number is no multiple of eight.
            k = min(first, max(count - _WIDE, 0)) + min(b, count - 1)
            far = ranges[k]
            far = far if far < limit else limit
            x = far * beams[DX, k]
            y = far * beams[DY, k]
            box[0, b] = x if x < box[0, b] else box[0, b]
            box[1, b] = x if x > box[1, b] else box[1, b]
            box[2, b] = y if y < box[2, b] else box[2, b]
            box[3, b] = y if y > box[3, b] else box[3, b]
    for b in range(1, _WIDE):
        for side in range(0, 4, 2):
            box[side, 0] = min(box[side, 0], box[side, b])
            box[side + 1, 0] = max(box[side + 1, 0], box[side + 1, b])


@part
def _widest_of(cos_b: Array, sin_b: Array, row: int) -> tuple[float, float]:
    """Cosine and sine >= 0 of the largest bearing to either side."""
    widest = 0
    for b in range(1, cos_b.shape[1]):
        if cos_b[row, b] < cos_b[row, widest]:
            widest = b
    return cos_b[row, widest], abs(sin_b[row, widest])


@part
def _has_company(
    table: BodyHash, replica: int, own: int, eye: _Eye, cos_w: float, sin_w: float, reach: float, widest: float
) -> bool:
    """Whether any other body may be within `reach` [m] of an eye, and no further aside than (cos_w, sin_w).

    Most rows of many replicas, and most cones, need no beams.
    """
    x, y, cos_h, sin_h = eye
    slack = rounding_slack(abs(x) + abs(y))
    around = reach + widest * (1.0 + 1e-9) + slack
    row0, rows = window(y, around, table.side, table.rows)
    col0, cols = window(x, around, table.side, table.cols)
    for run in range(2 * rows if col0 + cols > table.cols else rows):
        place, last = run_of_bodies(table, replica, row0, rows, col0, cols, run)
        for n in range(place, last):
            away_x = table.disc[n, 0] - x
            away_y = table.disc[n, 1] - y
            # Larger than it needs to be by far more than rounding can matter.
            circle = (table.disc[n, 2] + slack) * (1.0 + 1e-8) + 1e-8 * (abs(away_x) + abs(away_y))
            far = reach + circle
            if table.owner[n] == own or not away_x * away_x + away_y * away_y <= far * far:
                continue
            # How far the centre is beyond the nearer edge, if that is known to be less than a quarter turn aside.
            ahead = cos_h * away_x + sin_h * away_y
            aside = abs(cos_h * away_y - sin_h * away_x)
            if not cos_w > 0.0 or aside * cos_w - ahead * sin_w <= circle:
                return True
    return False


@part
def _cast_rows(
    bodies: Bodies,
    body_pose: Array,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    room: _Room,
    out: Array,
    hit: Ints,
) -> None:
    """`cast_bodies`, with room to work in."""
    edges, starts, beams, which, near, box = room
    in_order = False
    cos_w, sin_w = -1.0, 0.0
    for i in range(out.shape[0]):
        beam_row = min(i, cos_b.shape[0] - 1)
        if beam_row == i:
            in_order = _order(cos_b, sin_b, beam_row, starts)
            cos_w, sin_w = _widest_of(cos_b, sin_b, beam_row)
        limit = range_max[min(i, range_max.shape[0] - 1)]
        origin_x = origins[i, 0]
        origin_y = origins[i, 1]
        cos_h = math.cos(origins[i, 2])
        sin_h = math.sin(origins[i, 2])
        eye = _Eye(origin_x, origin_y, cos_h, sin_h)
        if not _has_company(table, replica[i], own[i], eye, cos_w, sin_w, limit, widest):
            continue
        for b in range(beams.shape[1]):
            beams[DX, b] = cos_h * cos_b[beam_row, b] - sin_h * sin_b[beam_row, b]
            beams[DY, b] = sin_h * cos_b[beam_row, b] + cos_h * sin_b[beam_row, b]
        # Skips bodies outside the box around all beams, up to the ranges found so far.
        _bounds(beams, out[i], limit, box)
        slack = rounding_slack(abs(origin_x) + abs(origin_y))
        around = widest * (1.0 + 1e-9) + slack
        x0 = box[0, 0]
        x1 = box[1, 0]
        y0 = box[2, 0]
        y1 = box[3, 0]
        row0, rows = window(origin_y + 0.5 * (y0 + y1), 0.5 * (y1 - y0) + around, table.side, table.rows)
        col0, cols = window(origin_x + 0.5 * (x0 + x1), 0.5 * (x1 - x0) + around, table.side, table.cols)
        runs = 2 * rows if col0 + cols > table.cols else rows
        run = 0
        place = 0
        last = 0
        while True:
            count = 0
            while count < _TOGETHER:
                if place == last:
                    if run == runs:
                        break
                    place, last = run_of_bodies(table, replica[i], row0, rows, col0, cols, run)
                    run += 1
                    continue
                end = min(last, place + _TOGETHER - count)
                for n in range(place, end):
                    x = table.disc[n, 0] - origin_x
                    y = table.disc[n, 1] - origin_y
                    # A circle around the body, larger than it needs to be by far more than rounding can matter.
                    circle = table.disc[n, 2] * (1.0 + 1e-9) + slack + 1e-9 * (abs(x) + abs(y))
                    which[count] = table.body[n]
                    near[_X, count] = x
                    near[_Y, count] = y
                    near[_CIRCLE, count] = circle
                    # Kept by going on behind it, which is quicker than a branch that cannot be foreseen.
                    keeps = (x >= x0 - circle) & (x <= x1 + circle) & (y >= y0 - circle) & (y <= y1 + circle)
                    count += int(keeps & (table.owner[n] != own[i]))
                place = end
            if count == 0:
                break
            _find_beams(count, beams[DX, 0], beams[DY, 0], near)
            met = hit[i] if hit.shape[1] > 0 else which[:0]
            _meet_bodies(bodies, body_pose, which[:count], near, starts, in_order, limit, edges, beams, out[i], met)


@kernel
def cast_bodies(
    bodies: Bodies,
    body_pose: Array,
    edge_rows: int,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: Array,
    out: Array,
    hit: Ints,
) -> None:
    """Lower each range to where its ray meets another body of the same replica, where that is nearer.

    A ray that starts in a body, or on its border, reads 0. Of bodies equally far the lowest index counts; a
    body as far as what `out` already holds does not.

    Parameters
    ----------
    bodies
        The footprints, of bodies 0 to M - 1.
    body_pose
        Their poses: x [m], y [m], heading [rad], (M, 3).
    edge_rows
        Vertices of the largest body.
    table
        The bodies at these poses, by place.
    widest
        The largest reach of a body [m].
    replica
        Of each row, int64 (N,).
    own
        The body that carries the sensor, -1 for none, int64 (N,). It is not seen, nor is what it is the owner of.
    origins
        Where the rays of each row start, and what their bearings are measured from, (N, 3), like `body_pose`.
    cos_b, sin_b
        Of the beams' bearings b; the direction for heading h is (cos h cos b - sin h sin b, sin h cos b + cos
        h sin b). One row for all, or one each, (1 or N, k). Anticlockwise order within one turn is the
        fastest.
    range_max
        Beyond which nothing is seen [m], (1 or N,).
    out
        In: ranges so far [m], inf for none; out: the lower ones, (N, k).
    hit
        In: -1; gets the body's index where it lowered a range, int64, as `out`. Not written if it has no columns.
    """
    beams = cos_b.shape[1]
    if beams == 0:
        return
    _cast_rows(
        bodies,
        body_pose,
        table,
        widest,
        replica,
        own,
        origins,
        cos_b,
        sin_b,
        range_max,
        _Room(
            np.empty((edge_rows, 5)),
            np.empty(_SECTORS + 2, dtype=np.int64),
            np.empty((BEAM_ROWS, beams)),
            np.empty(_TOGETHER, dtype=np.int64),
            np.empty((6, _TOGETHER)),
            np.empty((4, _WIDE)),
        ),
        out,
        hit,
    )
