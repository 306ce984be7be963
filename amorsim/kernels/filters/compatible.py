"""Joint compatibility: the assignment of sightings to landmarks in which all fit together.

Source: J. Neira, J. D. Tardos, "Data association in stochastic mapping using the joint compatibility test", IEEE Trans.
Robotics and Automation 17 (2001).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel

__all__ = ["MOST_NODES", "Search", "pair_up", "search"]


MOST_NODES = 20000  # looked at before the best so far is taken: many alike landmarks would take for ever


class Search(NamedTuple):
    """Room to look for the best pairs of m sightings and L landmarks."""

    is_taken: Bools  # (L,)
    fits: Bools  # (m, L) whether a pair fits by itself
    slopes: Array  # (m, L, 2, 4)
    residuals: Array  # (m, L, 2)
    noise: Array  # (m, L, 3) its covariance 11, 12, 22
    gates: Array  # (m + 1,) the largest squared distance of so many pairs
    means: Array  # (m + 1, 4) how the pairs so far would move the state
    covariances: Array  # (m + 1, 4, 4)
    squares: Array  # (m + 1,)
    counts: Ints  # (m + 1,) pairs so far
    tries: Ints  # (m,) the next landmark to try; L for none, L + 1 when done
    chosen: Ints  # (m,)
    best: Ints  # (m,)


def search(slots: int, landmarks: int, gates: Array) -> Search:
    """Room for so many sightings and landmarks."""
    return Search(
        is_taken=np.zeros(landmarks, dtype=bool),
        fits=np.zeros((slots, landmarks), dtype=bool),
        slopes=np.zeros((slots, landmarks, 2, 4)),
        residuals=np.zeros((slots, landmarks, 2)),
        noise=np.zeros((slots, landmarks, 3)),
        gates=gates,
        means=np.zeros((slots + 1, 4)),
        covariances=np.zeros((slots + 1, 4, 4)),
        squares=np.zeros(slots + 1),
        counts=np.zeros(slots + 1, dtype=np.int64),
        tries=np.zeros(slots, dtype=np.int64),
        chosen=np.zeros(slots, dtype=np.int64),
        best=np.full(slots, -1, dtype=np.int64),
    )


@kernel
def _take(at: Search, slot: int, k: int) -> bool:
    """Add a pair to those before its slot; False if all together are not compatible.

    Squared distances of pairs add up, if each is compared with what is expected once those before it are known.
    """
    mean = at.means[slot + 1]
    p = at.covariances[slot + 1]
    mean[:] = at.means[slot]
    p[:] = at.covariances[slot]
    square = at.squares[slot]
    h = at.slopes[slot, k]
    r11, r12, r22 = at.noise[slot, k, 0], at.noise[slot, k, 1], at.noise[slot, k, 2]
    share = r12 / r11
    for n in range(2):
        residual = at.residuals[slot, k, n]
        variance = r11
        if n == 1:
            residual -= share * at.residuals[slot, k, 0]
            variance = r22 - share * r12
        spread = np.empty(4)
        slope = np.empty(4)
        for j in range(4):
            slope[j] = h[n, j] - (share * h[0, j] if n == 1 else 0.0)
        for j in range(4):
            spread[j] = p[j, 0] * slope[0] + p[j, 1] * slope[1] + p[j, 2] * slope[2] + p[j, 3] * slope[3]
            residual -= slope[j] * mean[j]
        for j in range(4):
            variance += slope[j] * spread[j]
        square += residual * residual / variance
        for j in range(4):
            gain = spread[j] / variance
            mean[j] += gain * residual
            for m in range(4):
                p[j, m] -= gain * spread[m]
    at.squares[slot + 1] = square
    at.counts[slot + 1] = at.counts[slot] + 1
    return bool(square <= at.gates[at.counts[slot + 1]])


@kernel
def pair_up(p: Array, at: Search) -> None:
    """Find the most pairs that fit jointly, the best of equally many, and write them to ``at.best`` (-1: none)."""
    slots, landmarks = at.fits.shape
    at.is_taken[:] = False
    at.means[0] = 0.0
    at.covariances[0] = p
    at.squares[0] = 0.0
    at.counts[0] = 0
    at.best[:] = -1
    most = 0
    least = np.inf
    slot = 0
    at.tries[0] = 0
    at.chosen[0] = -1
    nodes = 0
    while slot >= 0:
        nodes += 1
        if slot == slots or nodes > MOST_NODES:
            if at.counts[slot] > most or (at.counts[slot] == most and at.squares[slot] < least):
                most = at.counts[slot]
                least = at.squares[slot]
                at.best[:slot] = at.chosen[:slot]
                at.best[slot:] = -1
            if nodes > MOST_NODES:
                break
            slot -= 1
            continue
        if at.chosen[slot] >= 0:  # back from below
            at.is_taken[at.chosen[slot]] = False
            at.chosen[slot] = -1
        k = at.tries[slot]
        down = False
        # With all that is left it could not become better than the best.
        if at.counts[slot] + slots - slot >= most:
            while k < landmarks and not down:
                if at.fits[slot, k] and not at.is_taken[k] and _take(at, slot, k):
                    at.chosen[slot] = k
                    at.is_taken[k] = True
                    down = True
                k += 1
            if not down and k == landmarks and at.counts[slot] + slots - slot - 1 >= most:
                at.means[slot + 1] = at.means[slot]
                at.covariances[slot + 1] = at.covariances[slot]
                at.squares[slot + 1] = at.squares[slot]
                at.counts[slot + 1] = at.counts[slot]
                down = True
                k += 1
        if down:
            at.tries[slot] = k
            slot += 1
            if slot < slots:
                at.tries[slot] = 0
                at.chosen[slot] = -1
        else:
            slot -= 1
    at.is_taken[:] = False
