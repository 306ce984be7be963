"""A particle filter of poses over rows: Monte Carlo localization.

Source: S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics" (2005), 8.3 (augmented Monte Carlo localization).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array, Bools, Ints
from amorsim.kernels.compile import kernel
from amorsim.kernels.filters.beams import Field, Mixture, Place, Scan, weigh_by_beams, weigh_by_field
from amorsim.kernels.filters.gaussians import root
from amorsim.kernels.filters.headings import fill_turns
from amorsim.kernels.filters.modes import Bins, Modes, bin_of, bins, find_modes, put
from amorsim.kernels.filters.resampling import average, effective_size, kld_size, recovery_probability, resample
from amorsim.kernels.grid.grid import Grid
from amorsim.kernels.kinematics.poses import wrap
from amorsim.kernels.random.normals import normals
from amorsim.kernels.random.philox import pairs

__all__ = [
    "Cloud",
    "Free",
    "Motion",
    "Numbers",
    "Sensing",
    "Sizes",
    "update",
]

# A component's parameter over rows, (N, 1) float64; declared as the number that it is for one row.
Column = Any


class Cloud(NamedTuple):
    """The particles of N rows."""

    particles: Array  # (N, P, 3) x, y [m], heading [rad]; only the first `counts` of a row
    weights: Array  # (N, P), which add up to 1
    counts: Ints  # (N,)
    averages: Array  # (N, 2) of the mean weight: slow and fast; nan at first
    # (N, 3): effective sample size, probability of a particle at random, and 1 if no particle was possible.
    figures: Array


class Motion(NamedTuple):
    """The motion of the particles: a displacement in each one's own frame, or where they begin."""

    begins: Bools  # (N,) whether particles are drawn about `pose`, or moved
    lost: Bools  # (N,) whether they begin anywhere
    pose: Array  # (N, 3) in the world
    covariance: Array  # (N, 3, 3) of it
    moved: Array  # (N, 3)
    doubt: Array  # (N, 3, 3), the covariance of `moved`


class Free(NamedTuple):
    """Where a robot may be: squares of a map."""

    middles: Array  # (M, 2) [m] in the world
    side: float  # [m]


class Sizes(NamedTuple):
    """The numbers of particles, and the sizes of the bins that determine them."""

    least: int
    error: float  # of Kullback and Leibler's distance
    quantile: float  # of the normal distribution
    side: float  # [m]
    turns: int  # bins of heading in a full turn
    share: float  # resample at an effective sample size below this share of the particles


class Sensing(NamedTuple):
    """The readings and the field that weigh the particles."""

    scan: Scan
    mixture: Mixture
    tempering: Column  # exponent of the likelihood
    by_beams: bool
    cubed: bool
    field: Field
    grid: Grid
    place: Place


class Numbers(NamedTuple):
    """The random numbers, and the gains of the averages for recovery."""

    keys: npt.NDArray[np.uint64]
    counter: npt.NDArray[np.uint32]
    block: int
    slow: Column
    fast: Column


class Work(NamedTuple):
    """Room for one row."""

    first: Array
    second: Array
    power: Array
    logarithms: Array  # (P,)
    spare: Array  # (P, 3)
    turns: Array  # (2, P) sines and cosines of the headings
    table: Bins


@kernel
def _room(particles: int) -> Any:
    """Room for so many particles."""
    pairs_ = (4 * particles + 3) // 2
    return Work(
        np.empty(pairs_),
        np.empty(pairs_),
        np.empty(pairs_),
        np.empty(particles),
        np.empty((particles, 3)),
        np.empty((2, particles)),
        bins(particles),
    )


@kernel
def _somewhere(free: Free, place: Place, first: Array, second: Array, k: int, out: Array) -> None:
    """A pose anywhere free, from four uniform numbers: the k-th of them and those after it."""
    m = min(int(first[k] * free.middles.shape[0]), free.middles.shape[0] - 1)
    across = (second[k] - 0.5) * free.side
    up = (first[k + 1] - 0.5) * free.side
    out[0] = free.middles[m, 0] + place.cos_yaw * across - place.sin_yaw * up
    out[1] = free.middles[m, 1] + place.sin_yaw * across + place.cos_yaw * up
    out[2] = (2.0 * second[k + 1] - 1.0) * math.pi


