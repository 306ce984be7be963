"""Robots followed by their scans: each scan is matched with the last key scan, and some become the next key.

What a match says is put together with what the wheels said since the key, each by its information; along a direction
that the scan does not determine, the wheels alone count.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import wrap
from amorsim.kernels.matching import correlative, icp
from amorsim.kernels.matching.keys import extend
from amorsim.kernels.matching.outlines import Outline
from amorsim.kernels.matching.priors import Prior, no_prior
from amorsim.kernels.matching.symmetric import invert
from amorsim.kernels.matching.tracks import (
    Correction,
    Tracks,
    begin_key,
    correct,
    correction,
    forget_correction,
    relative,
    turn,
)

__all__ = [
    "DEGENERATE",
    "DIRECTION",
    "DISTANCE",
    "FIT",
    "RECORD",
    "SHARE",
    "USED",
    "WEAKEST",
    "Keys",
    "Outlines",
    "Room",
    "Rules",
    "align_outline",
    "room",
    "track",
]


_ASIDE = math.radians(10.0)  # that the second stage may turn farther than the window
_FARTHER = 3.0  # times the window, in which a scan is looked for that does not fit
_CLEARLY = 0.1  # how much better it must fit there
_FREEDOM = 3.0  # of the wheels' error, which slip makes much larger now and then
_FLOOR = 1e-3  # [m, rad] least standard deviation of what the wheels say between two scans

# What is kept of a match: its correction (x [m], y [m], heading [rad]) in the world, and these.
USED = 3  # 1 if it was used, 0 if it was refused
SHARE = 4  # of the scan's points that lie on the key scan
DISTANCE = 5  # [m] root mean square of these from its lines
FIT = 6  # of the scan's points on the key's, at most 1
DEGENERATE = 7  # 1 if the scan does not determine the pose
WEAKEST = 8  # least eigenvalue of the information by the largest
DIRECTION = 9  # (x, y, turn), in the world, in which the scan says least
RECORD = 12


class Outlines(NamedTuple):
    """Outlines of N rows; see `Outline`."""

    points: Array  # (N, k, 2)
    lines: Array  # (N, k, 4)
    rays: Array  # (N, k, 2)


class Keys(NamedTuple):
    """The keys of N rows; see `Reference`."""

    points: Array  # (N, s, 2)
    lines: Array  # (N, s, 4)
    order: Ints  # (N, s)
    along: Array  # (N, s)
    seen: Array  # (N, k, 2) points of the last scan in them
    mounts: Array  # (N, 3) of the lasers


class Rules(NamedTuple):
    """When and how to match."""

    match_distance: float  # [m] between matches
    match_angle: float  # [rad]
    key_distance: float  # [m] between keys
    key_angle: float  # [rad]
    key_share: float  # of points on the key, below which the scan becomes the next key
    least_fit: float  # below which a match is refused
    sure_fit: float  # below which a pose is looked for farther away
    window: correlative.Window
    search: icp.Search


class Room(NamedTuple):
    """Room for one match."""

    work: icp.Work
    result: icp.Result
    prior: Prior
    picture: correlative.Picture
    cells: Ints  # (k, 2)
    start: Array  # (3,)
    matrix: Array  # (3, 3)
    free: Prior  # nothing known
    found: Array  # (3,)
    spread: Array  # (3, 3)
    correction: Correction


def room(beams: int, reach: float, resolution: float, blur: float) -> Room:
    """Room for one match of scans of so many beams; points farther away than `reach` [m] are in no picture."""
    return Room(
        icp.work(beams),
        icp.result(),
        no_prior(_FREEDOM),
        correlative.picture(reach, resolution, blur),
        np.empty((beams, 2), np.int64),
        np.empty(3),
        np.empty((3, 3)),
        no_prior(),
        np.empty(3),
        np.empty((3, 3)),
        correction(),
    )


@kernel
def _draw(reference: icp.Reference, seen: Array, mount: Array, at: Room) -> None:
    """Draw the picture of a reference, and the free space that its last scan saw."""
    correlative.draw(reference.points, at.picture)
    correlative.clear(seen, mount[0], mount[1], at.picture)


@kernel
def align_outline(
    reference: icp.Reference, scan: Outline, window: correlative.Window, prior: Prior, rules: Rules, at: Room
) -> float:
    """Align a scan with a reference from ``at.start``, by both stages; returns how well it fits in the end.

    Where the second stage leads out of the window, the first one's pose is the result, which fits nothing.
    """
    if window.linear > 0.0:
        correlative.correlate(at.picture, scan.points, at.start, window, at.cells, at.found)
    else:
        for j in range(3):
            at.found[j] = at.start[j]
    icp.align(reference, scan, at.found, prior, rules.search, at.work, at.result)
    pose = at.result.pose
    off = math.hypot(pose[0] - at.start[0], pose[1] - at.start[1])
    turned = abs(wrap(pose[2] - at.start[2]))
    if not (off <= 1.5 * window.linear + rules.search.farthest and turned <= window.angular + _ASIDE):
        return 0.0
    return correlative.weigh(at.picture, scan.points, pose)


@kernel
def _key(keys: Keys, i: int) -> icp.Reference:
    """The key of a row."""
    return icp.Reference(keys.points[i], keys.lines[i], keys.order[i], keys.along[i])


@kernel
def _make_key(i: int, scans: Outlines, keys: Keys, tracks: Tracks, std: float, at: Room) -> None:
    """Let a row's scan be its key from now on."""
    scan = Outline(scans.points[i], scans.lines[i], scans.rays[i])
    icp.own_information(scan, std, at.work, at.matrix)
    begin_key(i, tracks, at.matrix, at.correction, at.start)
    extend(scan, _key(keys, i), at.start)
    for j in range(keys.seen.shape[1]):
        for k in range(2):
            keys.seen[i, j, k] = scans.points[i, j, k]


