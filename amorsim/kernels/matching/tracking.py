"""Robots followed by their scans: each scan is matched with the last key scan, and some become the next key.

What a match says is put together with what the wheels said since the key, each by its information; along a direction
that the scan does not determine, the wheels alone count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import displaced, wrap
from amorsim.kernels.matching import correlative, icp
from amorsim.kernels.matching.outlines import Outline
from amorsim.kernels.matching.symmetric import invert

__all__ = [
    "DEGENERATE",
    "DIRECTION",
    "DISTANCE",
    "FIT",
    "RECORD",
    "SHARE",
    "USED",
    "WEAKEST",
    "Outlines",
    "Room",
    "Rules",
    "Tracks",
    "align_outlines",
    "align_pair",
    "make_keys",
    "room",
    "total_covariances",
    "track",
]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_FLOOR = 1e-3  # [m, rad] least standard deviation of what the wheels say between two scans

# What is kept of a match: its correction (x [m], y [m], heading [rad]) in the world, and these.
USED = 3  # 1 if it was used, 0 if it was refused
SHARE = 4  # of the scan's points that lie on the key scan
DISTANCE = 5  # [m] root mean square of these from its lines
FIT = 6  # of the correlative stage, from 0 to 1
DEGENERATE = 7  # 1 if the scan does not determine the pose
WEAKEST = 8  # least eigenvalue of the information by the largest
DIRECTION = 9  # (x, y, turn), in the world, in which the scan says least
RECORD = 12


class Outlines(NamedTuple):
    """Outlines of N rows; see `Outline`."""

    points: Floats  # (N, k, 2)
    lines: Floats  # (N, k, 4)
    rays: Floats  # (N, k, 2)


class Tracks(NamedTuple):
    """What N rows believe of where they are."""

    pose: Floats  # (N, 3)
    spread: Floats  # (N, 3, 3) covariance of the motion since the key, in the world
    key_pose: Floats  # (N, 3)
    key_covariance: Floats  # (N, 3, 3)
    last: Floats  # (N, 3) the pose at the last match; nan before the first scan


class Rules(NamedTuple):
    """When and how to match."""

    match_distance: float  # [m] between matches
    match_angle: float  # [rad]
    key_distance: float  # [m] between keys
    key_angle: float  # [rad]
    key_share: float  # of points on the key, below which the scan becomes the next key
    least_share: float  # of points on the key, below which a match is refused
    degenerate: float  # ratio of eigenvalues below which a scan does not determine the pose
    window: correlative.Window
    search: icp.Search


class Room(NamedTuple):
    """Room for one match."""

    work: icp.Work
    result: icp.Result
    prior: icp.Prior
    picture: correlative.Picture
    cells: npt.NDArray[np.int64]  # (k, 2)
    start: Floats  # (3,)
    matrix: Floats  # (3, 3)


def room(beams: int, reach: float, resolution: float, blur: float) -> Room:
    """Room for one match of scans of so many beams; points farther away than `reach` [m] are in no picture."""
    return Room(
        icp.work(beams),
        icp.result(),
        icp.no_prior(),
        correlative.picture(reach, resolution, blur),
        np.empty((beams, 2), np.int64),
        np.empty(3),
        np.empty((3, 3)),
    )


@part
def _relative(pose: Floats, other: Floats, out: Floats) -> None:
    """The displacement from a pose to another one, in the first one's frame."""
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    x = other[0] - pose[0]
    y = other[1] - pose[1]
    out[0] = c * x + s * y
    out[1] = c * y - s * x
    out[2] = wrap(other[2] - pose[2])


