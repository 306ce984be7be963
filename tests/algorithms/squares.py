"""A slow and obvious twin of a robot that drives a square by its odometry: straight lines, arcs, turns on the spot."""

from __future__ import annotations

import cmath
import math

import numpy as np
import numpy.typing as npt


def end_point(ed: float, eb: float, *, side: float, track: float, turns: int) -> tuple[float, float]:
    """Where a robot really ends, from its start, that believes to have come round; `turns` is 1 to the left, or -1."""
    left, right = 2.0 / (ed + 1.0), 2.0 * ed / (ed + 1.0)  # of the wheels, as parts of their nominal size
    place, heading = 0j, 0.0
    for _ in range(4):
        place, heading = _roll(place, heading, side * left, side * right, track * eb)
        quarter = turns * math.pi / 4.0 * track
        place, heading = _roll(place, heading, -quarter * left, quarter * right, track * eb)
    return place.real, place.imag


def _roll(place: complex, heading: float, left: float, right: float, track: float) -> tuple[complex, float]:
    """An arc about the centre on the axle's line at (l + r) / (r - l) halves of the track; or a line."""
    turn = (right - left) / track
    ahead = cmath.exp(1j * heading)
    if turn == 0.0:
        return place + left * ahead, heading
    centre = place + 1j * ahead * 0.5 * track * (left + right) / (right - left)
    return centre + (place - centre) * cmath.exp(1j * turn), heading + turn


def ends(ed: float, eb: float, *, side: float = 4.0, track: float = 0.32) -> tuple[npt.NDArray, npt.NDArray]:
    """End points `(1, 2)` [m], clockwise and anticlockwise, of a robot without random errors."""
    clockwise, anticlockwise = (np.array([end_point(ed, eb, side=side, track=track, turns=turns)]) for turns in (-1, 1))
    return clockwise, anticlockwise
