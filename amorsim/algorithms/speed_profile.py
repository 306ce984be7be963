"""The fastest times along a path, under limits of speed, acceleration and turn."""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import ArrayLike

from amorsim.array_types import Array
from amorsim.core.arguments import is_real
from amorsim.core.errors import PlanError
from amorsim.kernels import elementary

__all__ = ["Pieces", "SpeedProfile", "pieces_of", "speed_profile"]


_SAME = 1e-4  # [rad] by which the middle of an arc may point off its chord
_LEAST = 1e-9  # [m] a shorter piece is none


@attrs.frozen(kw_only=True, eq=False)
class Pieces:
    """The pieces between the poses of a path: arcs, straight lines, and turns in place at the poses."""

    lengths: Array
    """(M - 1,) [m]; negative where it is driven backwards."""
    turns: Array
    """(M - 1,) [rad] along each."""
    in_place: Array
    """(M,) [rad] turned at each pose."""


def pieces_of(path: ArrayLike) -> Pieces:
    """The pieces of a path of points (M, 2) or poses (M, 3) [m, rad].

    Between two poses lies the arc that leads from one heading to the other, forwards or backwards, if there is one.
    Else, and between points, there is a straight line ahead, and what is missing is turned in place.

    Raises
    ------
    PlanError
        If the path is not of finite numbers, or has no point.
    """
    try:
        poses = np.asarray(path, np.float64)
    except (TypeError, ValueError, OverflowError):
        poses = np.empty(0)
    if poses.ndim != 2 or poses.shape[1] not in (2, 3) or len(poses) == 0 or not np.isfinite(poses).all():
        raise PlanError(f"the path has shape {poses.shape}; expected points (M, 2) or poses (M, 3), finite numbers")
    steps = np.diff(poses[:, :2], axis=0)
    chords, directions = np.hypot(steps[:, 0], steps[:, 1]), elementary.arctan2(steps[:, 1], steps[:, 0])
    lengths, turns = chords.copy(), np.zeros(len(chords))
    leaves, comes = directions.copy(), directions.copy()  # headings at the start and the end of each piece
    if poses.shape[1] == 3:
        headings = poses[:, 2]
        turned = _wrapped(np.diff(headings))
        half = 0.5 * turned
        off = _wrapped(headings[:-1] + half - directions)
        is_back = np.abs(off) > 0.5 * math.pi
        is_arc = np.abs(_wrapped(off - np.where(is_back, math.pi, 0.0))) < _SAME
        longer = np.where(np.abs(half) > 1e-9, half / np.where(np.abs(half) > 1e-9, np.sin(half), 1.0), 1.0)
        lengths = np.where(is_arc, np.where(is_back, -chords, chords) * longer, chords)
        turns = np.where(is_arc, turned, 0.0)
        leaves, comes = np.where(is_arc, headings[:-1], directions), np.where(is_arc, headings[1:], directions)
    is_none = chords < _LEAST
    lengths, turns = np.where(is_none, 0.0, lengths), np.where(is_none, 0.0, turns)
    in_place = np.zeros(len(poses))
    heading = float(poses[0, 2]) if poses.shape[1] == 3 else math.nan
    for i in range(len(poses)):
        if i < len(chords) and not is_none[i]:
            if not math.isnan(heading):
                in_place[i] = abs(math.remainder(leaves[i] - heading, 2.0 * math.pi))
            heading = float(comes[i])
        elif i == len(chords) and poses.shape[1] == 3:
            in_place[i] = abs(math.remainder(poses[i, 2] - heading, 2.0 * math.pi))
    return Pieces(lengths=lengths, turns=turns, in_place=np.where(in_place < _SAME, 0.0, in_place))


@attrs.frozen(kw_only=True, eq=False)
class SpeedProfile:
    """The times at which a robot reaches and leaves each pose of a path, and its speed there."""

    arrive: Array
    """(M,) [s]."""
    leave: Array
    """(M,) [s]; later than `arrive` where it turns in place."""
    speed: Array
    """(M,) [m/s] at each pose, 0 or more also backwards."""

    @property
    def duration(self) -> float:
        """The time [s] for all of the path."""
        return float(self.leave[-1])


