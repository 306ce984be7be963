"""The state of a row of a Kalman filter, and updates of it by one number or by two.

An update of two numbers takes them one after the other, which is exact once their noise is independent: a correlated
pair is decorrelated first. So no matrix is inverted, and a row depends on nothing but itself. Sequential updates:
Y. Bar-Shalom, X. R. Li, T. Kirubarajan, "Estimation with Applications to Tracking and Navigation" (2001), 5.2 and 8.3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from amorsim.kernels.compile import part
from amorsim.kernels.filters.points import Work
from amorsim.kernels.kinematics.poses import wrap

__all__ = ["MATCH", "NIS", "RECORD", "USED", "Gaussians", "along", "spread_of", "squared_of", "take", "take_pair"]

Floats = npt.NDArray[np.float64]

# What is kept of an update: two innovations, their covariance (11, 12, 22), and these.
NIS = 5  # the innovation's square in units of its covariance
USED = 6  # 1 if it was used, 0 if the gate refused it
MATCH = 7  # the landmark, by its place among those that the robot knows
RECORD = 8


class Gaussians(NamedTuple):
    """The states of N rows."""

    mean: Floats  # (N, 4): x, y [m], heading [rad], bias of the gyro [rad/s]
    covariance: Floats  # (N, 4, 4)


@part
def spread_of(p: Floats, slope: Floats, out: Floats) -> None:
    """The covariance of the state with a number of this `slope`, into `out` (4,)."""
    for j in range(4):
        out[j] = p[j, 0] * slope[0] + p[j, 1] * slope[1] + p[j, 2] * slope[2] + p[j, 3] * slope[3]


@part
def along(a: Floats, b: Floats) -> float:
    """The product of two vectors (4,)."""
    return float(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3])


@part
def take(mean: Floats, p: Floats, spread: Floats, residual: float, variance: float) -> None:
    """Update by one number, with the `variance` of its residual and its covariance with the state (`spread`)."""
    for j in range(4):
        gain = spread[j] / variance
        mean[j] += gain * residual
        for k in range(j, 4):
            p[j, k] -= gain * spread[k]
            p[k, j] = p[j, k]
    mean[2] = wrap(mean[2])


@part
def squared_of(p: Floats, at: Work, r11: float, r12: float, r22: float, record: Floats) -> float:
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
def take_pair(mean: Floats, p: Floats, at: Work, r11: float, r12: float, r22: float) -> None:
    """Update by two numbers, one after the other, both linearised at the mean before."""
    r11 += at.extra[0]
    r12 += at.extra[1]
    r22 += at.extra[2]
    # The second less its part that the first tells: its noise is independent of the first one's.
    share = r12 / r11
    residual = at.residual[1] - share * at.residual[0]
    for j in range(4):
        at.slopes[1, j] -= share * at.slopes[0, j]
    variance = along(at.slopes[0], at.spreads[0]) + r11
    residual -= along(at.slopes[1], at.spreads[0]) * at.residual[0] / variance
    take(mean, p, at.spreads[0], at.residual[0], variance)
    spread_of(p, at.slopes[1], at.spreads[1])
    take(mean, p, at.spreads[1], residual, along(at.slopes[1], at.spreads[1]) + r22 - share * r12)
