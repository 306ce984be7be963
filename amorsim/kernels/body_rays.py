"""Rays against the outlines of bodies: robots and obstacles as sensors see them.

Every body is first turned and moved so that the ray starts at the origin. Circles around bodies, and a scan's
order by angle, only ever leave out what cannot be hit, so neither changes a bit of the result.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from amorsim.kernels.bodies import Bodies, place_body, rounding_slack
from amorsim.kernels.body_hash import BodyHash, run_of_bodies, window
from amorsim.kernels.compile import kernel, part

__all__ = ["cast_bodies"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_SECTORS = 64  # of a turn, by which is remembered how far is seen; a power of two


@part
def _turn(cos: float, sin: float) -> float:
    """A number in [0, 4] that grows with the angle of (cos, sin) over [0, 2 pi): cheap, for ordering only."""
    along = cos / (abs(cos) + abs(sin))
    return 1.0 - along if sin >= 0.0 else 3.0 + along


@part
def _turns(cos_b: Floats, sin_b: Floats, row: int, turns: Floats) -> bool:
    """Write how far each beam is turned from the first; whether the beams are in that order."""
    in_order = True
    c = cos_b[row, 0]
    s = sin_b[row, 0]
    for j in range(cos_b.shape[1]):
        cos = c * cos_b[row, j] + s * sin_b[row, j]
        sin = c * sin_b[row, j] - s * cos_b[row, j]
        turns[j] = _turn(cos, sin)
        if j > 0 and not turns[j] >= turns[j - 1]:
            in_order = False
    return in_order


@part
def _beams_before(turns: Floats, limit: float, inclusive: bool) -> int:
    """How many beams are turned less than `limit`, or at most that far."""
    low = 0
    high = turns.shape[0]
    while low < high:
        middle = (low + high) // 2
        if turns[middle] < limit or (inclusive and turns[middle] == limit):
            low = middle + 1
        else:
            high = middle
    return low


@part
def _disc_range(x: float, y: float, radius: float, dx: float, dy: float) -> float:
    """Where a ray from the origin along (dx, dy) enters a disc [m]; 0 from inside, inf if it misses."""
    away = math.sqrt(x * x + y * y)
    if away <= radius:
        return 0.0
    along = dx * x + dy * y
    across = abs(dx * y - dy * x)
    if along <= 0.0 or across > radius:
        return math.inf
    # The smaller root as a quotient: the difference would cancel close to the disc.
    half_chord = math.sqrt((radius - across) * (radius + across))
    return (away - radius) * (away + radius) / (along + half_chord)


@part
def _polygon_ranges(
    edges: Floats, first: int, last: int, dx: Floats, dy: Floats, enters: Floats, leaves: Floats
) -> None:
    """Where rays from the origin enter and leave a convex polygon [m]; 0 from inside, and misses leave first.

    Edge by edge for all rays at once, and the cases chosen, not branched to: so several rays go side by side.
    """
    for b in range(dx.shape[0]):
        enters[b] = 0.0
        leaves[b] = math.inf
    for i in range(first, last):
        nx = edges[i, 2]
        ny = edges[i, 3]
        outside = edges[i, 0] * nx + edges[i, 1] * ny  # negative if the origin is outside
        along = -math.inf if outside < 0.0 else math.inf  # where a ray along the edge leaves
        for b in range(dx.shape[0]):
            speed = dx[b] * nx + dy[b] * ny
            at = outside / speed
            enters[b] = max(enters[b], at if speed < 0.0 else -math.inf)
            leaves[b] = min(leaves[b], at if speed > 0.0 else (along if speed == 0.0 else math.inf))


@part
def _rounded_range(edges: Floats, first: int, last: int, radius: float, dx: float, dy: float) -> float:
    """Where a ray from the origin enters a convex part rounded by `radius` [m]; 0 from inside, inf if it misses."""
    nearest = math.inf
    inside = last - first > 2
    for i in range(first, last):
        x = edges[i, 0]
        y = edges[i, 1]
        nearest = min(nearest, _disc_range(x, y, radius, dx, dy))
        length = math.sqrt(edges[i, 2] * edges[i, 2] + edges[i, 3] * edges[i, 3])
        nx = edges[i, 2] * edges[i, 4]
        ny = edges[i, 3] * edges[i, 4]
        core = x * nx + y * ny
        if core < 0.0:
            inside = False
        abreast = x * ny - y * nx  # of the origin, along the edge from its first vertex
        if core + radius >= 0.0:
            if core <= 0.0 and 0.0 <= abreast <= length:
                return 0.0
            continue
        speed = dx * nx + dy * ny
        if speed < 0.0:
            distance = (core + radius) / speed
            if 0.0 <= abreast + distance * (dy * nx - dx * ny) <= length:
                nearest = min(nearest, distance)
    return 0.0 if inside else nearest


@part
def _body_ranges(
    bodies: Bodies, body: int, edges: Floats, dx: Floats, dy: Floats, found: Floats, enters: Floats, leaves: Floats
) -> None:
    """Write where rays from the origin meet a body placed in `edges` [m]; 0 from inside, inf if they miss."""
    radius = bodies.radius[body]
    base = bodies.vertex_first[bodies.part_first[body]]
    for b in range(dx.shape[0]):
        found[b] = math.inf
    for piece in range(bodies.part_first[body], bodies.part_first[body + 1]):
        first = bodies.vertex_first[piece] - base
        last = bodies.vertex_first[piece + 1] - base
        if radius == 0.0:
            _polygon_ranges(edges, first, last, dx, dy, enters, leaves)
            for b in range(dx.shape[0]):
                found[b] = min(found[b], enters[b] if enters[b] <= leaves[b] else math.inf)
        elif last - first == 1:
            for b in range(dx.shape[0]):
                found[b] = min(found[b], _disc_range(edges[first, 0], edges[first, 1], radius, dx[b], dy[b]))
        else:
            for b in range(dx.shape[0]):
                found[b] = min(found[b], _rounded_range(edges, first, last, radius, dx[b], dy[b]))


@part
def _window_of_beams(
    turns: Floats, cos_0: float, sin_0: float, x: float, y: float, away: float, circle: float
) -> tuple[int, int, int]:
    """Beams start:stop, and those from `resume` on, that can meet a circle around (x, y); all others miss it.

    `turns` are of beams in order, of which the first has the direction (cos_0, sin_0).
    """
    sin_a = circle / away
    cos_a = math.sqrt((1.0 - sin_a) * (1.0 + sin_a))
    # The circle's centre as seen from the first beam, then both its tangents.
    cos_c = cos_0 * x + sin_0 * y
    sin_c = cos_0 * y - sin_0 * x
    right = _turn(cos_c * cos_a + sin_c * sin_a, sin_c * cos_a - cos_c * sin_a)
    left = _turn(cos_c * cos_a - sin_c * sin_a, sin_c * cos_a + cos_c * sin_a)
    start = _beams_before(turns, right, False)
    stop = _beams_before(turns, left, True)
    if right > left:  # the circle lies across the first beam
        return 0, stop, start
    return start, stop, turns.shape[0]


@part
def _farthest(ranges: Floats, turns: Floats, by_sector: bool, sectors: Floats) -> float:
    """The farthest of what is seen already, and into `sectors` that of each part of a turn, -inf without beams."""
    sectors[:] = -math.inf
    farthest = 0.0
    for b in range(ranges.shape[0]):
        farthest = max(farthest, ranges[b])
        if by_sector:
            sector = int(turns[b] * (_SECTORS / 4.0)) & (_SECTORS - 1)
            sectors[sector] = max(sectors[sector], ranges[b])
    return farthest


@part
def _is_hidden(sectors: Floats, cos_0: float, sin_0: float, x: float, y: float, away: float, circle: float) -> bool:
    """Whether a circle around (x, y) is farther than all that is seen in the sectors it lies in."""
    middle = _turn(cos_0 * x + sin_0 * y, cos_0 * y - sin_0 * x)
    # Turns grow at most as fast as angles, and an arc is at most half of pi times its sine.
    wide = 0.5 * math.pi * circle / away + 1e-9
    first = math.floor((middle - wide) * (_SECTORS / 4.0))
    last = math.floor((middle + wide) * (_SECTORS / 4.0))
    farthest = -math.inf
    for sector in range(first, last + 1):
        farthest = max(farthest, sectors[sector & (_SECTORS - 1)])
    return bool(farthest <= away - circle)


@part
def _cast_rows(
    bodies: Bodies,
    body_pose: Floats,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: Floats,
    out: Floats,
    hit: Ints,
    edges: Floats,
    turns: Floats,
    dx: Floats,
    dy: Floats,
    found: Floats,
    enters: Floats,
    leaves: Floats,
    sectors: Floats,
) -> None:
    """What `cast_bodies` does, with room to work in."""
    rows = out.shape[0]
    beams = cos_b.shape[1]
    stride = 1 if out.shape[1] == beams else 0
    wants_hit = hit.shape[1] > 0
    in_order = False
    for i in range(rows):
        beam_row = min(i, cos_b.shape[0] - 1)
        if beam_row == i:
            in_order = _turns(cos_b, sin_b, beam_row, turns)
        limit = range_max[min(i, range_max.shape[0] - 1)]
        origin_x = origins[i, 0]
        origin_y = origins[i, 1]
        cos_h = math.cos(origins[i, 2])
        sin_h = math.sin(origins[i, 2])
        cos_0 = cos_h * cos_b[beam_row, 0] - sin_h * sin_b[beam_row, 0]
        sin_0 = sin_h * cos_b[beam_row, 0] + cos_h * sin_b[beam_row, 0]
        # Nothing counts that is farther than all that is seen already, there or anywhere.
        by_sector = in_order and stride == 1
        farthest = _farthest(out[i], turns, by_sector, sectors)
        if farthest < limit:
            limit = farthest
        aimed = False
        origin_slack = rounding_slack(abs(origin_x) + abs(origin_y))
        around = limit + widest * (1.0 + 1e-9) + origin_slack
        row0, cell_rows = window(origin_y, around, table.side, table.rows)
        col0, cell_cols = window(origin_x, around, table.side, table.cols)
        for run in range(2 * cell_rows if col0 + cell_cols > table.cols else cell_rows):
            first, last = run_of_bodies(table, replica[i], row0, cell_rows, col0, cell_cols, run)
            for place in range(first, last):
                x = table.disc[place, 0] - origin_x
                y = table.disc[place, 1] - origin_y
                square = x * x + y * y
                # A circle around the body, larger than it needs to be by far more than rounding can matter.
                circle = table.disc[place, 2] * (1.0 + 1e-9) + origin_slack
                if square > (limit + circle) * (limit + circle) * (1.0 + 1e-9):
                    continue
                j = table.body[place]
                if j == own[i]:
                    continue
                away = math.sqrt(square)
                circle += 1e-9 * away
                start = 0
                stop = beams
                resume = beams
                windowed = in_order and circle < away
                if windowed:
                    if by_sector and _is_hidden(sectors, cos_0, sin_0, x, y, away, circle):
                        continue
                    start, stop, resume = _window_of_beams(turns, cos_0, sin_0, x, y, away, circle)
                    if start >= stop and resume >= beams:
                        continue
                if not aimed:
                    for b in range(beams):
                        dx[b] = cos_h * cos_b[beam_row, b] - sin_h * sin_b[beam_row, b]
                        dy[b] = sin_h * cos_b[beam_row, b] + cos_h * sin_b[beam_row, b]
                    aimed = True
                placed = False
                b = start
                while True:
                    if b >= stop:
                        b = max(b, resume)
                        stop = beams
                        resume = beams
                        if b >= beams:
                            break
                    # As many beams in a row as might meet the body before what they met so far.
                    begin = b
                    while b < stop and out[i, b * stride] > away - circle:
                        if not windowed and not (
                            abs(dx[b] * y - dy[b] * x) <= circle and dx[b] * x + dy[b] * y >= -circle
                        ):
                            break
                        b += 1
                    if b == begin:
                        b += 1
                        continue
                    if not placed:
                        cos_j = math.cos(body_pose[j, 2])
                        place_body(bodies, j, x, y, cos_j, math.sin(body_pose[j, 2]), edges)
                        placed = True
                    _body_ranges(bodies, j, edges, dx[begin:b], dy[begin:b], found[: b - begin], enters, leaves)
                    for c in range(begin, b):
                        distance = found[c - begin]
                        k = c * stride
                        if distance <= limit:
                            # In whatever order bodies come, the same one wins.
                            if distance < out[i, k]:
                                out[i, k] = distance
                                if wants_hit:
                                    hit[i, k] = j
                            elif wants_hit and distance == out[i, k] and j < hit[i, k]:
                                hit[i, k] = j


@kernel
def cast_bodies(
    bodies: Bodies,
    body_pose: Floats,
    edge_rows: int,
    table: BodyHash,
    widest: float,
    replica: Ints,
    own: Ints,
    origins: Floats,
    cos_b: Floats,
    sin_b: Floats,
    range_max: Floats,
    out: Floats,
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
        The body that carries the sensor and is not seen, -1 for none, int64 (N,).
    origins
        Where the rays of each row start, and what their bearings are measured from, (N, 3), like `body_pose`.
    cos_b, sin_b
        Of the beams' bearings b; the direction for heading h is (cos h cos b - sin h sin b, sin h cos b + cos
        h sin b). One row for all, or one each, (1 or N, k). Anticlockwise order within one turn is the
        fastest.
    range_max
        Beyond which nothing is seen [m], (1 or N,).
    out
        In: ranges so far [m], inf for none; out: the lower ones, (N, k), or the least of each row's, (N, 1).
    hit
        In: -1; gets the body's index where it lowered a range, int64, as `out`. Nobody asks if it has no columns.
    """
    beams = cos_b.shape[1]
    if beams == 0:
        return
    edges = np.empty((edge_rows, 5))
    turns = np.empty(beams)
    dx = np.empty(beams)
    dy = np.empty(beams)
    found = np.empty(beams)
    enters = np.empty(beams)
    leaves = np.empty(beams)
    sectors = np.empty(_SECTORS)
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
        out,
        hit,
        edges,
        turns,
        dx,
        dy,
        found,
        enters,
        leaves,
        sectors,
    )
