"""Absolute and relative errors of trajectories in the plane, their association in time, and their alignment.

The terms are those of evo (https://github.com/MichaelGrupp/evo), and so are the numbers for trajectories in the plane.
Poses are rows (x [m], y [m], heading [rad]), `(T, 3)`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.core.arguments import numbers

__all__ = [
    "Transform",
    "absolute_errors",
    "associate",
    "first_pose_transform",
    "interpolated",
    "nearest",
    "pairs_by_distance",
    "pairs_by_steps",
    "pairs_by_time",
    "path_lengths",
    "relative_errors",
    "umeyama",
]


class Transform(NamedTuple):
    """A rotation by `angle` [rad], a scale and then a shift `x`, `y` [m]; never a reflection."""

    x: float = 0.0
    y: float = 0.0
    angle: float = 0.0
    scale: float = 1.0

    def __str__(self) -> str:
        scaled = "" if self.scale == 1.0 else f", scale {self.scale:.6g}"
        return f"turn {math.degrees(self.angle):.6g} degrees, shift ({self.x:.6g}, {self.y:.6g}) m{scaled}"

    def apply(self, poses: Array) -> Array:
        """The poses `(T, 3)` transformed; headings turn with them."""
        cos, sin = self.scale * math.cos(self.angle), self.scale * math.sin(self.angle)
        x, y, heading = poses[:, 0], poses[:, 1], poses[:, 2]
        return np.stack((cos * x - sin * y + self.x, sin * x + cos * y + self.y, heading + self.angle), axis=1)


def umeyama(points: Array, onto: Array, *, with_scale: bool = False) -> Transform:
    """The transform of `points` `(T, 2)` that fits `onto` `(T, 2)` best, by least squares (Umeyama 1991).

    In the plane the best rotation has a closed form, and is one whatever the points: mirrored points do not make it a
    reflection.

    Raises
    ------
    ValueError
        If there are fewer than two points, or all are in one place: any rotation would fit them.
    """
    points = numbers(points, "points", ("T", 2))
    onto = numbers(onto, "onto", (len(points), 2))
    if len(points) < 2:
        raise ValueError(f"expected two poses at least, for one can be turned in any way, got {len(points)}")
    centre, target = points.mean(axis=0), onto.mean(axis=0)
    a, b = points - centre, onto - target
    dot = float(np.sum(a * b))
    cross = float(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    spread = float(np.sum(a * a))
    # What rounding leaves of points that are all in one place.
    least = (1e-15 * (1.0 + float(np.abs(points).max()))) ** 2 * len(points)
    if spread <= least or float(np.sum(b * b)) <= least or math.hypot(dot, cross) == 0.0:
        raise ValueError("expected poses in two places at least, got all in one: they can be turned in any way")
    angle = math.atan2(cross, dot)
    scale = math.hypot(dot, cross) / spread if with_scale else 1.0
    cos, sin = scale * math.cos(angle), scale * math.sin(angle)
    return Transform(
        float(target[0] - (cos * centre[0] - sin * centre[1])),
        float(target[1] - (sin * centre[0] + cos * centre[1])),
        angle,
        scale,
    )


def first_pose_transform(poses: Array, onto: Array) -> Transform:
    """The transform that moves the first of `poses` onto the first of `onto`.

    Raises
    ------
    ValueError
        If there is none.
    """
    if not len(poses):
        raise ValueError("expected one pose at least, got none")
    (x, y, heading), (to_x, to_y, to_heading) = poses[0].tolist(), onto[0].tolist()
    angle = math.remainder(to_heading - heading, 2.0 * math.pi)
    cos, sin = math.cos(angle), math.sin(angle)
    return Transform(to_x - (cos * x - sin * y), to_y - (sin * x + cos * y), angle)


def associate(times: Array, others: Array, most: float) -> tuple[Ints, Ints]:
    """Pairs of two increasing series of times [s]: for each time of the shorter one the nearest of the other.

    Pairs that are more than `most` [s] apart are left out. Of two that are equally near, the earlier is taken.
    """
    if len(others) < len(times):
        second, first = associate(others, times, most)
        return first, second
    return nearest(times, others, most)


def nearest(times: Array, others: Array, most: float) -> tuple[Ints, Ints]:
    """For each of an increasing series of times [s], the nearest of another: places of both, as `associate`."""
    if not len(times) or not len(others):
        return np.empty(0, np.int64), np.empty(0, np.int64)
    after = np.minimum(np.searchsorted(others, times, side="right"), len(others) - 1)
    before = np.maximum(after - 1, 0)
    to_after, to_before = others[after] - times, np.where(after > 0, times - others[before], np.inf)
    found = np.where((to_after <= most) & (to_after < to_before), after, before)
    there = np.where(found == after, to_after, to_before)
    near = np.flatnonzero(np.abs(there) <= most)
    return near, found[near]


def interpolated(times: Array, poses: Array, at: Array) -> Array:
    """Poses `(len(at), 3)` at times within `times`, on straight lines between poses; headings turn the short way."""
    heading = np.unwrap(poses[:, 2])
    return np.stack([np.interp(at, times, column) for column in (poses[:, 0], poses[:, 1], heading)], axis=1)


def path_lengths(poses: Array) -> Array:
    """Distance [m] travelled up to each pose `(T,)`."""
    steps = np.diff(poses[:, :2], axis=0)
    return np.concatenate(([0.0], np.cumsum(np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2))))


def absolute_errors(reference: Array, estimate: Array) -> tuple[Array, Array]:
    """Distance [m] and difference of heading [rad], both >= 0, of each estimated pose and its reference."""
    apart = estimate - reference
    return np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2), _turn(apart[:, 2])


def relative_errors(reference: Array, estimate: Array, pairs: tuple[Ints, Ints]) -> tuple[Array, Array]:
    """The same of the motions between pairs of poses: how far the estimated motion ends from the true one."""
    first, last = pairs
    true, believed = (_motion(poses[first], poses[last]) for poses in (reference, estimate))
    apart = believed - true
    return np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2), _turn(apart[:, 2])


def pairs_by_steps(count: int, delta: int, *, every: bool = True) -> tuple[Ints, Ints]:
    """Places of poses `delta` steps apart: from every pose, or one after another."""
    first = np.arange(0, count - delta, 1 if every else delta)
    return first, first + delta


def pairs_by_time(times: Array, delta: float, *, every: bool = True) -> tuple[Ints, Ints]:
    """Places of poses that are `delta` [s] apart, rounded to whole steps: from every pose, or one after another.

    A step is the median one. Where a pose has none at the end of its stretch, to half a step, it begins no stretch.
    """
    different = np.unique(times)
    if len(different) < 2:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    step = float(np.median(np.diff(different)))
    ends = times + max(1, round(delta / step)) * step
    after = np.minimum(np.searchsorted(times, ends), len(times) - 1)
    before = np.maximum(after - 1, 0)
    last = np.where(np.abs(times[after] - ends) <= np.abs(times[before] - ends), after, before)
    first = np.flatnonzero(np.abs(times[last] - ends) <= (0.5 + 1e-6) * step)
    last = last[first]
    if every:
        return first, last
    taken, free = [], 0  # the first pose that the next stretch may begin at
    for place, end in enumerate(last.tolist()):
        if first[place] >= free:
            taken.append(place)
            free = end
    return first[taken], last[taken]


def pairs_by_distance(poses: Array, delta: float, *, every: bool = True, tolerance: float = 0.1) -> tuple[Ints, Ints]:
    """Places of poses `delta` [m] of path apart.

    Parameters
    ----------
    every
        From every pose to the one nearest to `delta` from it, unless it misses that by more than `tolerance` of it; or
        one after another, each the first that is at least so far.
    """
    lengths = path_lengths(poses)
    if not every:
        places, begun = [0], 0.0
        for place in range(1, len(lengths)):
            begun += float(lengths[place] - lengths[place - 1])
            if begun >= delta:
                places.append(place)
                begun = 0.0
        return np.array(places[:-1], dtype=np.int64), np.array(places[1:], dtype=np.int64)
    firsts, lasts = [], []
    for first in range(len(lengths) - 1):
        ahead = lengths[first + 1 :] - lengths[first]
        nearest = int(np.argmin(np.abs(ahead - delta)))
        if abs(ahead[nearest] - delta) <= delta * tolerance:
            firsts.append(first)
            lasts.append(first + 1 + nearest)
    return np.array(firsts, dtype=np.int64), np.array(lasts, dtype=np.int64)


def _motion(before: Array, after: Array) -> Array:
    """The motions (x, y, turn) from poses to others, in the frames of the first."""
    step = after - before
    cos, sin = np.cos(before[:, 2]), np.sin(before[:, 2])
    return np.stack((cos * step[:, 0] + sin * step[:, 1], cos * step[:, 1] - sin * step[:, 0], step[:, 2]), axis=1)


def _turn(angles: Array) -> Array:
    """The size of turns [rad], at most pi."""
    return np.abs(np.remainder(angles + np.pi, 2.0 * np.pi) - np.pi)
