"""Iterative closest points, from points to lines: how a scan moves to lie on another one.

Each point of the scan is paired with the nearest line of the reference, and the squares of the distances across the
lines are made least by Gauss-Newton; then points are paired again. What a scan cannot tell, such as the place along a
corridor, is left to what was known before. Source: A. Censi, "An ICP variant using a point-to-line metric" (2008); the
trimming of bad pairs follows its program, CSM.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap
from amorsim.kernels.matching import priors
from amorsim.kernels.matching.outlines import Outline
from amorsim.kernels.matching.priors import Prior, keep
from amorsim.kernels.matching.symmetric import UNDETERMINED, directions, eigen, solve
from amorsim.kernels.sorting import sort

__all__ = [
    "Reference",
    "Result",
    "Search",
    "Work",
    "align",
    "fisher",
    "index",
    "own_information",
    "refer",
    "reference",
    "result",
    "work",
]


_ORDER = 0.7  # pairs farther apart than twice the distance that this part of them has are left out
_BEYOND = 2.0
_SURE = 2.0  # standard deviations of a range, within which no pair is left out
_NEAR = 0.01  # [m, rad] step below which pairs are chosen more strictly
_ALIKE = math.cos(math.radians(30.0))  # of the angle between the surfaces at both ends of a pair
_OWN, _OWN_TURN = 0.01, 0.004  # [m], [rad] by which all points of a scan are off together, at most
_GRAZING = 0.05  # added to the squared cosine of the incidence, as lines are never exact
_SLANT = 1e-3  # least cosine of the incidence in Fisher's information


class Reference(NamedTuple):
    """The surface that scans are aligned with, in a robot's frame: points and short lines, nan beyond the last."""

    points: Array  # (s, 2) [m]
    lines: Array  # (s, 4) as of `Outline`
    order: Ints  # (s,) the lines by their x
    along: Array  # (s,) [m] x in that order, inf beyond the last


class Search(NamedTuple):
    """How to align."""

    std: float  # [m] of a range
    farthest: float  # [m] that a pair may be apart at first
    iterations: int
    tolerance: float  # [m, rad] of a step that is the last
    degenerate: float = 0.01  # ratio of eigenvalues below which a scan does not determine the pose


class Result(NamedTuple):
    """The result of an alignment."""

    pose: Array  # (3,) of the scan's robot in the reference's frame
    information: Array  # (3, 3) from the scan alone
    values: Array  # (3,) its eigenvalues with angles in lengths (see `align`), the least first
    vectors: Array  # (3, 3) and their directions, in columns
    quality: Array  # (3,) share of points that have a pair, root mean square of their distances [m], steps
    kept: Array  # (3, 3) the prior's information, as it counted


class Work(NamedTuple):
    """Room for one alignment of scans of k beams."""

    pairs: Ints  # (k,)
    apart: Array  # (k,) square of the distance of a point from its line's point [m^2]
    across: Array  # (k,) and from the line
    ordered: Array  # (k,)
    slopes: Array  # (k, 3) of a point's distance from its line, by the pose
    off: Array  # (k,) that distance [m]
    weights: Array  # (k,) how much it counts [1/m^2]
    sums: Array  # (3, 3)
    vectors: Array  # (3, 3)
    numbers: Array  # (3, 3): values, right side, step
    prior: priors.Room


def reference(size: int) -> Reference:
    """Room for a reference of so many points."""
    return Reference(np.full((size, 2), np.nan), np.full((size, 4), np.nan), np.arange(size), np.full(size, math.inf))


@kernel
def refer(scan: Outline, out: Reference) -> None:
    """Let a scan be the reference."""
    out.points[:] = scan.points
    out.lines[:] = scan.lines
    index(out)


@part
def index(out: Reference) -> None:
    """Put the lines of a reference in order."""
    for j in range(out.along.shape[0]):
        x = out.lines[j, 0]
        out.along[j] = math.inf if math.isnan(x) else x
        out.order[j] = j
    sort(out.along, out.order)


