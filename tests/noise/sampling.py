"""Noise elements over many rows, taken through samples as the engine does, and the bounds of what comes of them.

A statistic is allowed `SIGMAS` of its own standard deviations, so that with another seed a sound element would fail one
comparison in two million.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.contracts import Context, Draws, RobotModel
from amorsim.core.draws import stream_key
from amorsim.core.rows import stack, take
from amorsim.core.shapes import Shape
from tests import building

ROWS, K = 25_000, 4
N = ROWS * K
SIGMAS = 5.0


class Samples:
    """One element over rows, or one each; `name` is what its draws are keyed by."""

    def __init__(self, *elements, rows=None, k=K, name="element", drive=None):
        count = rows or len(elements)
        which = np.arange(count) % len(elements)
        self.counter = np.zeros((count, 3), dtype=np.uint32)
        self.counter[:, 0] = np.arange(count)
        self.draws = Draws(np.full(count, stream_key(11, "rover", name), dtype=np.uint64), self.counter)
        self.noise = take(stack(elements), which)
        drive = building.drive() if drive is None else drive
        robot = RobotModel(
            rows=count,
            dt=0.1,
            drive=take(stack([drive]), 0 * which),
            shape=Shape.circle(0.2),
            sensors={},
            channels=drive.channels,
        )
        context = Context(rows=count, dt=0.1, robot=robot, pose=np.zeros((count, 3)), size=k)
        self.state = dict(self.noise.start(context))
        self.shape = (count, k)

    def take(self, values=0.0, elapsed=0.1, side=None):
        """The next sample: `values` corrupted; no time has passed at the first."""
        values = np.array(np.broadcast_to(np.asarray(values, dtype=float), self.shape))
        passed = np.where(self.counter[:, 2:] == 0, 0.0, elapsed)
        side = {name: np.full(self.shape, value) for name, value in (side or {}).items()}
        out = self.noise.corrupt(values, side, passed, self.state, self.draws)
        self.counter[:, 2] += 1
        self.draws.rewind()
        return out

    def series(self, count, values=0.0, elapsed=0.1):
        """So many samples `(count, N, k)`, one after the other."""
        return np.array([self.take(values, elapsed) for _ in range(count)])

    def ground(self, travel, elapsed):
        """A step's travel over the ground: time passes in the first one too."""
        values = np.array(np.broadcast_to(np.asarray(travel, dtype=float), self.shape))
        out = self.noise.corrupt(values, {}, np.full((self.shape[0], 1), elapsed), self.state, self.draws)
        self.counter[:, 2] += 1
        self.draws.rewind()
        return out


def assert_moments(sample, std, mean=0.0, kurtosis=3.0):
    """Mean and variance of independent numbers of a distribution with this kurtosis."""
    n = sample.size
    assert abs(sample.mean() - mean) < SIGMAS * std / math.sqrt(n)
    # A sample variance has the relative variance (kurtosis - 1) / n, but for terms of 1 / n^2.
    found = ((sample - mean) ** 2).mean()
    assert abs(found / std**2 - 1.0) < SIGMAS * math.sqrt((kurtosis - 1.0) / n)


def assert_share(hits, probability):
    """How often something independent happens."""
    bound = SIGMAS * math.sqrt(probability * (1.0 - probability) / hits.size)
    assert abs(hits.mean() - probability) < bound


def assert_distributed(sample, cumulative):
    """The largest gap between the sample's distribution and `cumulative`.

    By the inequality of Dvoretzky, Kiefer and Wolfowitz (with Massart's constant) it exceeds g with a probability of
    at most 2 exp(-2 n g^2); here one in a million.
    """
    ordered = np.sort(sample, axis=None)
    n = ordered.size
    expected = cumulative(ordered)
    steps = np.arange(n + 1) / n
    gap = max(np.abs(steps[1:] - expected).max(), np.abs(steps[:-1] - expected).max())
    assert gap < math.sqrt(math.log(2e6) / (2.0 * n))


def assert_uncorrelated(*samples):
    """No correlation between any two of several samples of n numbers each: its standard deviation is 1 / sqrt(n)."""
    table = np.corrcoef(np.array([np.ravel(sample) for sample in samples]))
    off = table[~np.eye(len(samples), dtype=bool)]
    assert np.abs(off).max() < SIGMAS / math.sqrt(np.size(samples[0]))


def allan_variance(series, m):
    """Allan variance over clusters of m samples, of the first two clusters of independent series `(count, N, k)`."""
    first, second = series[:m].mean(axis=0), series[m : 2 * m].mean(axis=0)
    return 0.5 * ((second - first) ** 2).mean()


def assert_allan(series, m, expected):
    """The Allan variance of independent normal series, each of which gives one squared difference."""
    assert abs(allan_variance(series, m) / expected - 1.0) < SIGMAS * math.sqrt(2.0 / series[0].size)
