"""Tracks: where robots and the keys that they are matched with are, and how sure both are, together.

A key is where its points show it to be: off from the robot's pose at that time by what its points are off together. All
scans that are matched with it share this error, and the match that placed it has most of it too. So the key's pose is
estimated along with the robot's, by its covariance with the motion from there. Sources: S. I. Roumeliotis,
J. W. Burdick, "Stochastic cloning: a generalized framework for processing relative state measurements" (2002);
A. I. Mourikis, S. I. Roumeliotis, "On the treatment of relative-pose measurements for mobile robot localization"
(2006).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel, part
from amorsim.kernels.kinematics.poses import displaced, wrap
from amorsim.kernels.matching.symmetric import invert

__all__ = [
    "Correction",
    "Tracks",
    "begin_key",
    "correct",
    "correction",
    "forget_correction",
    "relative",
    "swing",
    "total_covariances",
    "turn",
]


_SHARED = 0.75  # of what a scan's points are off together, in its match and as a key: decision 0072


class Tracks(NamedTuple):
    """The tracks of N rows: their estimated poses."""

    pose: Array  # (N, 3)
    spread: Array  # (N, 3, 3) covariance of the motion from the key, in the world
    key_pose: Array  # (N, 3)
    key_covariance: Array  # (N, 3, 3)
    cross: Array  # (N, 3, 3) covariance of the motion from the key (first index) and the key's pose
    link: Array  # (N, 4, 3) from the last key to this one, in the last one's frame: the pose, and its covariance
    last: Array  # (N, 3) the pose at the last match; nan before the first scan
    last_points: Array  # (N, k, 2) of the scan that was matched then


class Correction(NamedTuple):
    """What the last match of a track did, in the world; 0 where there was none, or it was refused."""

    off: Array  # (3,) by which it corrected the motion from the key
    covariance: Array  # (3, 3) of that motion before
    before: Array  # (3, 3) and its information
    taken: Array  # (3, 3) information on how far the match and the motion before were apart
    gain: Array  # (3, 3) of the key's pose by corrections of the motion, transposed
    match: Array  # (3, 3) information of the match alone
    own: Array  # (3, 3) covariance of the error of a new key's points
    shared: Array  # (3, 3) of that error and the match's
    room: Array  # (4, 3, 3)


def correction() -> Correction:
    """Room for a correction."""
    off, one, room = np.zeros(3), np.zeros((3, 3)), np.zeros((4, 3, 3))
    return Correction(off, one, one.copy(), one.copy(), one.copy(), one.copy(), one.copy(), one.copy(), room)


@part
def relative(pose: Array, other: Array, out: Array) -> None:
    """The displacement from a pose to another one, in the first one's frame."""
    c = math.cos(pose[2])
    s = math.sin(pose[2])
    x = other[0] - pose[0]
    y = other[1] - pose[1]
    out[0] = c * x + s * y
    out[1] = c * y - s * x
    out[2] = wrap(other[2] - pose[2])


@part
def turn(matrix: Array, angle: float, out: Array) -> None:
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


@part
def swing(covariance: Array, dx: float, dy: float, out: Array) -> None:
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


@part
def _add_product(a: Array, b: Array, sign: float, out: Array) -> None:
    """Add a product of two matrices (3, 3), times `sign`."""
    for j in range(3):
        for k in range(3):
            for n in range(3):
                out[j, k] += sign * a[j, n] * b[n, k]


@part
def _add_product_of_transposed(a: Array, b: Array, sign: float, out: Array) -> None:
    """Add the product of the transposed `a` and `b` (3, 3), times `sign`."""
    for j in range(3):
        for k in range(3):
            for n in range(3):
                out[j, k] += sign * a[n, j] * b[n, k]


@part
def _total_covariance(i: int, tracks: Tracks, out: Array) -> None:
    """The covariance (3, 3) of a row's pose: of its key's, of the motion from there, and what both have in common."""
    dx = tracks.pose[i, 0] - tracks.key_pose[i, 0]
    dy = tracks.pose[i, 1] - tracks.key_pose[i, 1]
    cross = tracks.cross[i]
    swing(tracks.key_covariance[i], dx, dy, out)
    for j in range(3):
        at_x = cross[j, 0] - dy * cross[j, 2]
        at_y = cross[j, 1] + dx * cross[j, 2]
        out[j, 0] += at_x
        out[0, j] += at_x
        out[j, 1] += at_y
        out[1, j] += at_y
        out[j, 2] += cross[j, 2]
        out[2, j] += cross[j, 2]
        for k in range(3):
            out[j, k] += tracks.spread[i, j, k]


@kernel
def total_covariances(tracks: Tracks, out: Array) -> None:
    """Covariances (N, 3, 3) of the poses."""
    for i in range(tracks.pose.shape[0]):
        _total_covariance(i, tracks, out[i])


@part
def forget_correction(at: Correction) -> None:
    """There was no match."""
    at.off[:] = 0.0
    at.covariance[:] = 0.0
    at.before[:] = 0.0
    at.taken[:] = 0.0
    at.gain[:] = 0.0
    at.match[:] = 0.0


