"""Priors with long tails: what was known of a pose before a scan counts less where the scan contradicts it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import part
from amorsim.kernels.matching.symmetric import UNDETERMINED, directions, eigen, solve

__all__ = ["Prior", "Room", "keep", "no_prior", "room"]


class Prior(NamedTuple):
    """The prior: a pose and its information, with the tails of Student's t.

    Where a scan contradicts it, its covariance is widened along the way to the scan's own pose. Of the square s of the
    difference, by the sum of both covariances, (d + 3) / (d + s) is left, with d degrees of freedom. Source of that
    weight: K. Lange, R. Little, J. Taylor, "Robust statistical modeling using the t distribution" (1989).
    """

    pose: Array  # (3,)
    information: Array  # (3, 3)
    freedom: float  # degrees of freedom; inf for a normal distribution


class Room(NamedTuple):
    """Room for what `keep` computes."""

    sums: Array  # (3, 3)
    vectors: Array  # (3, 3)
    numbers: Array  # (4, 3)


def room() -> Room:
    """Room for one prior."""
    return Room(np.empty((3, 3)), np.empty((3, 3)), np.empty((4, 3)))


def no_prior(freedom: float = math.inf) -> Prior:
    """A prior without information."""
    return Prior(np.zeros(3), np.zeros((3, 3)), freedom)


@part
def keep(
    prior: Prior,
    information: Array,
    right: Array,
    off: tuple[float, float, float],
    arm: float,
    degenerate: float,
    at: Room,
    out: Array,
) -> None:
    """The information (3, 3) that a prior keeps: the less, the more a scan contradicts it.

    The scan's `information` (3, 3), and its pull `right` (3,), are those at a pose that is `off` from the prior's.
    Directions that the scan does not determine, with eigenvalues below `degenerate` times the largest, are no part of
    the way to the scan's own pose. Turns count as lengths at the distance `arm` [m].
    """
    for i in range(3):
        for j in range(3):
            out[i, j] = prior.information[i, j]
    if prior.freedom == math.inf:
        return
    values, step, way, pull = at.numbers[0], at.numbers[1], at.numbers[2], at.numbers[3]
    directions(information, arm, at.sums, values, at.vectors)
    for i in range(3):
        way[i] = 0.0
        for j in range(3):
            at.sums[i, j] = prior.information[i, j]
    for k in range(3):
        if not values[k] > degenerate * values[2]:
            continue
        along = at.vectors[0, k] * off[0] + at.vectors[1, k] * off[1] + at.vectors[2, k] * off[2] * arm
        at.vectors[2, k] /= arm
        for i in range(3):
            along += at.vectors[i, k] * right[i] / values[k]
        for i in range(3):
            way[i] += at.vectors[i, k] * along
            for j in range(3):
                scale = (arm * arm if i == 2 else 1.0) * (arm * arm if j == 2 else 1.0)
                at.sums[i, j] += values[k] * at.vectors[i, k] * at.vectors[j, k] * scale
    _times(prior.information, way, pull)
    eigen(at.sums, values, at.vectors)
    solve(values, at.vectors, pull, UNDETERMINED, step)
    far = 0.0  # square of the way, by the prior's covariance
    square = 0.0  # and by the sum of both
    for i in range(3):
        far += way[i] * pull[i]
        square += (way[i] - step[i]) * pull[i]
    if not square > 3.0:
        return
    wider = (square - 3.0) / ((prior.freedom + 3.0) * square)
    for i in range(3):
        for j in range(3):
            out[i, j] -= wider / (1.0 + wider * far) * pull[i] * pull[j]


@part
def _times(matrix: Array, vector: Array, out: Array) -> None:
    """The product of a matrix (3, 3) and a vector (3,)."""
    for i in range(3):
        out[i] = matrix[i, 0] * vector[0] + matrix[i, 1] * vector[1] + matrix[i, 2] * vector[2]