def work(beams: int) -> Work:
    """Room for one alignment."""
    return Work(
        np.empty(beams, np.int64),
        np.empty(beams),
        np.empty(beams),
        np.empty(beams),
        np.empty((beams, 3)),
        np.empty(beams),
        np.empty(beams),
        np.empty((3, 3)),
        np.empty((3, 3)),
        np.empty((3, 3)),
        priors.room(),
    )


def result() -> Result:
    """Room for a result."""
    return Result(np.zeros(3), np.zeros((3, 3)), np.zeros(3), np.zeros((3, 3)), np.zeros(3), np.zeros((3, 3)))


@part
def _nearest(reference: Reference, x: float, y: float, u: float, v: float, farthest: float) -> tuple[int, float]:
    """The line nearest to a point, on the side that a beam (u, v) hits, or -1; and the square of its distance."""
    least = farthest * farthest
    best = -1
    size = reference.along.shape[0]
    right = int(np.searchsorted(reference.along, x))
    left = right - 1
    while True:
        before = x - reference.along[left] if left >= 0 else math.inf
        after = reference.along[right] - x if right < size else math.inf
        aside = min(before, after)
        if not aside * aside < least:
            return best, least
        if before < after:
            j = reference.order[left]
            left -= 1
        else:
            j = reference.order[right]
            right += 1
        line = reference.lines[j]
        across = y - line[1]
        square = aside * aside + across * across
        if square < least and line[2] * u + line[3] * v < 0.0:
            least = square
            best = int(j)


@part
def _is_unlike(reference: Reference, j: int, scan: Outline, i: int, c: float, s: float) -> bool:
    """Whether the surface around a scan's point is turned against a line of the reference by too much."""
    nx = c * scan.lines[i, 2] - s * scan.lines[i, 3]
    ny = s * scan.lines[i, 2] + c * scan.lines[i, 3]
    return bool(nx * reference.lines[j, 2] + ny * reference.lines[j, 3] < _ALIKE)  # never for nan


@kernel
def _trim(apart: Array, least: float, at: Work) -> None:
    """Leave out pairs whose squares `apart` are much larger than most, and larger than `least`."""
    count = 0
    for i in range(at.pairs.shape[0]):
        if at.pairs[i] >= 0:
            at.ordered[count] = apart[i]
            count += 1
    at.ordered[:count].sort()
    most = max(least, at.ordered[int(_ORDER * (count - 1))] * _BEYOND * _BEYOND)
    for i in range(at.pairs.shape[0]):
        if at.pairs[i] >= 0 and apart[i] > most:
            at.pairs[i] = -1


@kernel
def _pair(reference: Reference, scan: Outline, pose: Array, search: Search, is_near: bool, at: Work) -> int:
    """Pair each point with the nearest line's point; -1 where none is near. Returns how many points there are.

    Once the pose `is_near`, surfaces at both ends must be turned alike, and points lie near their lines.
    """
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    points = 0
    found = 0
    for i in range(scan.points.shape[0]):
        at.pairs[i] = -1
        px = scan.points[i, 0]
        if math.isnan(px):
            continue
        points += 1
        py = scan.points[i, 1]
        x = pose[0] + c * px - s * py
        y = pose[1] + s * px + c * py
        u = c * scan.rays[i, 0] - s * scan.rays[i, 1]
        v = s * scan.rays[i, 0] + c * scan.rays[i, 1]
        best, least = _nearest(reference, x, y, u, v, search.farthest)
        if best >= 0 and not (is_near and _is_unlike(reference, best, scan, i, c, s)):
            line = reference.lines[best]
            at.pairs[i] = best
            at.apart[i] = least
            at.across[i] = (line[2] * (x - line[0]) + line[3] * (y - line[1])) ** 2
            found += 1
    if found > 0:
        _trim(at.apart, 0.0, at)
    if found > 0 and is_near:
        _trim(at.across, (_SURE * search.std) ** 2, at)
    return points


