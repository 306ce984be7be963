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
    "Keys",
    "Outlines",
    "Room",
    "Rules",
    "Tracks",
    "align_outline",
    "make_keys",
    "room",
    "total_covariances",
    "track",
]

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_FARTHEST = 20.0  # [m] from the robot that points of before are kept
_APART = 0.1  # [m] from a new point that older ones are kept
_THROUGH = 0.05  # [m] from a beam at which it passes through a point ...
_BEFORE = 0.3  # [m] ... that is so far before its end
_ASIDE = math.radians(10.0)  # that the second stage may turn farther than the window
_FARTHER = 3.0  # times the window, in which a scan is looked for that does not fit
_CLEARLY = 0.1  # how much better it must fit there
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

    points: Floats  # (N, k, 2)
    lines: Floats  # (N, k, 4)
    rays: Floats  # (N, k, 2)


class Keys(NamedTuple):
    """The keys of N rows; see `Reference`."""

    points: Floats  # (N, s, 2)
    lines: Floats  # (N, s, 4)
    order: npt.NDArray[np.int64]  # (N, s)
    along: Floats  # (N, s)
    seen: Floats  # (N, k, 2) points of the last scan in them
    mounts: Floats  # (N, 3) of the lasers


class Tracks(NamedTuple):
    """The tracks of N rows: their estimated poses."""

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
    least_fit: float  # below which a match is refused
    sure_fit: float  # below which a pose is looked for farther away
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
    free: icp.Prior  # nothing known
    found: Floats  # (3,)


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
        icp.no_prior(),
        np.empty(3),
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
def _draw(reference: icp.Reference, seen: Floats, mount: Floats, at: Room) -> None:
    """Draw the picture of a reference, and the free space that its last scan saw."""
    correlative.draw(reference.points, at.picture)
    correlative.clear(seen, mount[0], mount[1], at.picture)