@part
def _is_far(pose: Array, other: Array, distance: float, angle: float) -> bool:
    dx = pose[0] - other[0]
    dy = pose[1] - other[1]
    return bool(dx * dx + dy * dy >= distance * distance or abs(wrap(pose[2] - other[2])) >= angle)


@part
def _has_changed(points: Array, before: Array, by: float) -> bool:
    """Whether most beams that see something see it nearer or farther than before, by more than `by` [m].

    So a robot whose wheels slip or stand is seen to move.
    """
    seen = 0
    changed = 0
    for j in range(points.shape[0]):
        dx = points[j, 0] - before[j, 0]
        dy = points[j, 1] - before[j, 1]
        square = dx * dx + dy * dy
        if not math.isnan(square):
            seen += 1
            if square > by * by:
                changed += 1
    return 2 * changed > seen


@part
def _remember(i: int, scans: Outlines, tracks: Tracks) -> None:
    """Keep the pose and the scan of a match."""
    for j in range(3):
        tracks.last[i, j] = tracks.pose[i, j]
    for j in range(scans.points.shape[1]):
        for k in range(2):
            tracks.last_points[i, j, k] = scans.points[i, j, k]


@kernel
def track(
    scans: Outlines, fresh: Bools, keys: Keys, tracks: Tracks, rules: Rules, at: Room, records: Array, out: Bools
) -> None:
    """Match the new scans of N rows that have moved since their last match, and correct their tracks.

    They have moved if the wheels or the scans have it so. `records` (N, 12) are of the matches of this step, nan where
    there was none. `out` (N, 2): whether a row has a new key, and whether it was matched.
    """
    for i in range(fresh.shape[0]):
        out[i, 0] = False
        out[i, 1] = False
        if not fresh[i, 0]:
            continue
        if math.isnan(tracks.last[i, 0]):
            forget_correction(at.correction)
            _make_key(i, scans, keys, tracks, rules.search.std, at)
            _remember(i, scans, tracks)
            out[i, 0] = True
            continue
        if not (
            _is_far(tracks.pose[i], tracks.last[i], rules.match_distance, rules.match_angle)
            or _has_changed(scans.points[i], tracks.last_points[i], rules.match_distance + rules.search.std)
        ):
            continue
        out[i, 1] = True
        share = _match(i, scans, keys, tracks, rules, at, records[i])
        _remember(i, scans, tracks)
        if share < rules.key_share or _is_far(tracks.pose[i], tracks.key_pose[i], rules.key_distance, rules.key_angle):
            _make_key(i, scans, keys, tracks, rules.search.std, at)
            out[i, 0] = True


