"""Bumpers around a footprint, and which of their segments are pressed."""

from __future__ import annotations

import functools
import itertools
import math
import types
from collections.abc import Callable, Mapping
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Aim, Draws, Drive, Mount, Sensor, SensorBinding, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.shapes import Shape

__all__ = ["Bumper", "Sector"]

Point = tuple[float, float]
_NOTHING: Mapping[str, Array] = types.MappingProxyType({})
# Outlines replace arcs by chords. A chord deviates from its arc by at most 1 - cos(pi / 64) of the radius.
_SAGITTA = 1.0 - math.cos(math.pi / 64.0)
_LEAST = 1e-9  # [m] pieces of an outline shorter than this are left out


@attrs.frozen(kw_only=True)
class Sector:
    """The part of an outline between two directions from the mount, anticlockwise from the first to the second."""

    start: float = parameter(unit="rad", ge=-2.0 * math.pi, le=2.0 * math.pi, help="where it begins, from the heading")
    end: float = parameter(unit="rad", ge=-2.0 * math.pi, le=2.0 * math.pi, help="where it ends, anticlockwise")

    def __attrs_post_init__(self) -> None:
        if not self.start < self.end <= self.start + 2.0 * math.pi + 1e-12:
            raise ParameterError(
                "end", f"expected more than start {self.start!r} and at most a turn more, got {self.end!r}"
            )


_FRONT = (Sector(start=0.0, end=math.pi / 2.0), Sector(start=-math.pi / 2.0, end=0.0))


@attrs.frozen(kw_only=True)
class Bumper(Sensor):
    """Which segments of a bumper around the footprint press on a wall or another body: 1 for those, 0 for others.

    A segment is the part of the robot's outline within a sector of directions, seen from the mount. The mount should
    lie inside the outline. A segment is pressed while a wall or body is closer to it than ``reach``. Contact is found
    from the current poses of all bodies, not from collision events.

    Parameters
    ----------
    segments
        The sectors; the reading has one value for each. By default front left and front right.
    reach
        Distance that the bumper stands out from the footprint [m].
    """

    unit: ClassVar[str] = "contact"

    segments: tuple[Sector, ...] = parameter(_FRONT, static=True, help="the directions, each with a value of its own")
    reach: float = parameter(0.005, unit="m", gt=0, le=10, help="how far it stands out from the footprint")

    def __attrs_post_init__(self) -> None:
        if not self.segments:
            raise ParameterError("segments", "expected one segment at least, got none")

    def size(self, drive: Drive) -> int:
        """One value for each segment."""
        return len(self.segments)

    def sense(self, view: View, aim: Aim, state: State, draws: Draws) -> tuple[Array, Mapping[str, Array]]:
        """1 where a segment is pressed, else 0 `(N, k)`."""
        zones, which, there = self._laid_out(view)
        return self._pressed(view, zones, which, there), _NOTHING

    def bind(self, at: SensorBinding) -> Callable[[], None]:
        """Lay out the zones of all rows once."""
        view = at.view
        zones, which, there = self._laid_out(view)
        return lambda: np.copyto(at.out, self._pressed(view, zones, which, there))

    def _pressed(self, view: View, zones: tuple[Shape, ...], which: Ints, there: Bools) -> Array:
        if not zones:
            return np.zeros(which.shape)
        return (view.touches(zones, which) & there).astype(np.float64)

    def _laid_out(self, view: View) -> tuple[tuple[Shape, ...], Ints, Bools]:
        """The zones of all rows, the zone of each segment `(N, k)`, and whether a row has that segment `(N, k)`."""
        reach = np.broadcast_to(self.reach, (view.rows, 1))
        mounts, mine = np.unique(np.concatenate((view.mount, reach), axis=1), axis=0, return_inverse=True)
        zones: list[Shape] = []
        which = np.zeros((len(mounts), len(self.segments)), dtype=np.int64)
        there = np.zeros(which.shape, dtype=np.bool_)
        for i, mount in enumerate(mounts.tolist()):
            for j, zone in enumerate(_zones(view.shape, tuple(mount[:3]), self.segments, mount[3])):
                if zone is not None:  # a sector in which there is no outline is never pressed
                    which[i, j], there[i, j] = len(zones), True
                    zones.append(zone)
        mine = mine.reshape(-1)
        return tuple(zones), which[mine], there[mine]

    def outlines(self, mount: Mount, shape: Shape) -> list[list[tuple[Point, Point]]]:
        """The lines [m] of each segment on a footprint, in the body's frame, from a mount of one robot."""
        return [_pieces(shape, mount.x, mount.y, mount.heading, sector) for sector in self.segments]


@functools.lru_cache(maxsize=4096)
def _zones(
    shape: Shape, mount: tuple[float, ...], segments: tuple[Sector, ...], reach: float
) -> tuple[Shape | None, ...]:
    """The zone that presses each segment, in the body's frame: its part of the outline, as thick as the reach."""
    x, y, heading = mount
    found: list[Shape | None] = []
    for sector in segments:
        parts = tuple(_pieces(shape, x, y, heading, sector))
        radius = reach + _SAGITTA * shape.radius
        found.append(Shape(vertices=parts, radius=radius, border=parts[0]) if parts else None)
    return tuple(found)


def _pieces(shape: Shape, x: float, y: float, heading: float, sector: Sector) -> list[tuple[Point, Point]]:
    """The lines of a footprint that lie in a sector as seen from a mount at x, y, in the body's frame."""
    ring = [(px - x, py - y) for px, py in shape.border]
    pieces = [
        piece
        for p, q in zip(ring, ring[1:] + ring[:1], strict=True)
        for piece in _within(p, q, sector.start + heading, sector.end + heading)
    ]
    return [((ax + x, ay + y), (bx + x, by + y)) for (ax, ay), (bx, by) in pieces]


def _within(p: Point, q: Point, start: float, end: float) -> list[tuple[Point, Point]]:
    """The pieces of the line from p to q that lie in directions between start and end from the origin."""
    (px, py), (dx, dy) = p, (q[0] - p[0], q[1] - p[1])
    cuts = {0.0, 1.0}
    for angle in (start, end):
        c, s = math.cos(angle), math.sin(angle)
        across = dx * s - dy * c
        if across != 0.0:
            cuts.add(min(max((py * c - px * s) / across, 0.0), 1.0))
    found = []
    marks = sorted(cuts)
    for first, last in itertools.pairwise(marks):
        middle = 0.5 * (first + last)
        angle = math.atan2(py + middle * dy, px + middle * dx)
        if (last - first) * math.hypot(dx, dy) > _LEAST and (angle - start) % (2.0 * math.pi) < end - start:
            found.append(((px + first * dx, py + first * dy), (px + last * dx, py + last * dy)))
    return found