@kernel
def align_outline(
    reference: icp.Reference, scan: Outline, window: correlative.Window, prior: icp.Prior, rules: Rules, at: Room
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
def _key(keys: Keys, i: int) -> icp.Reference:
    """The key of a row."""
    return icp.Reference(keys.points[i], keys.lines[i], keys.order[i], keys.along[i])


@part
def _is_superseded(x: float, y: float, scan: Outline) -> bool:
    """Whether an older point is where the new scan has one, or the new scan sees through it."""
    for j in range(scan.points.shape[0]):
        px = scan.points[j, 0]
        if math.isnan(px):
            continue
        py = scan.points[j, 1]
        dx = x - px
        dy = y - py
        if dx * dx + dy * dy < _APART * _APART:
            return True
        across = dx * scan.rays[j, 1] - dy * scan.rays[j, 0]
        along = dx * scan.rays[j, 0] + dy * scan.rays[j, 1]
        if -_THROUGH < across < _THROUGH and _BEFORE - math.sqrt(px * px + py * py) < along < -_BEFORE:
            return True
    return False


@part
def _copy(points: Floats, lines: Floats, j: int, key: icp.Reference, place: int) -> None:
    """Copy a point and its line to a place in a key."""
    for k in range(2):
        key.points[place, k] = points[j, k]
    for k in range(4):
        key.lines[place, k] = lines[j, k]


@kernel
def _extend(scan: Outline, key: icp.Reference, moved: Floats) -> None:
    """Add a scan to a key, whose frame becomes the scan's; `moved` (3,) is that frame in the key's.

    Points of before are kept, the oldest first, where the scan shows nothing. Where there is no room for all of them,
    the oldest are left out.
    """
    c = math.cos(moved[2])
    s = math.sin(moved[2])
    size = key.points.shape[0]
    count = 0
    for j in range(size):
        if math.isnan(key.points[j, 0]):
            break
        x, y = _turned(key.points[j, 0] - moved[0], key.points[j, 1] - moved[1], c, s)
        if x * x + y * y > _FARTHEST * _FARTHEST or _is_superseded(x, y, scan):
            continue
        key.points[count, 0] = x
        key.points[count, 1] = y
        u, v = _turned(key.lines[j, 0] - moved[0], key.lines[j, 1] - moved[1], c, s)
        key.lines[count, 0] = u
        key.lines[count, 1] = v
        key.lines[count, 2], key.lines[count, 3] = _turned(key.lines[j, 2], key.lines[j, 3], c, s)
        count += 1
    new = 0
    for j in range(scan.points.shape[0]):
        if not math.isnan(scan.points[j, 0]):
            new += 1
    surplus = max(0, count + new - size)
    count -= surplus
    for j in range(count):
        _copy(key.points, key.lines, j + surplus, key, j)
    for j in range(scan.points.shape[0]):
        if not math.isnan(scan.points[j, 0]):
            _copy(scan.points, scan.lines, j, key, count)
            count += 1
    for j in range(count, size):
        for k in range(2):
            key.points[j, k] = math.nan
        for k in range(4):
            key.lines[j, k] = math.nan
    icp.index(key)


@part
def _turned(x: float, y: float, c: float, s: float) -> tuple[float, float]:
    """A vector in a frame that is turned by the angle of cosine c and sine s."""
    return c * x + s * y, c * y - s * x


@kernel
def _make_key(i: int, scans: Outlines, keys: Keys, tracks: Tracks, at: Room) -> None:
    """Let a row's scan be its key from now on."""
    dx = tracks.pose[i, 0] - tracks.key_pose[i, 0]
    dy = tracks.pose[i, 1] - tracks.key_pose[i, 1]
    _relative(tracks.key_pose[i], tracks.pose[i], at.start)
    _swing(tracks.key_covariance[i], dx, dy, at.matrix)
    for j in range(3):
        tracks.key_pose[i, j] = tracks.pose[i, j]
        for k in range(3):
            tracks.key_covariance[i, j, k] = at.matrix[j, k] + tracks.spread[i, j, k]
    _extend(Outline(scans.points[i], scans.lines[i], scans.rays[i]), _key(keys, i), at.start)
    for j in range(keys.seen.shape[1]):
        for k in range(2):
            keys.seen[i, j, k] = scans.points[i, j, k]


@part
def _is_far(pose: Floats, other: Floats, distance: float, angle: float) -> bool:
    dx = pose[0] - other[0]
    dy = pose[1] - other[1]
    return bool(dx * dx + dy * dy >= distance * distance or abs(wrap(pose[2] - other[2])) >= angle)


@kernel
def track(
    scans: Outlines, fresh: Bools, keys: Keys, tracks: Tracks, rules: Rules, at: Room, records: Floats, out: Bools
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
def make_keys(scans: Outlines, is_new: Bools, keys: Keys, tracks: Tracks, at: Room) -> None:
    """Let the scans of rows `is_new` (N, 2) be their keys, and count their motion from there."""
    for i in range(is_new.shape[0]):
        if is_new[i, 0]:
            _make_key(i, scans, keys, tracks, at)
            tracks.spread[i] = 0.0


@kernel
def _look_farther(key: icp.Reference, scan: Outline, fit: float, rules: Rules, at: Room) -> float:
    """Look for a pose in a window several times as large, and take it if it fits clearly better; returns how well."""
    wide = correlative.Window(
        _FARTHER * rules.window.linear, min(_FARTHER * rules.window.angular, math.pi), rules.window.angular_step
    )
    farther = align_outline(key, scan, wide, at.free, rules, at)
    if farther > fit + _CLEARLY:
        return farther
    return align_outline(key, scan, rules.window, at.prior, rules, at)


@part
def _doubt(window: correlative.Window, spread: Floats) -> None:
    """Widen the covariance of a motion that no scan confirms: it may be off by half of the window."""
    for j in range(2):
        spread[j, j] += 0.25 * window.linear * window.linear
    spread[2, 2] += 0.25 * window.angular * window.angular


@kernel
def _match(i: int, scans: Outlines, keys: Keys, tracks: Tracks, rules: Rules, at: Room, record: Floats) -> float:
    """Match a row's scan with its key and correct its track; returns the share of points on the key."""
    scan = Outline(scans.points[i], scans.lines[i], scans.rays[i])
    key = _key(keys, i)
    heading = tracks.key_pose[i, 2]
    _relative(tracks.key_pose[i], tracks.pose[i], at.prior.pose)
    _turn(tracks.spread[i], -heading, at.matrix)
    for j in range(3):
        at.matrix[j, j] += _FLOOR * _FLOOR
        at.start[j] = at.prior.pose[j]
    invert(at.matrix, at.prior.information)
    _draw(key, keys.seen[i], keys.mounts[i], at)
    fit = align_outline(key, scan, rules.window, at.prior, rules, at)
    if fit < rules.sure_fit and rules.window.linear > 0.0:
        fit = _look_farther(key, scan, fit, rules, at)
    found = at.result
    share: float = found.quality[0]
    record[FIT] = fit
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
    if fit < rules.least_fit:
        _doubt(rules.window, tracks.spread[i])
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
