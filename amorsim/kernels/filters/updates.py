"""The state of a row of a Kalman filter, and updates of it by one number or by two.

A landmark tells nothing of a turn of the robot around it. A filter that takes slopes at a new mean each time loses
that: the doubt about such a turn shrinks, and the filter becomes too sure. An update `by_arc` moves the mean by a
shift with a turn, along an arc (the exponential map of SE(2)), and refers the covariance to where that leads. Then
the turn around the landmark stays as doubtful as it was. Sources: A. Barrau, S. Bonnabel, "The invariant extended
Kalman filter as a stable observer", IEEE Trans. Automatic Control 62 (2017); A. W. Long, K. C. Wolfe, M. J. Mashner,
G. S. Chirikjian, "The banana distribution is Gaussian", Robotics: Science and Systems VIII (2012).

An update of two numbers takes them one after the other, which is exact once their noise is independent: a correlated
pair is decorrelated first. So no matrix is inverted, and a row depends on nothing but itself. Sequential updates:
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), 5.2 and 8.3.
"""

from __future__ import annotations

from typing import NamedTuple

from amorsim.array_types import Array
from amorsim.kernels.compile import part
from amorsim.kernels.filters.unscented import Work
from amorsim.kernels.kinematics.poses import arc, wrap

__all__ = [
    "MATCH",
    "NIS",
    "RECORD",
    "USED",
    "Gaussians",
    "along",
    "bend",
    "spread_of",
    "squared_of",
    "swing",
    "take",
    "take_pair",
]


# What is kept of an update: two innovations, their covariance (11, 12, 22), and these.
NIS = 5  # the innovation's square in units of its covariance
USED = 6  # 1 if it was used, 0 if the gate refused it
MATCH = 7  # the landmark, by its place among those that the robot knows
RECORD = 8


class Gaussians(NamedTuple):
    """The states of N rows."""

    mean: Array  # (N, 4): x, y [m], heading [rad], bias of the gyro [rad/s]
    covariance: Array  # (N, 4, 4)


@part
def spread_of(p: Array, slope: Array, out: Array) -> None:
    """The covariance of the state with a number of this `slope`, into `out` (4,)."""
    for j in range(4):
        out[j] = p[j, 0] * slope[0] + p[j, 1] * slope[1] + p[j, 2] * slope[2] + p[j, 3] * slope[3]


@part
def along(a: Array, b: Array) -> float:
    """The product of two vectors (4,)."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3])


@part
def swing(p: Array, x: float, y: float) -> None:
    """Refer a covariance to a mean that lies (x, y) further on, which a turn of all the plane has moved more."""
    xh = p[0, 2]
    yh = p[1, 2]
    hh = p[2, 2]
    hb = p[2, 3]
    p[0, 0] -= y * (2.0 * xh - y * hh)
    p[0, 1] += x * xh - y * yh - x * y * hh
    p[1, 1] += x * (2.0 * yh + x * hh)
    p[0, 2] -= y * hh
    p[1, 2] += x * hh
    p[0, 3] -= y * hb
    p[1, 3] += x * hb
    for j in range(4):
        for k in range(j):
            p[j, k] = p[k, j]


@part
def bend(p: Array, out: Array) -> None:
    """Write the second moments xx, xy, yy of how far arcs lead aside into `out` (3,).

    A shift u along with a turn t leads aside by t u / 2.
    """
    out[0] = 0.25 * (p[2, 2] * p[1, 1] + 2.0 * p[1, 2] * p[1, 2])
    out[1] = -0.25 * (p[2, 2] * p[0, 1] + 2.0 * p[0, 2] * p[1, 2])
    out[2] = 0.25 * (p[2, 2] * p[0, 0] + 2.0 * p[0, 2] * p[0, 2])


@part
def _reduce(p: Array, spread: Array, variance: float) -> None:
    """Take off what a number of this `variance` tells, which has the covariance `spread` with the state."""
    for j in range(4):
        gain = spread[j] / variance
        for k in range(j, 4):
            p[j, k] -= gain * spread[k]
            p[k, j] = p[j, k]


@part
def _move(mean: Array, p: Array, x: float, y: float, turn: float, bias: float, by_arc: bool) -> None:
    """Correct the mean by a shift with a turn, one after the other or along an arc."""
    if by_arc:
        x, y, _ = arc(x, y, turn, 1.0)
        swing(p, x, y)
    mean[0] += x
    mean[1] += y
    mean[2] = wrap(mean[2] + turn)
    mean[3] += bias


@part
def take(mean: Array, p: Array, spread: Array, residual: float, variance: float) -> None:
    """Update by one number, with the `variance` of its residual and its covariance with the state (`spread`)."""
    gain = residual / variance
    x, y, turn, bias = gain * spread[0], gain * spread[1], gain * spread[2], gain * spread[3]
    _reduce(p, spread, variance)
    _move(mean, p, x, y, turn, bias, False)


@part
def squared_of(p: Array, at: Work, r11: float, r12: float, r22: float, record: Array) -> float:
    """Compare two numbers with what is expected (`at`), into `record`; returns the normalised innovation squared."""
    spread_of(p, at.slopes[0], at.spreads[0])
    spread_of(p, at.slopes[1], at.spreads[1])
    s11 = along(at.slopes[0], at.spreads[0]) + (r11 + at.extra[0])
    s12 = along(at.slopes[1], at.spreads[0]) + (r12 + at.extra[1])
    s22 = along(at.slopes[1], at.spreads[1]) + (r22 + at.extra[2])
    first = at.residual[0]
    rest = at.residual[1] - s12 / s11 * first
    squared = first * first / s11 + rest * rest / (s22 - s12 / s11 * s12)
    record[0] = first
    record[1] = at.residual[1]
    record[2] = s11
    record[3] = s12
    record[4] = s22
    record[NIS] = squared
    return float(squared)


@part
def take_pair(mean: Array, p: Array, at: Work, r11: float, r12: float, r22: float, by_arc: bool) -> None:
    """Update by two numbers, one after the other, both linearised at the mean before; along an arc or not."""
    r11 += at.extra[0]
    r12 += at.extra[1]
    r22 += at.extra[2]
    # The second less its part that the first tells: its noise is independent of the first one's.
    share = r12 / r11
    residual = at.residual[1] - share * at.residual[0]
    for j in range(4):
        at.slopes[1, j] -= share * at.slopes[0, j]
    one, two = at.spreads
    variance = along(at.slopes[0], one) + r11
    gain = at.residual[0] / variance
    residual -= along(at.slopes[1], one) * gain
    x, y, turn, bias = gain * one[0], gain * one[1], gain * one[2], gain * one[3]
    _reduce(p, one, variance)
    spread_of(p, at.slopes[1], two)
    variance = along(at.slopes[1], two) + r22 - share * r12
    gain = residual / variance
    _reduce(p, two, variance)
    _move(mean, p, x + gain * two[0], y + gain * two[1], turn + gain * two[2], bias + gain * two[3], by_arc)
