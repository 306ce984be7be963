"""Where robots went, as pictures of runs show it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.core.parameters import ParameterError

__all__ = ["Points", "RobotPath", "finite", "points_of"]

Points = NDArray[np.float64]


def points_of(value: Any) -> Points:
    """A float copy, (T, 2); no points for an empty argument."""
    points = np.array(value, np.float64)
    return points.reshape(0, 2) if points.size == 0 else points


def _no_points() -> Points:
    return np.empty((0, 2))


def _check_points(_: Any, attribute: attrs.Attribute[Any], value: Points | None) -> None:
    if value is not None and (value.ndim != 2 or value.shape[1] != 2):
        raise ParameterError(attribute.name, f"expected points (T, 2) [m], got an array of shape {value.shape}")


@attrs.frozen(kw_only=True, eq=False)
class RobotPath:
    """Where a robot went, in world metres.

    `true` and `estimated` are its paths, (T, 2); either may be empty, and a point that is not finite
    interrupts it. `outline` is the robot's body (V, 2) at the end, or None, `parts` those of its parts;
    `collisions`, (K, 2), are where it touched something; `colour` is its own, none for that of all robots.
    """

    name: str
    true: Points = attrs.field(converter=points_of, validator=_check_points)
    estimated: Points = attrs.field(factory=_no_points, converter=points_of, validator=_check_points)
    outline: Points | None = attrs.field(
        default=None, converter=attrs.converters.optional(points_of), validator=_check_points
    )
    collisions: Points = attrs.field(factory=_no_points, converter=points_of, validator=_check_points)
    parts: Sequence[Points] = ()
    colour: str | None = None


def finite(points: Points) -> Points:
    """The points all of whose numbers are finite."""
    return points[np.all(np.isfinite(points), axis=1)]