@kernel
def correct(
    i: int,
    tracks: Tracks,
    found: Array,
    covariance: Array,
    kept: Array,
    kept_covariance: Array,
    match: Array,
    at: Correction,
) -> None:
    """Correct a row's pose, and that of its key, by a match.

    Parameters
    ----------
    i
        The row.
    tracks
        Its track.
    found, covariance
        (3,), (3, 3): the robot's pose in the key's frame, by match and wheels together.
    kept, kept_covariance
        (3, 3): information of the wheels alone in that frame, and its inverse.
    match
        (3, 3): information of the match alone.
    at
        Gets the correction.
    """
    heading = tracks.key_pose[i, 2]
    x, y, turned = displaced(tracks.key_pose[i, 0], tracks.key_pose[i, 1], heading, found[0], found[1], found[2])
    at.off[0] = x - tracks.pose[i, 0]
    at.off[1] = y - tracks.pose[i, 1]
    at.off[2] = wrap(turned - tracks.pose[i, 2])
    turn(match, heading, at.match)
    turn(kept, heading, at.before)
    turn(kept_covariance, heading, at.covariance)
    turn(covariance, heading, tracks.spread[i])
    cross = tracks.cross[i]
    key = tracks.key_covariance[i]
    half, lost = at.room[0], at.room[1]
    half[:] = 0.0
    lost[:] = 0.0
    _add_product(at.before, tracks.spread[i], 1.0, half)
    _add_product(half, at.before, 1.0, lost)
    at.gain[:] = 0.0
    _add_product(at.before, cross, 1.0, at.gain)
    _add_product_of_transposed(cross, at.gain, -1.0, key)
    cross[:] = 0.0
    _add_product(tracks.spread[i], at.gain, 1.0, cross)
    _add_product_of_transposed(at.gain, cross, 1.0, key)
    for j in range(3):
        for k in range(3):
            at.taken[j, k] = at.before[j, k] - lost[j, k]
            tracks.key_pose[i, j] += at.gain[k, j] * at.off[k]
    tracks.key_pose[i, 2] = wrap(tracks.key_pose[i, 2])
    x, y, turned = displaced(
        tracks.key_pose[i, 0], tracks.key_pose[i, 1], tracks.key_pose[i, 2], found[0], found[1], found[2]
    )
    tracks.pose[i, 0] = x
    tracks.pose[i, 1] = y
    tracks.pose[i, 2] = turned


@kernel
def begin_key(i: int, tracks: Tracks, own: Array, at: Correction, moved: Array) -> None:
    """Let a row's scan be its key from now on.

    Parameters
    ----------
    i
        The row.
    tracks
        Its track, which also gets the link from its key before to this one.
    own
        (3, 3): information on how far the scan's points are off together, in the robot's frame.
    at
        The correction by this scan's match.
    moved
        (3,): gets where the new key is in the frame of the one before.
    """
    key, spread = tracks.key_pose[i], tracks.spread[i]
    dx = tracks.pose[i, 0] - key[0]
    dy = tracks.pose[i, 1] - key[1]
    total, error, with_motion, with_key = at.room[0], at.room[1], at.room[2], at.room[3]
    # The error of the new key's points, and the match's. Twice the parallel sum of both, their harmonic mean, is at
    # most what both can have in common.
    turn(own, tracks.pose[i, 2], total)
    invert(total, at.own)
    for j in range(3):
        for k in range(3):
            total[j, k] += at.match[j, k]
    invert(total, at.shared)
    for j in range(3):
        for k in range(3):
            at.shared[j, k] *= 2.0 * _SHARED
            error[j, k] = at.own[j, k]
    # Given the match, and with the motion from the key before and with that key.
    total[:] = 0.0
    with_motion[:] = 0.0
    with_key[:] = 0.0
    _add_product(at.taken, at.shared, 1.0, total)
    _add_product_of_transposed(at.shared, total, -1.0, error)
    _add_product(at.covariance, total, -1.0, with_motion)
    _add_product_of_transposed(at.gain, with_motion, 1.0, with_key)
    link = tracks.link[i]
    for j in range(3):
        for k in range(3):
            total[j, k] = spread[j, k] + error[j, k] + with_motion[j, k] + with_motion[k, j]
    turn(total, -key[2], link[1:])
    # Where the match shows the points to be off from the robot's pose.
    for j in range(3):
        link[0, j] = tracks.pose[i, j]
        for k in range(3):
            for n in range(3):
                link[0, j] += at.shared[k, j] * at.before[k, n] * at.off[n]
    link[0, 2] = wrap(link[0, 2])
    relative(key, link[0], moved)
    _total_covariance(i, tracks, total)
    for k in range(3):
        with_motion[0, k] += with_key[0, k] - dy * with_key[2, k]
        with_motion[1, k] += with_key[1, k] + dx * with_key[2, k]
        with_motion[2, k] += with_key[2, k]
    for j in range(3):
        key[j] = link[0, j]
        link[0, j] = moved[j]
        for k in range(3):
            tracks.key_covariance[i, j, k] = total[j, k] + error[j, k] + with_motion[j, k] + with_motion[k, j]
            spread[j, k] = error[j, k]
            tracks.cross[i, j, k] = -error[j, k] - with_motion[k, j]