@part
def _turn(matrix: Floats, angle: float, out: Floats) -> None:
    """A covariance or information (3, 3) of x, y, heading in a frame turned by -angle, as seen from there."""
    c = math.cos(angle)
    s = math.sin(angle)
    a = matrix[0, 0]
    b = matrix[0, 1]
    d = matrix[1, 1]
    e = matrix[0, 2]
    f = matrix[1, 2]
    out[0, 0] = c * c * a - 2.0 * c * s * b + s * s * d
    out[0, 1] = c * s * (a - d) + (c * c - s * s) * b
    out[1, 1] = s * s * a + 2.0 * c * s * b + c * c * d
    out[0, 2] = c * e - s * f
    out[1, 2] = s * e + c * f
    out[2, 2] = matrix[2, 2]
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]


@kernel
def align_pair(reference: Outline, scan: Outline, rules: Rules, at: Room) -> float:
    """Match a scan with a reference from ``at.start``, by both stages; returns how well the correlative one fits."""
    fit = math.nan
    if rules.window.linear > 0.0:
        correlative.draw(reference.points, at.picture)
        fit = correlative.correlate(at.picture, scan.points, at.start, rules.window, at.cells, at.result.pose)
        for j in range(3):
            at.start[j] = at.result.pose[j]
    icp.align(reference, scan, at.start, at.prior, rules.search, at.work, at.result)
    return fit


@kernel
def align_outlines(pair: Outlines, rules: Rules, at: Room) -> float:
    """Match the second of two scans with the first from ``at.start``; returns how well the correlative stage fits."""
    return align_pair(
        Outline(pair.points[0], pair.lines[0], pair.rays[0]),
        Outline(pair.points[1], pair.lines[1], pair.rays[1]),
        rules,
        at,
    )


@part
def _swing(covariance: Floats, dx: float, dy: float, out: Floats) -> None:
    """Carry a pose's covariance (3, 3) to the end of a displacement (dx, dy) in the world."""
    for i in range(3):
        for j in range(3):
            out[i, j] = covariance[i, j]
    xh = out[0, 2]
    yh = out[1, 2]
    hh = out[2, 2]
    out[0, 0] += -dy * (2.0 * xh - dy * hh)
    out[0, 1] += dx * xh - dy * yh - dx * dy * hh
    out[1, 1] += dx * (2.0 * yh + dx * hh)
    out[0, 2] -= dy * hh
    out[1, 2] += dx * hh
    out[1, 0] = out[0, 1]
    out[2, 0] = out[0, 2]
    out[2, 1] = out[1, 2]


@kernel
def total_covariances(tracks: Tracks, out: Floats) -> None:
    """Covariances (N, 3, 3) of the poses: of the key's, and of the motion since."""
    for i in range(tracks.pose.shape[0]):
        dx = tracks.pose[i, 0] - tracks.key_pose[i, 0]
        dy = tracks.pose[i, 1] - tracks.key_pose[i, 1]
        _swing(tracks.key_covariance[i], dx, dy, out[i])
        for j in range(3):
            for k in range(3):
                out[i, j, k] += tracks.spread[i, j, k]


@kernel
def _make_key(i: int, scans: Outlines, keys: Outlines, tracks: Tracks, at: Room) -> None:
    """Let a row's scan be its key from now on."""
    dx = tracks.pose[i, 0] - tracks.key_pose[i, 0]
    dy = tracks.pose[i, 1] - tracks.key_pose[i, 1]
    _swing(tracks.key_covariance[i], dx, dy, at.matrix)
    for j in range(3):
        tracks.key_pose[i, j] = tracks.pose[i, j]
        for k in range(3):
            tracks.key_covariance[i, j, k] = at.matrix[j, k] + tracks.spread[i, j, k]
    keys.points[i] = scans.points[i]
    keys.lines[i] = scans.lines[i]
    keys.rays[i] = scans.rays[i]


@part
def _is_far(pose: Floats, other: Floats, distance: float, angle: float) -> bool:
    dx = pose[0] - other[0]
    dy = pose[1] - other[1]
    return bool(dx * dx + dy * dy >= distance * distance or abs(wrap(pose[2] - other[2])) >= angle)