@kernel
def _linearize(reference: Reference, scan: Outline, pose: Array, std: float, at: Work) -> None:
    """Compute how far paired points are off their lines, its slopes by the pose, and how much each pair counts."""
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    for i in range(scan.points.shape[0]):
        j = at.pairs[i]
        if j < 0:
            continue
        nx = reference.lines[j, 2]
        ny = reference.lines[j, 3]
        rx = c * scan.points[i, 0] - s * scan.points[i, 1]
        ry = s * scan.points[i, 0] + c * scan.points[i, 1]
        along = nx * (c * scan.rays[i, 0] - s * scan.rays[i, 1]) + ny * (s * scan.rays[i, 0] + c * scan.rays[i, 1])
        at.slopes[i, 0] = nx
        at.slopes[i, 1] = ny
        at.slopes[i, 2] = ny * rx - nx * ry
        at.off[i] = nx * (pose[0] + rx - reference.lines[j, 0]) + ny * (pose[1] + ry - reference.lines[j, 1])
        at.weights[i] = 1.0 / (std * std * (along * along + _GRAZING))


@part
def _sum_up(at: Work, information: Array) -> tuple[int, float]:
    """Sum the pairs' information, and their pull into ``at.numbers[1]``; returns their number and squared distance."""
    information[:] = 0.0
    right = at.numbers[1]
    right[:] = 0.0
    used = 0
    squares = 0.0
    for i in range(at.pairs.shape[0]):
        if at.pairs[i] < 0:
            continue
        weight = at.weights[i]
        nx = at.slopes[i, 0]
        ny = at.slopes[i, 1]
        turn = at.slopes[i, 2]
        off = at.off[i]
        information[0, 0] += weight * nx * nx
        information[0, 1] += weight * nx * ny
        information[0, 2] += weight * nx * turn
        information[1, 1] += weight * ny * ny
        information[1, 2] += weight * ny * turn
        information[2, 2] += weight * turn * turn
        right[0] -= weight * nx * off
        right[1] -= weight * ny * off
        right[2] -= weight * turn * off
        squares += off * off
        used += 1
    information[1, 0] = information[0, 1]
    information[2, 0] = information[0, 2]
    information[2, 1] = information[1, 2]
    return used, squares


@part
def _leave_out_unchecked(arm: float, at: Work, information: Array) -> None:
    """Let each pair count as far as the others check it: by its redundancy, 1 less the share that it has in the pose.

    Along a corridor a point or two at a door frame may alone tell the place; nothing would show it if their line were
    wrong, as at corners it often is. Source of redundancy numbers: W. Baarda, "A testing procedure for use in geodetic
    networks" (1968).
    """
    values = at.numbers[0]
    directions(information, arm, at.sums, values, at.vectors)
    for i in range(at.pairs.shape[0]):
        if at.pairs[i] < 0:
            continue
        share = 0.0
        for k in range(3):
            if values[k] > UNDETERMINED * values[2]:
                slope = at.slopes[i, 0] * at.vectors[0, k] + at.slopes[i, 1] * at.vectors[1, k]
                slope += at.slopes[i, 2] / arm * at.vectors[2, k]
                share += at.weights[i] * slope * slope / values[k]
        at.weights[i] *= max(0.0, 1.0 - share)


@part
def _arm(scan: Outline) -> float:
    """The root mean square distance [m] of a scan's points from its robot; 1 for none."""
    points = 0
    squares = 0.0
    for i in range(scan.points.shape[0]):
        if not math.isnan(scan.points[i, 0]):
            points += 1
            squares += scan.points[i, 0] ** 2 + scan.points[i, 1] ** 2
    return math.sqrt(squares / points) if squares > 0.0 else 1.0


