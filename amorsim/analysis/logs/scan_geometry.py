"""The beams of the scans in a log, and a laser that has them."""

from __future__ import annotations

import math
from typing import NamedTuple

import attrs

from amorsim.sensors.laser import Laser

__all__ = ["ScanGeometry", "laser_with"]

_TURN = 2.0 * math.pi
_LESS = 1e-6  # [rad] by which a field of view is less than a turn if both of its ends look the same way


class ScanGeometry(NamedTuple):
    """The beams of a scan."""

    beams: int
    span: float
    """[rad] from the first beam to the last."""
    range_max: float | None
    """[m], if the scan tells."""


def laser_with(geometry: ScanGeometry, laser: Laser) -> Laser:
    """The laser with the beams, the field of view and the range of a scan."""
    beams, span, range_max = geometry
    fov = span
    if beams > 1:
        step = span / (beams - 1)
        # All around: the beam after the last one would be the first.
        fov = _TURN if abs(span + step - _TURN) < 0.5 * step else min(span, _TURN - _LESS)
    if range_max is None or not laser.range_min < range_max < math.inf:
        range_max = laser.range_max
    return attrs.evolve(laser, beams=beams, fov=fov or laser.fov, range_max=range_max)