@kernel
def _uniforms(numbers: Numbers, row: int, block: int, count: int, at: Work) -> None:
    """The next `count` pairs of uniform numbers."""
    pairs(numbers.keys[row], numbers.counter, row, block, at.first[:count], at.second[:count])


@kernel
def _normals(numbers: Numbers, row: int, block: int, count: int, at: Work) -> None:
    """The next `count` pairs of standard normal numbers."""
    first = at.first[:count]
    second = at.second[:count]
    pairs(numbers.keys[row], numbers.counter, row, block, first, second)
    normals(first, second, first.view(np.int64), at.power[:count])


@kernel
def _number(at: Work, k: int) -> float:
    return float(at.first[k // 2] if k % 2 == 0 else at.second[k // 2])


@kernel
def _begin(
    row: int, cloud: Cloud, motion: Motion, sizes: Sizes, free: Free, place: Place, numbers: Numbers, at: Work
) -> None:
    """Draw the first particles: around a pose, as many as the number of their bins requires, or anywhere."""
    particles = cloud.particles[row]
    capacity = particles.shape[0]
    if motion.lost[row]:
        _uniforms(numbers, row, numbers.block, 2 * capacity, at)
        for p in range(capacity):
            _somewhere(free, place, at.first, at.second, 2 * p, particles[p])
        cloud.counts[row] = capacity
    else:
        lower = np.empty((3, 3))
        root(motion.covariance[row], lower)
        _normals(numbers, row, numbers.block, (3 * capacity + 1) // 2, at)
        at.table.keys[:] = -1
        found = 0
        n = 0
        while n < capacity and (n < sizes.least or n < kld_size(found, sizes.error, sizes.quantile)):
            e0 = _number(at, 3 * n)
            e1 = _number(at, 3 * n + 1)
            e2 = _number(at, 3 * n + 2)
            x = motion.pose[row, 0] + lower[0, 0] * e0
            y = motion.pose[row, 1] + lower[1, 0] * e0 + lower[1, 1] * e1
            h = wrap(motion.pose[row, 2] + lower[2, 0] * e0 + lower[2, 1] * e1 + lower[2, 2] * e2)
            particles[n, 0] = x
            particles[n, 1] = y
            particles[n, 2] = h
            _, found = put(at.table, bin_of(x, y, h, sizes.side, sizes.turns), found)
            n += 1
        cloud.counts[row] = n
    n = cloud.counts[row]
    cloud.weights[row, :n] = 1.0 / n
    cloud.weights[row, n:] = 0.0
    particles[n:] = 0.0


@kernel
def _move(row: int, cloud: Cloud, motion: Motion, numbers: Numbers, at: Work) -> None:
    """Move the particles, each by a draw of its own."""
    n = cloud.counts[row]
    particles = cloud.particles[row]
    lower = np.empty((3, 3))
    root(motion.doubt[row], lower)
    _normals(numbers, row, numbers.block, (3 * n + 1) // 2, at)
    fill_turns(particles[:n], at.turns)
    for p in range(n):
        e0 = _number(at, 3 * p)
        e1 = _number(at, 3 * p + 1)
        e2 = _number(at, 3 * p + 2)
        ahead = motion.moved[row, 0] + lower[0, 0] * e0
        left = motion.moved[row, 1] + lower[1, 0] * e0 + lower[1, 1] * e1
        turn = motion.moved[row, 2] + lower[2, 0] * e0 + lower[2, 1] * e1 + lower[2, 2] * e2
        s = at.turns[0, p]
        c = at.turns[1, p]
        particles[p, 0] += c * ahead - s * left
        particles[p, 1] += s * ahead + c * left
        particles[p, 2] = wrap(particles[p, 2] + turn)


@kernel
def _weigh(row: int, cloud: Cloud, sensing: Sensing, numbers: Numbers, at: Work) -> None:
    """Multiply the weights by the likelihoods, and update the averages with the mean weight."""
    n = cloud.counts[row]
    particles = cloud.particles[row, :n]
    weights = cloud.weights[row, :n]
    logs = at.logarithms[:n]
    if sensing.by_beams:
        beams = weigh_by_beams(
            row, particles, sensing.scan, sensing.mixture, sensing.grid, sensing.place, sensing.cubed, logs
        )
    else:
        beams = weigh_by_field(
            row, particles, at.turns, sensing.scan, sensing.field, sensing.place, sensing.cubed, logs
        )
    if beams == 0:
        return
    if numbers.fast[row, 0] > 0.0:
        # The mean weight: of a whole scan's likelihood nearly nothing but the best particle would count, so a beam's.
        share = 1.0 if sensing.cubed else 1.0 / beams
        mean = 0.0
        for p in range(n):
            mean += weights[p] * math.exp(share * logs[p])
        average(mean, cloud.averages[row], numbers.slow[row, 0], numbers.fast[row, 0])
    highest = -math.inf
    weight, logarithm = 0.0, -math.inf  # the last weight: after resampling all are alike
    for p in range(n):
        if weights[p] != weight:
            weight = weights[p]
            logarithm = math.log(weight)
        logs[p] = logarithm + sensing.tempering[row, 0] * logs[p] if weight > 0.0 else -math.inf
        highest = max(highest, logs[p])
    if not (-math.inf < highest < math.inf):
        # From no particle could this be seen: all stay, as likely as each other.
        cloud.figures[row, 2] = 1.0
        weights[:] = 1.0 / n
        return
    total = 0.0
    for p in range(n):
        weights[p] = math.exp(logs[p] - highest)
        total += weights[p]
    for p in range(n):
        weights[p] /= total


@kernel
def _choose(
    row: int, cloud: Cloud, sizes: Sizes, free: Free, place: Place, numbers: Numbers, block: int, found: int, at: Work
) -> None:
    """Resample where the weights are too uneven, or some particles are to be drawn at random."""
    n = cloud.counts[row]
    weights = cloud.weights[row, :n]
    particles = cloud.particles[row]
    chance = cloud.figures[row, 1]
    effective = effective_size(weights)
    cloud.figures[row, 0] = effective
    if effective >= sizes.share * n and chance == 0.0:
        return
    capacity = particles.shape[0]
    _uniforms(numbers, row, block, 1, at)
    offset, rounding = at.first[0], at.second[0]
    # Which bins as many particles as there is room for would be in: that says how many are needed.
    picks = np.empty(capacity, dtype=np.int64)
    resample(weights, offset, picks)
    table = at.table
    bins = 0
    for b in range(found):
        table.mark[b] = 0
    for m in range(capacity):
        b = table.of[picks[m]]
        if table.mark[b] == 0:
            table.mark[b] = 1
            bins += 1
    wanted = max(float(sizes.least), kld_size(bins, sizes.error, sizes.quantile))
    count = capacity if wanted > capacity else int(wanted)
    strays = int(chance * count + rounding)
    kept = count - min(strays, count)
    if kept < capacity:
        resample(weights, offset, picks[:kept])
    for m in range(kept):
        for k in range(3):
            at.spare[m, k] = particles[picks[m], k]
    if strays > 0:
        _uniforms(numbers, row, block + 1, 2 * (count - kept), at)
        for m in range(count - kept):
            _somewhere(free, place, at.first, at.second, 2 * m, at.spare[kept + m])
    particles[:count] = at.spare[:count]
    particles[count:] = 0.0
    cloud.counts[row] = count
    cloud.weights[row, :count] = 1.0 / count
    cloud.weights[row, count:] = 0.0


@kernel
def update(
    rows: Ints,
    cloud: Cloud,
    motion: Motion,
    is_seen: Bools,
    sensing: Sensing,
    sizes: Sizes,
    free: Free,
    numbers: Numbers,
    modes: Modes,
) -> None:
    """Move the particles of some rows, weigh them by what is seen, find their modes, and resample them.

    A row needs nothing of another one, so they may be in any number and order. `is_seen` (N,) says whose scan is new.
    """
    capacity = cloud.particles.shape[1]
    at = _room(capacity)
    for r in range(rows.shape[0]):
        row = rows[r]
        cloud.figures[row, 2] = 0.0
        if motion.begins[row]:
            _begin(row, cloud, motion, sizes, free, sensing.place, numbers, at)
        else:
            _move(row, cloud, motion, numbers, at)
        n = cloud.counts[row]
        particles = cloud.particles[row, :n]
        fill_turns(particles, at.turns)
        if is_seen[row]:
            _weigh(row, cloud, sensing, numbers, at)
        found = find_modes(particles, at.turns, cloud.weights[row, :n], sizes.side, sizes.turns, at.table, row, modes)
        cloud.figures[row, 1] = recovery_probability(cloud.averages[row]) if numbers.fast[row, 0] > 0.0 else 0.0
        _choose(row, cloud, sizes, free, sensing.place, numbers, numbers.block + 2 * capacity, found, at)
