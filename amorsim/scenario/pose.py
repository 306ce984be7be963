"""A pose in the world, as a scenario gives it."""

from __future__ import annotations

import attrs

from amorsim.contracts import parameter

__all__ = ["Pose"]


@attrs.frozen(kw_only=True)
class Pose:
    """A pose in the world."""

    x: float = parameter(0.0, unit="m", frame="world", help="to the right in the world")
    y: float = parameter(0.0, unit="m", frame="world", help="up in the world")
    heading: float = parameter(0.0, unit="rad", help="anticlockwise from the world's x axis")
