"""UMBmark: the systematic errors of a differential drive, from the end points of squares driven both ways round.

J. Borenstein and L. Feng, "Measurement and correction of systematic odometry errors in mobile robots", IEEE Trans.
Robotics and Automation 12(6), 1996. A robot drives a square by its odometry, several times each way round. An end point
is the absolute displacement from start to end less the odometric one (x [m], y [m]), in a frame whose x axis is the
first side; clockwise squares lie to its right.

Two figures come of it: Ed, the ratio of the right wheel's diameter to the left one's, and Eb, the ratio of the actual
track to the nominal one. A common scale of both wheels does not show in squares, for these close whatever their size:
the mean diameter is taken as given.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.algorithms.intervals import Interval, welch_half_width
from amorsim.algorithms.least_squares import gauss_newton
from amorsim.array_types import Array

__all__ = [
    "ExactFit",
    "Figures",
    "PublishedFigures",
    "WheelGeometry",
    "exact_fit",
    "published_figures",
    "systematic_error",
]


class WheelGeometry(NamedTuple):
    """Radii of the wheels and the track [m] of a differential drive."""

    radius_left: float
    radius_right: float
    track: float

    def corrected(self, ed: float, eb: float) -> WheelGeometry:
        """The geometry whose ratio of right to left is `ed` times this one's, and whose track `eb` times; same mean."""
        ratio = ed * self.radius_right / self.radius_left
        both = self.radius_left + self.radius_right
        return WheelGeometry(both / (1.0 + ratio), both * ratio / (1.0 + ratio), eb * self.track)


class Figures(NamedTuple):
    """Error of a turn alpha and of a side beta [rad], and the ratios Ed and Eb that follow from them."""

    alpha: float
    beta: float
    ed: float
    eb: float


@attrs.frozen(kw_only=True)
class PublishedFigures:
    """The figures as published: from the x coordinates, from the y coordinates, and from the mean of both."""

    x: Figures
    y: Figures
    mean: Figures


def published_figures(clockwise: Array, anticlockwise: Array, side: float, track: float) -> PublishedFigures:
    """The figures of Borenstein and Feng from end points `(n, 2)` [m] of squares of a side [m].

    First order in the errors: the x form and the y form are biased in opposite directions, with Ed = 1.005 and
    Eb = 1.02 by a tenth of what Ed deviates from 1, and by a quarter to a third of what Eb does; their mean by
    a twentieth at most. `track` is the nominal one [m].
    """
    cw_x, cw_y = np.mean(clockwise, axis=0).tolist()
    ccw_x, ccw_y = np.mean(anticlockwise, axis=0).tolist()
    alpha = ((cw_x + ccw_x) / (-4.0 * side), (cw_y - ccw_y) / (-4.0 * side))
    beta = ((cw_x - ccw_x) / (-4.0 * side), (cw_y + ccw_y) / (-4.0 * side))
    return PublishedFigures(
        x=_figures(alpha[0], beta[0], side, track),
        y=_figures(alpha[1], beta[1], side, track),
        mean=_figures(0.5 * (alpha[0] + alpha[1]), 0.5 * (beta[0] + beta[1]), side, track),
    )


def _figures(alpha: float, beta: float, side: float, track: float) -> Figures:
    # Half the track over the radius of the arc that a side is: 0 where it is straight, where the radius has no value.
    bend = 0.5 * track * math.sin(0.5 * beta) / (0.5 * side)
    quarter = 0.5 * math.pi
    return Figures(alpha, beta, (1.0 + bend) / (1.0 - bend), quarter / (quarter - alpha))


def systematic_error(clockwise: Array, anticlockwise: Array) -> float:
    """E_max,syst [m]: the distance of the farther one of the two clusters' centres from the origin."""
    return max(math.hypot(*np.mean(points, axis=0).tolist()) for points in (clockwise, anticlockwise))


@attrs.frozen(kw_only=True)
class ExactFit:
    """Ed and Eb with their intervals, and the scatter of single end points about the fit [m] (root mean square)."""

    ed: Interval
    eb: Interval
    scatter: float


def exact_fit(
    predict: Callable[[Array], Array], clockwise: Array, anticlockwise: Array, *, confidence: float = 0.95
) -> ExactFit:
    """Ed and Eb, and nothing else, fitted to all end points without approximation.

    An interval comes from how the runs of each direction scatter about their own mean, so all it asks
    is that runs are independent and nearly normal. What a run adds to the estimate's error is a sum over its two
    coordinates; each direction has a variance of its own of these sums, and the two are put together with the degrees
    of freedom of Welch and Satterthwaite.

    Parameters
    ----------
    predict
        The end points `(c, n, 2)` [m] that candidates `(c, 2)` (Ed, Eb) would have had, of all clockwise runs and then
        of all anticlockwise ones.
    clockwise, anticlockwise
        The end points `(n, 2)` [m] of the runs, two each way at least.

    Raises
    ------
    ValueError
        If there are too few runs, or the fit does not settle.
    """
    counts = (len(clockwise), len(anticlockwise))
    if min(counts) < 2:
        raise ValueError(f"expected two runs each way at least, got {counts[0]} and {counts[1]}")
    ends = np.concatenate((clockwise, anticlockwise))
    fit = gauss_newton(lambda tried: (predict(tried) - ends).reshape(len(tried), -1), np.ones(2))
    # The error of the estimate is the sum over all runs of their shares (n, 2): it is linear in the residuals.
    gain = np.linalg.pinv(fit.jacobian).reshape(2, -1, 2)
    shares = np.sum(gain * fit.residuals.reshape(1, -1, 2), axis=2).T
    variances = [
        count * np.var(part, axis=0, ddof=1) for part, count in zip(_split(shares, counts), counts, strict=True)
    ]
    halves = [welch_half_width(parts, counts, confidence) for parts in zip(*variances, strict=True)]
    found = [
        Interval(value, value - half, value + half) for value, half in zip(fit.values.tolist(), halves, strict=True)
    ]
    parts = _split(fit.residuals.reshape(-1, 2), counts)
    squares = sum(float(np.sum((part - np.mean(part, axis=0)) ** 2)) for part in parts)
    return ExactFit(ed=found[0], eb=found[1], scatter=math.sqrt(squares / (sum(counts) - 2)))


def _split(rows: Array, counts: tuple[int, int]) -> tuple[Array, Array]:
    return rows[: counts[0]], rows[counts[0] :]
