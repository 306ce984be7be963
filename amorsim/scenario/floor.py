"""The floor of a scenario: how much light it returns, what is marked on it, and where it drops."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.patches import DROP, Patch
from amorsim.core.shapes import Shape
from amorsim.scenario.kinds import check_colour, is_a, many
from amorsim.scenario.pose import Pose

__all__ = ["Drop", "Floor", "Marking"]


_SHAPE, _POSE = "am.Shape.circle(0.2)", "am.Pose(x=1.0)"


def _in_world(shape: Shape, pose: Pose) -> Array:
    """The outline `(V, 2)` [m] of a shape at a pose."""
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    x, y = shape.outline.T
    return np.stack((pose.x + c * x - s * y, pose.y + s * x + c * y), axis=1)


@attrs.frozen(kw_only=True)
class Marking:
    """A line or an area on the floor that returns more light, or less, than the bare floor.

    A line goes through `points`, with round ends and corners; an area has a `shape`, which stands at `pose`.
    """

    points: tuple[tuple[float, float], ...] = parameter(
        (), unit="m", frame="world", help="places [x, y] in the world, joined by a line"
    )
    closed: bool = parameter(False, help="whether the line goes on from its last point to its first")
    width: float = parameter(0.02, unit="m", gt=0, le=100, help="of the line")
    shape: Shape | None = attrs.field(default=None, validator=attrs.validators.optional(is_a(Shape, _SHAPE)))
    pose: Pose = attrs.field(factory=Pose, validator=is_a(Pose, _POSE))
    reflectance: float = parameter(0.05, ge=0, le=1, help="part of the light that it returns")
    colour: str = parameter("black", help="a name of CSS or '#rrggbb', for pictures")

    def __attrs_post_init__(self) -> None:
        check_colour(self.colour)
        if (self.shape is None) == (not self.points):
            raise ParameterError("points", "expected the points of a line or the shape of an area, one of the two")
        if self.points and len(self.points) < (3 if self.closed else 2):
            least = "three points of a closed line" if self.closed else "two points"
            raise ParameterError("points", f"expected {least} at least, got {len(self.points)}")
        if any(a == b for a, b in itertools.pairwise(self._ring)):
            raise ParameterError("points", "expected each point to differ from the one before it")

    @property
    def _ring(self) -> tuple[tuple[float, float], ...]:
        return (*self.points, self.points[0]) if self.closed and self.points else self.points

    @property
    def footprint(self) -> Shape:
        """What it covers: of a line in the world's frame, of an area in that of `pose`."""
        if self.shape is not None:
            return self.shape
        return Shape(vertices=tuple(itertools.pairwise(self._ring)), radius=self.width / 2.0, border=self._ring)

    @property
    def patch(self) -> Patch:
        """As it is drawn."""
        if self.shape is not None:
            return Patch(_in_world(self.shape, self.pose), 0.0, self.colour)
        return Patch(np.array(self._ring, dtype=np.float64), self.width, self.colour)


@attrs.frozen(kw_only=True)
class Drop:
    """A part of the floor that lies deeper than the rest, such as a stairwell, or all that is beyond a table's edge.

    Sensors see it; nothing falls into it.
    """

    shape: Shape = attrs.field(validator=is_a(Shape, _SHAPE))
    pose: Pose = attrs.field(factory=Pose, validator=is_a(Pose, _POSE))
    depth: float = parameter(1.0, unit="m", gt=0, help="how much deeper it lies")

    @property
    def patch(self) -> Patch:
        """As it is drawn."""
        return Patch(_in_world(self.shape, self.pose), 0.0, DROP, is_drop=True)


def _markings(given: Iterable[Marking]) -> tuple[Marking, ...]:
    return many("markings", Marking, given)


def _drops(given: Iterable[Drop]) -> tuple[Drop, ...]:
    return many("drops", Drop, given)


@attrs.frozen(kw_only=True)
class Floor:
    """What sensors that look down measure: of markings that overlap the last one counts; a drop counts before all."""

    reflectance: float = parameter(0.8, ge=0, le=1, help="part of the light that the bare floor returns")
    markings: tuple[Marking, ...] = attrs.field(default=(), converter=_markings)
    drops: tuple[Drop, ...] = attrs.field(default=(), converter=_drops)

    @property
    def patches(self) -> list[Patch]:
        """All of it as it is drawn, the lowest first."""
        return [mark.patch for mark in self.markings] + [drop.patch for drop in self.drops]