@kernel
def align(
    reference: Reference, scan: Outline, start: Array, prior: Prior, search: Search, at: Work, out: Result
) -> None:
    """Align a scan with a reference, from a pose `start` (3,) in the reference's frame.

    For the eigenvalues, angles count as the length that the points' root mean square distance turns by, so that all
    three have one unit. Their directions are unit vectors of (x, y, that length).

    At first, while it may be far away, all pairs count that are no farther apart than most. If that does not lead to
    an end, it begins anew with those only that a pose nearby would have.
    """
    pose = out.pose
    pose[:] = start
    points = 0
    used = 0
    squares = 0.0
    values, right, step = at.numbers[0], at.numbers[1], at.numbers[2]
    is_near = False
    arm = _arm(scan)
    count = 0
    while count < search.iterations:
        count += 1
        points = _pair(reference, scan, pose, search, is_near, at)
        _linearize(reference, scan, pose, search.std, at)
        used, squares = _sum_up(at, out.information)
        if used == 0:
            break
        _leave_out_unchecked(arm, at, out.information)
        _sum_up(at, out.information)
        off = pose[0] - prior.pose[0], pose[1] - prior.pose[1], wrap(pose[2] - prior.pose[2])
        keep(prior, out.information, right, off, arm, search.degenerate, at.prior, out.kept)
        for i in range(3):
            for j in range(3):
                at.sums[i, j] = out.information[i, j] + out.kept[i, j]
                right[i] -= out.kept[i, j] * off[j]
        eigen(at.sums, values, at.vectors)
        solve(values, at.vectors, right, UNDETERMINED, step)
        pose[0] += step[0]
        pose[1] += step[1]
        pose[2] = wrap(pose[2] + step[2])
        moved = max(abs(step[0]), abs(step[1]), abs(step[2]))
        if is_near and moved <= search.tolerance:
            break
        is_near = is_near or moved <= _NEAR
        if not is_near and count == search.iterations // 2:
            is_near = True  # pairs far apart have led it astray
            pose[:] = start
    directions(out.information, arm, at.sums, out.values, out.vectors)
    out.quality[0] = used / points if points > 0 else 0.0
    out.quality[1] = math.sqrt(squares / used) if used > 0 else math.nan
    out.quality[2] = count


@kernel
def own_information(scan: Outline, std: float, at: Work, out: Array) -> None:
    """Information (3, 3) on how far all points of a scan are off together, in its robot's frame."""
    for i in range(scan.points.shape[0]):
        nx = scan.lines[i, 2]
        ny = scan.lines[i, 3]
        at.pairs[i] = -1 if math.isnan(nx) else i
        if math.isnan(nx):
            continue
        along = nx * scan.rays[i, 0] + ny * scan.rays[i, 1]
        at.slopes[i, 0] = nx
        at.slopes[i, 1] = ny
        at.slopes[i, 2] = ny * scan.points[i, 0] - nx * scan.points[i, 1]
        at.off[i] = 0.0
        at.weights[i] = 1.0 / (std * std * (along * along + _GRAZING))
    _sum_up(at, out)
    _leave_out_unchecked(_arm(scan), at, out)
    _sum_up(at, out)
    for i in range(3):
        out[i, i] += 1.0 / (_OWN_TURN * _OWN_TURN if i == 2 else _OWN * _OWN)


@kernel
def fisher(ranges: Array, normals: Array, rays: Array, std: float, out: Array) -> None:
    """Fisher's information (3, 3) of a scan on the pose of its laser, if ranges have white noise of `std` [m].

    With the normal's direction α, β = α less the beam's direction and the range r, a range's slopes by the pose are
    cos α / cos β, sin α / cos β, r tan β. Source: A. Censi, "On achievable accuracy for range-finder localization"
    (2007). `normals` (k, 2) and `rays` (k, 2) are unit vectors in the world; beams of inf or nan count nothing.
    """
    out[:] = 0.0
    for i in range(ranges.shape[0]):
        cosine = normals[i, 0] * rays[i, 0] + normals[i, 1] * rays[i, 1]
        if not (ranges[i] < math.inf and abs(cosine) > _SLANT):
            continue
        sine = normals[i, 1] * rays[i, 0] - normals[i, 0] * rays[i, 1]
        a = normals[i, 0] / cosine
        b = normals[i, 1] / cosine
        d = ranges[i] * sine / cosine
        out[0, 0] += a * a
        out[0, 1] += a * b
        out[0, 2] += a * d
        out[1, 1] += b * b
        out[1, 2] += b * d
        out[2, 2] += d * d
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]
    for i in range(3):
        for j in range(3):
            out[i, j] /= std * std
