"""The shortest curves of cars: of Dubins, forwards only, and of Reeds and Shepp, forwards and backwards."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import attrs
import numpy as np

from amorsim.algorithms.cells import place_of
from amorsim.array_types import Array
from amorsim.core.arguments import is_real
from amorsim.core.errors import PlanError
from amorsim.kernels.search.curves import MOST_WORDS, dubins_words, reeds_shepp_words, trace_word

__all__ = ["Curve", "all_curves", "dubins", "reeds_shepp"]

Words = Callable[[float, float, float, Array], int]
Pose = tuple[float, float, float]

_MOST_POSES = 10_000_000


@attrs.frozen(kw_only=True, eq=False)
class Curve:
    """A curve of at most five pieces, each straight or an arc of one radius."""

    start: Pose
    """x, y [m] and heading [rad]."""
    radius: float
    """Of the arcs [m]."""
    word: Array
    """(5, 2) the pieces: 1 to the left, -1 to the right or 0 straight on, and the length over the radius; a negative
    length is driven backwards, and a piece of length 0 is none."""

    @property
    def length(self) -> float:
        """[m], of all pieces, whatever their direction."""
        return math.fsum(np.abs(self.word[:, 1]).tolist()) * self.radius

    def poses(self, spacing: float) -> Array:
        """Poses (M, 3) along the curve, at most `spacing` [m] apart, with its ends and those of its pieces.

        Raises
        ------
        PlanError
            If the spacing is not above 0, or there would be more than ten million poses.
        """
        if not spacing > 0.0 or self.length / spacing > _MOST_POSES:
            raise PlanError(
                f"spacing is {spacing!r} m, of a curve of {self.length:.6g} m; expected more than 0, and no more than "
                f"{_MOST_POSES} poses"
            )
        out = np.empty((math.ceil(self.length / spacing) + 2 * len(self.word) + 1, 3))
        return out[: trace_word(*self.start, self.word, self.radius, spacing, out)]


def all_curves(words: Words, start: Pose, goal: Pose, radius: float) -> list[Curve]:
    """The curves between two poses that a kernel of words gives, the shortest first."""
    x, y, heading = start
    c, s = math.cos(heading), math.sin(heading)
    dx, dy = goal[0] - x, goal[1] - y
    found = np.zeros((MOST_WORDS, 5, 2))
    count = words(
        (c * dx + s * dy) / radius, (c * dy - s * dx) / radius, math.remainder(goal[2] - heading, 2.0 * math.pi), found
    )
    curves = [Curve(start=start, radius=radius, word=word) for word in found[:count]]
    return sorted(curves, key=lambda curve: curve.length)


def dubins(start: Sequence[float], goal: Sequence[float], radius: float) -> Curve:
    """The shortest curve between two poses (x, y, heading) [m, rad] of a car that drives forwards only.

    Its turning radius is `radius` [m] at least. After L. E. Dubins, 1957.

    Raises
    ------
    PlanError
        If a pose is not three finite numbers, or the radius is not a positive one.
    """
    return _shortest(dubins_words, start, goal, radius)


def reeds_shepp(start: Sequence[float], goal: Sequence[float], radius: float) -> Curve:
    """The shortest curve between two poses (x, y, heading) [m, rad] of a car that drives forwards and backwards.

    Its turning radius is `radius` [m] at least. After J. A. Reeds and L. A. Shepp, 1990. Raises as `dubins`.
    """
    return _shortest(reeds_shepp_words, start, goal, radius)


def _shortest(words: Words, start: Sequence[float], goal: Sequence[float], radius: float) -> Curve:
    if not (is_real(radius) and radius > 0.0):
        raise PlanError(f"radius is {radius!r}; expected a positive number of metres")
    return all_curves(words, _pose(start, "start"), _pose(goal, "goal"), radius)[0]


def _pose(given: Sequence[float], what: str) -> Pose:
    x, y, heading = place_of(given, what)
    if heading is None:
        raise PlanError(f"{what} is {given!r}; expected (x, y, heading), for a curve ends in a heading")
    return x, y, heading
