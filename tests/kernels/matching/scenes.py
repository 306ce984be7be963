"""Rooms, and scans of them as a laser of half a turn or a whole one would take them."""

import math

import numpy as np

import amorsim as am
from amorsim.kernels.matching import icp
from amorsim.kernels.matching.outlines import new_outline, outline

HALF = np.linspace(-math.pi / 2.0, math.pi / 2.0, 181)
WHOLE = np.arange(360) / 360.0 * 2.0 * math.pi - math.pi
REACH = 8.0


def room(width=6.0, height=4.0):
    """A room with a niche and a column, so that no two places look alike."""
    walls = [(0, 0, width, 0), (width, 0, width, height), (width, height, 0, height), (0, height, 0, 0)]
    walls += [(2.0, height, 2.0, height - 0.8), (2.0, height - 0.8, 3.1, height), (4.2, 0.9, 4.8, 1.3)]
    walls += [(4.8, 1.3, 4.6, 0.7), (4.6, 0.7, 4.2, 0.9)]
    return am.Map.from_segments(np.array(walls, dtype=float), resolution=0.001)


def corridor(length=60.0, width=2.0):
    return am.Map.from_segments(
        np.array([(0, 0, length, 0), (length, 0, length, width), (length, width, 0, width), (0, width, 0, 0)], float),
        resolution=0.001,
    )


def circle(radius=3.0, sides=720):
    angle = np.arange(sides + 1) / sides * 2.0 * math.pi
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    return am.Map.from_segments(np.stack((x[:-1], y[:-1], x[1:], y[1:]), axis=1), resolution=0.001)


def scan(world, pose, bearings=HALF, std=0.0, rng=None, reach=REACH):
    """Ranges (k,) from a pose, and their outline."""
    ranges = world.cast_rays(np.array([pose], dtype=float), bearings, reach)[0]
    if std:
        ranges = ranges + std * rng.normal(size=ranges.shape)
    return ranges, outline_of(ranges, bearings, reach)


def outline_of(ranges, bearings=HALF, reach=REACH, mount=(0.0, 0.0, 0.0)):
    out = new_outline(len(bearings))
    outline(ranges, np.cos(bearings), np.sin(bearings), reach, np.array(mount, dtype=float), out)
    return out


def off(found, wanted):
    """How far a pose is from another one: distance [m] and angle [rad]."""
    return math.hypot(*(found[:2] - wanted[:2])), abs(float(am.wrap_angle(np.array([found[2] - wanted[2]]))[0]))


def reference_of(found):
    """A scan's outline as what others are laid on."""
    out = icp.reference(len(found.points))
    icp.refer(found, out)
    return out