@kernel
def track(
    scans: Outlines, fresh: Bools, keys: Outlines, tracks: Tracks, rules: Rules, at: Room, records: Floats, out: Bools
) -> None:
    """Match the new scans of N rows that have moved since their last match, and correct their tracks.

    `records` (N, 12) are of the matches of this step, nan where there was none. `out` (N, 2): whether a row has a new
    key, and whether it was matched. The motion since the old key, whose `spread` a caller may want, is set to 0 by the
    caller.
    """
    for i in range(fresh.shape[0]):
        out[i, 0] = False
        out[i, 1] = False
        if not fresh[i, 0]:
            continue
        if math.isnan(tracks.last[i, 0]):
            _make_key(i, scans, keys, tracks, at)
            tracks.last[i] = tracks.pose[i]
            out[i, 0] = True
            continue
        if not _is_far(tracks.pose[i], tracks.last[i], rules.match_distance, rules.match_angle):
            continue
        out[i, 1] = True
        share = _match(i, scans, keys, tracks, rules, at, records[i])
        tracks.last[i] = tracks.pose[i]
        if share < rules.key_share or _is_far(tracks.pose[i], tracks.key_pose[i], rules.key_distance, rules.key_angle):
            out[i, 0] = True


@kernel
def make_keys(scans: Outlines, is_new: Bools, keys: Outlines, tracks: Tracks, at: Room) -> None:
    """Let the scans of rows `is_new` (N, 2) be their keys, and count their motion from there."""
    for i in range(is_new.shape[0]):
        if is_new[i, 0]:
            _make_key(i, scans, keys, tracks, at)
            tracks.spread[i] = 0.0


@kernel
def _match(i: int, scans: Outlines, keys: Outlines, tracks: Tracks, rules: Rules, at: Room, record: Floats) -> float:
    """Match a row's scan with its key and correct its track; returns the share of points on the key."""
    scan = Outline(scans.points[i], scans.lines[i], scans.rays[i])
    key = Outline(keys.points[i], keys.lines[i], keys.rays[i])
    heading = tracks.key_pose[i, 2]
    _relative(tracks.key_pose[i], tracks.pose[i], at.prior.pose)
    _turn(tracks.spread[i], -heading, at.matrix)
    for j in range(3):
        at.matrix[j, j] += _FLOOR * _FLOOR
        at.start[j] = at.prior.pose[j]
    invert(at.matrix, at.prior.information)
    record[FIT] = align_pair(key, scan, rules, at)
    found = at.result
    share: float = found.quality[0]
    record[SHARE] = share
    record[DISTANCE] = found.quality[1]
    record[WEAKEST] = found.values[0] / found.values[2] if found.values[2] > 0.0 else 0.0
    record[DEGENERATE] = 1.0 if record[WEAKEST] < rules.degenerate else 0.0
    c = math.cos(heading)
    s = math.sin(heading)
    record[DIRECTION] = c * found.vectors[0, 0] - s * found.vectors[1, 0]
    record[DIRECTION + 1] = s * found.vectors[0, 0] + c * found.vectors[1, 0]
    record[DIRECTION + 2] = found.vectors[2, 0]
    record[USED] = 0.0
    if share < rules.least_share:
        return share
    record[USED] = 1.0
    x, y, turned = displaced(
        tracks.key_pose[i, 0], tracks.key_pose[i, 1], heading, found.pose[0], found.pose[1], found.pose[2]
    )
    record[0] = x - tracks.pose[i, 0]
    record[1] = y - tracks.pose[i, 1]
    record[2] = wrap(turned - tracks.pose[i, 2])
    tracks.pose[i, 0] = x
    tracks.pose[i, 1] = y
    tracks.pose[i, 2] = turned
    for j in range(3):
        for k in range(3):
            at.prior.information[j, k] += found.information[j, k]
    if invert(at.prior.information, at.matrix):
        _turn(at.matrix, heading, tracks.spread[i])
    return share