def speed_profile(
    path: ArrayLike,
    *,
    speed: float,
    acceleration: float,
    deceleration: float | None = None,
    turn_rate: float = math.inf,
) -> SpeedProfile:
    """The fastest times along a path, from rest to rest.

    The robot drives each piece of the path (see `pieces_of`) no faster than `speed`, nor than lets it turn with
    `turn_rate`. It stops where it turns in place or changes direction.

    Parameters
    ----------
    path
        Points (M, 2) or poses (M, 3) [m, rad], such as `Plan.poses`.
    speed
        [m/s].
    acceleration, deceleration
        [m/s^2] along the path; the deceleration is the acceleration if not given.
    turn_rate
        [rad/s].

    Raises
    ------
    PlanError
        If the path is none, or a limit is not above 0.
    """
    braking = acceleration if deceleration is None else deceleration
    for name, limit in (("speed", speed), ("acceleration", acceleration), ("deceleration", braking)):
        if not (is_real(limit) and limit > 0.0):
            raise PlanError(f"{name} is {limit!r}; expected a finite number above 0")
    is_free = isinstance(turn_rate, float) and turn_rate == math.inf
    if not (is_free or (is_real(turn_rate) and turn_rate > 0.0)):
        raise PlanError(f"turn_rate is {turn_rate!r}; expected a number above 0")
    pieces = pieces_of(path)
    lengths = np.abs(pieces.lengths)
    bends = np.abs(pieces.turns) / np.where(lengths > 0.0, lengths, 1.0)
    limits = np.full(len(lengths), float(speed))
    limits[bends > 0.0] = np.minimum(speed, turn_rate / bends[bends > 0.0])
    caps = _caps(pieces, limits)
    for i in range(len(lengths)):
        caps[i + 1] = min(caps[i + 1], math.sqrt(caps[i] ** 2 + 2.0 * acceleration * lengths[i]))
    for i in range(len(lengths) - 1, -1, -1):
        caps[i] = min(caps[i], math.sqrt(caps[i + 1] ** 2 + 2.0 * braking * lengths[i]))
    arrive, leave = np.zeros(len(caps)), np.zeros(len(caps))
    for i in range(len(caps)):
        if i > 0:
            ends = float(caps[i - 1]), float(caps[i])
            arrive[i] = leave[i - 1] + _time(float(lengths[i - 1]), *ends, float(limits[i - 1]), acceleration, braking)
        leave[i] = arrive[i] + pieces.in_place[i] / turn_rate
    return SpeedProfile(arrive=arrive, leave=leave, speed=caps)


def _caps(pieces: Pieces, limits: Array) -> Array:
    """The top speed (M,) at each pose by the adjacent pieces alone."""
    caps = np.zeros(len(limits) + 1)
    if len(limits) > 1:
        caps[1:-1] = np.minimum(limits[:-1], limits[1:])
        goes_back = np.sign(pieces.lengths)
        # Past pieces of no length, the direction is that of the last one before.
        for i in range(1, len(goes_back)):
            if goes_back[i] == 0.0:
                goes_back[i] = goes_back[i - 1]
        caps[1:-1][goes_back[:-1] * goes_back[1:] < 0.0] = 0.0
        caps[pieces.in_place > 0.0] = 0.0
    return caps


def _time(length: float, first: float, last: float, limit: float, acceleration: float, braking: float) -> float:
    """The least time [s] for a straight piece between two speeds."""
    if length == 0.0:
        return 0.0
    # It speeds up to a peak, and brakes; in between it may go at the limit.
    square = (2.0 * acceleration * braking * length + braking * first**2 + acceleration * last**2) / (
        acceleration + braking
    )
    peak = min(math.sqrt(square), limit)
    driven = (peak**2 - first**2) / (2.0 * acceleration) + (peak**2 - last**2) / (2.0 * braking)
    return (peak - first) / acceleration + (peak - last) / braking + max(length - driven, 0.0) / peak


def _wrapped(angles: Array) -> Array:
    wrapped: Array = (angles + math.pi) % (2.0 * math.pi) - math.pi
    return wrapped