@part
def _is_at_border(window: correlative.Window, at: Room) -> bool:
    """Whether the first stage's pose is at the border of the window: the best one may be beyond."""
    inside = window.linear - at.picture.resolution
    return bool(
        abs(at.found[0] - at.start[0]) > inside
        or abs(at.found[1] - at.start[1]) > inside
        or abs(wrap(at.found[2] - at.start[2])) > window.angular - window.angular_step
    )


@kernel
def _look_farther(key: icp.Reference, scan: Outline, fit: float, rules: Rules, at: Room) -> float:
    """Look for a pose in a window several times as large, and take it if it fits clearly better; returns how well."""
    wide = correlative.Window(
        _FARTHER * rules.window.linear, min(_FARTHER * rules.window.angular, math.pi), rules.window.angular_step
    )
    farther = align_outline(key, scan, wide, at.prior, rules, at)
    if farther > fit + _CLEARLY:
        return farther
    return align_outline(key, scan, rules.window, at.prior, rules, at)


@part
def _doubt(window: correlative.Window, spread: Array) -> None:
    """Widen the covariance of a motion that no scan confirms: it may be off by half of the window."""
    for j in range(2):
        spread[j, j] += 0.25 * window.linear * window.linear
    spread[2, 2] += 0.25 * window.angular * window.angular


@kernel
def _match(i: int, scans: Outlines, keys: Keys, tracks: Tracks, rules: Rules, at: Room, record: Array) -> float:
    """Match a row's scan with its key and correct its track; returns the share of points on the key."""
    scan = Outline(scans.points[i], scans.lines[i], scans.rays[i])
    key = _key(keys, i)
    heading = tracks.key_pose[i, 2]
    relative(tracks.key_pose[i], tracks.pose[i], at.prior.pose)
    turn(tracks.spread[i], -heading, at.matrix)
    for j in range(3):
        at.matrix[j, j] += _FLOOR * _FLOOR
        at.start[j] = at.prior.pose[j]
    invert(at.matrix, at.prior.information)
    _draw(key, keys.seen[i], keys.mounts[i], at)
    fit = align_outline(key, scan, rules.window, at.prior, rules, at)
    if rules.window.linear > 0.0 and (fit < rules.sure_fit or _is_at_border(rules.window, at)):
        fit = _look_farther(key, scan, fit, rules, at)
    found = at.result
    share: float = found.quality[0]
    record[FIT] = fit
    record[SHARE] = share
    record[DISTANCE] = found.quality[1]
    record[WEAKEST] = found.values[0] / found.values[2] if found.values[2] > 0.0 else 0.0
    record[DEGENERATE] = 1.0 if record[WEAKEST] < rules.search.degenerate else 0.0
    c = math.cos(heading)
    s = math.sin(heading)
    record[DIRECTION] = c * found.vectors[0, 0] - s * found.vectors[1, 0]
    record[DIRECTION + 1] = s * found.vectors[0, 0] + c * found.vectors[1, 0]
    record[DIRECTION + 2] = found.vectors[2, 0]
    record[USED] = 0.0
    forget_correction(at.correction)
    if fit < rules.least_fit:
        _doubt(rules.window, tracks.spread[i])
        return share
    record[USED] = 1.0
    for j in range(3):
        record[j] = tracks.pose[i, j]
        for k in range(3):
            at.prior.information[j, k] = found.kept[j, k] + found.information[j, k]
    if invert(at.prior.information, at.matrix) and invert(found.kept, at.spread):
        correct(i, tracks, found.pose, at.matrix, found.kept, at.spread, found.information, at.correction)
    for j in range(3):
        record[j] = tracks.pose[i, j] - record[j]
    record[2] = wrap(record[2])
    return share
