"""Poses in the plane as rows (x, y, heading): composing, moving along a twist.

Kernels and not NumPy expressions, because NumPy's sine may give other last bits for another memory layout, and
results must not depend on how many rows there are.
"""

from __future__ import annotations

import math

import numpy as np

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel

__all__ = [
    "arc",
    "compose",
    "directions",
    "displaced",
    "exponential",
    "logarithm",
    "mean_twists",
    "relative",
    "wrap",
    "wrap_all",
]


_SMALL = 1e-3  # [rad] below this the series' first left-out term, a**6/5040, is under 1e-21
_TURN = 2.0 * math.pi


@kernel
def wrap(angle: float) -> float:
    """The same direction in [-pi, pi]; angles already there keep their bits."""
    if -math.pi <= angle <= math.pi:
        return angle
    return angle - _TURN * math.floor((angle + math.pi) / _TURN)


@kernel
def wrap_all(angles: Array, out: Array) -> None:
    """The same directions in [-pi, pi] for angles (Q,) [rad], also for numbers beyond those of `wrap`."""
    for i in range(angles.shape[0]):
        if -math.pi <= angles[i] <= math.pi:
            out[i] = angles[i]
        else:
            out[i] = angles[i] - _TURN * np.floor((angles[i] + math.pi) / _TURN)


@kernel
def displaced(x: float, y: float, heading: float, ahead: float, left: float, turn: float) -> tuple[float, float, float]:
    """The pose (x, y, heading) after a displacement given in its own frame; the heading wrapped."""
    c = math.cos(heading)
    s = math.sin(heading)
    return x + (c * ahead - s * left), y + (s * ahead + c * left), wrap(heading + turn)


@kernel
def arc(forward: float, left: float, turn: float, fraction: float) -> tuple[float, float, float]:
    """The displacement by a fraction of the constant twist (forward, left, turn), as in `exponential`."""
    forward = forward * fraction
    left = left * fraction
    a = turn * fraction
    if abs(a) < _SMALL:
        square = a * a
        along = 1.0 - square / 6.0 * (1.0 - square / 20.0)
        across = a / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0))
    else:
        half = math.sin(0.5 * a)
        along = math.sin(a) / a
        across = 2.0 * half * half / a  # (1 - cos a) / a without the cancellation
    return forward * along - left * across, forward * across + left * along, a


@kernel
def compose(poses: Array, displacements: Array, out: Array) -> None:
    """Poses `(N, 3)` after displacements `(N, 3)` that are given in each pose's own frame; headings wrapped."""
    for i in range(poses.shape[0]):
        out[i, 0], out[i, 1], out[i, 2] = displaced(
            poses[i, 0], poses[i, 1], poses[i, 2], displacements[i, 0], displacements[i, 1], displacements[i, 2]
        )


@kernel
def exponential(twists: Array, fraction: Array, out: Array) -> None:
    """Displacements `(N, 3)` by a fraction `(N, 1)` of constant twists (forward, left, turn) `(N, 3)`.

    The exponential map of the plane's rigid motions: an arc of a circle, or a line where nothing turns.
    """
    for i in range(twists.shape[0]):
        out[i, 0], out[i, 1], out[i, 2] = arc(twists[i, 0], twists[i, 1], twists[i, 2], fraction[i, 0])


@kernel
def twist_of(x: float, y: float, turn: float) -> tuple[float, float]:
    """The constant twist (forward, left) over a unit of time that leads to a displacement, as in `logarithm`."""
    half = 0.5 * turn
    if abs(turn) < _SMALL:
        along = 1.0 - half * half / 3.0 * (1.0 + half * half / 15.0)
    elif abs(math.sin(half)) < 1e-12:
        along = 1.0
    else:
        along = half * math.cos(half) / math.sin(half)
    return along * x + half * y, along * y - half * x


@kernel
def logarithm(displacements: Array, out: Array) -> None:
    """The constant twists `(N, 3)` over a unit of time that make the displacements `(N, 3)`; `exponential` undone.

    The turn is taken as it stands, so a displacement of more than half a turn keeps its sense; at a whole turn, where
    no twist moves the body elsewhere, the translation stays as it is.
    """
    for i in range(displacements.shape[0]):
        out[i, 0], out[i, 1] = twist_of(displacements[i, 0], displacements[i, 1], displacements[i, 2])
        out[i, 2] = displacements[i, 2]


@kernel
def mean_twists(twists: Array, fraction: Array, dt: float, out: Array) -> bool:
    """Mean velocities `(N, 3)` over a step of bodies that followed a fraction `(N,)` of their twists `(N, 3)`.

    The logarithm of the exponential, over the time. Returns whether any went less than the whole way.
    """
    is_short = False
    for i in range(twists.shape[0]):
        x, y, turn = arc(twists[i, 0], twists[i, 1], twists[i, 2], fraction[i])
        forward, left = twist_of(x, y, turn)
        out[i, 0] = forward / dt
        out[i, 1] = left / dt
        out[i, 2] = turn / dt
        is_short = is_short or fraction[i] < 1.0
    return is_short


@kernel
def relative(poses: Array, others: Array, out: Array) -> None:
    """The displacements `(N, 3)` that lead from `poses` to `others`, in each pose's own frame; `compose` undone."""
    for i in range(poses.shape[0]):
        c = math.cos(poses[i, 2])
        s = math.sin(poses[i, 2])
        x = others[i, 0] - poses[i, 0]
        y = others[i, 1] - poses[i, 1]
        out[i, 0] = c * x + s * y
        out[i, 1] = c * y - s * x
        out[i, 2] = wrap(others[i, 2] - poses[i, 2])


@kernel
def directions(angles: Array, cos_out: Array, sin_out: Array) -> None:
    """Cosines and sines of angles [rad] (N, k)."""
    for i in range(angles.shape[0]):
        for j in range(angles.shape[1]):
            cos_out[i, j] = math.cos(angles[i, j])
            sin_out[i, j] = math.sin(angles[i, j])
