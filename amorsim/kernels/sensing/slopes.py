"""The angle at which beams hit walls, from the ends of beams close to them."""

from __future__ import annotations

import math

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part

__all__ = ["bodies_in_cones", "incidences", "nearest_rays", "probe"]


_SLACK = 1e-9  # relative, by which a cone or a body is taken for larger than it is


@kernel
def nearest_rays(bearings: Array, ranges: Array, bearing: Array, nearest: Array) -> None:
    """Write bearing and range of the nearest of each row's rays, the first of equals, into `bearing`, `nearest` (M, 1).

    `bearings` (1 or M, k) [rad] and `ranges` (M, k) [m]; where all are inf, the first ray's.
    """
    for m in range(ranges.shape[0]):
        best = 0
        for k in range(1, ranges.shape[1]):
            if ranges[m, k] < ranges[m, best]:
                best = k
        bearing[m, 0] = bearings[m if bearings.shape[0] > 1 else 0, best]
        nearest[m, 0] = ranges[m, best]


@part
def _end(reach: float, turn: float, ahead: float) -> tuple[float, float, float]:
    """Where a probe ends, along and across its beam [m], and how far from the beam's end; inf for nowhere."""
    if not math.isfinite(reach):
        return 0.0, 0.0, math.inf
    x, y = reach * math.cos(turn), reach * math.sin(turn)
    return x, y, math.sqrt((x - ahead) * (x - ahead) + y * y)


@kernel
def probe(bearings: Array, ranges: Array, patch: float, cos: Array, sin: Array) -> None:
    """Write the directions (M, 2 k) of two probes for each beam, on its left and its right: first all on the left.

    They meet a wall across the beam's end so far `patch` [m] beside it. Of the beams, `bearings` (1 or M, k) [rad] and
    `ranges` (M, k) [m]; where a range is inf its probes are of no use.
    """
    beams = ranges.shape[1]
    for m in range(ranges.shape[0]):
        for k in range(beams):
            bearing = bearings[m if bearings.shape[0] > 1 else 0, k]
            turn = _turn(ranges[m, k], patch)
            cos[m, k], sin[m, k] = math.cos(bearing + turn), math.sin(bearing + turn)
            cos[m, beams + k], sin[m, beams + k] = math.cos(bearing - turn), math.sin(bearing - turn)


@part
def _turn(reach: float, patch: float) -> float:
    """From a beam to its probe [rad]."""
    return math.atan2(patch, reach if math.isfinite(reach) else 1.0)


@kernel
def incidences(ranges: Array, probes: Array, patch: float, even: float, out: Array) -> None:
    """Angles of incidence [rad] on walls (M, k), by the line through two places close to where each beam ends.

    The places are where probes end, to either side of the beam; or the nearer probe's end and the beam's, where one is
    more than `even` times as far from the beam's end as the other, and so lies on another surface. 0 where the beam
    ends nowhere, or both probes do.

    Parameters
    ----------
    ranges
        Of the beams [m], inf for none, (M, k).
    probes
        How far the probes go [m], (M, 2 k), in the directions of `probe` for the same `patch` [m].
    """
    beams = ranges.shape[1]
    for m in range(ranges.shape[0]):
        for k in range(beams):
            out[m, k] = 0.0
            ahead, left, right = ranges[m, k], probes[m, k], probes[m, beams + k]
            if not math.isfinite(ahead):
                continue
            turn = _turn(ahead, patch)
            left_x, left_y, left_gap = _end(left, turn, ahead)
            right_x, right_y, right_gap = _end(right, -turn, ahead)
            if not math.isfinite(min(left_gap, right_gap)):
                continue
            if max(left_gap, right_gap) <= even * min(left_gap, right_gap):
                along, across = left_x - right_x, left_y - right_y
            elif left_gap <= right_gap:
                along, across = left_x - ahead, left_y
            else:
                along, across = right_x - ahead, right_y
            out[m, k] = math.atan2(abs(along), abs(across))


@kernel
def bodies_in_cones(
    origins: Array,
    half_angle: Array,
    nearest: Array,
    range_max: Array,
    poses: Array,
    reach: Array,
    owner: Ints,
    own: Ints,
    out: Bools,
) -> None:
    """Whether the circle around a body, but for the cone's carrier and its parts, may come into a cone near enough.

    Parameters
    ----------
    origins, nearest
        Where cones are and look, (M, 3), k for each of N rows in turn, and how far [m] they are of interest, (M, 1).
    half_angle, range_max
        Of the row's cones, (N, 1): hardly more than a quarter turn [rad], and how far they reach [m].
    poses, reach, owner, own
        All bodies of each row, (N, B, 3), their circles [m] and owners, (B,), and which is the row's, (N,).
    out
        (M,).
    """
    rows = poses.shape[0]
    k = origins.shape[0] // rows
    for m in range(origins.shape[0]):
        n = m // k
        out[m] = False
        cos, sin = math.cos(origins[m, 2]), math.sin(origins[m, 2])
        cos_half, sin_half = math.cos(half_angle[n, 0]), math.sin(half_angle[n, 0])
        for b in range(poses.shape[1]):
            if b == own[n] or owner[b] == own[n]:
                continue
            x, y = poses[n, b, 0] - origins[m, 0], poses[n, b, 1] - origins[m, 1]
            away = math.sqrt(x * x + y * y)
            circle = reach[b] + _SLACK * (1.0 + away + abs(origins[m, 0]) + abs(origins[m, 1]))
            if away - circle > min(nearest[m, 0], range_max[n, 0]):
                continue
            # How far the centre is beyond the line of the nearer edge of the cone.
            ahead, aside = cos * x + sin * y, abs(cos * y - sin * x)
            if aside * cos_half - ahead * sin_half <= circle:
                out[m] = True
                break
