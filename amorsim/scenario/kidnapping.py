"""Robots that are carried away in the middle of a run."""

from __future__ import annotations

import attrs

from amorsim.contracts import parameter

__all__ = ["Kidnapping"]


@attrs.frozen(kw_only=True)
class Kidnapping:
    """A robot is carried to another pose at a time; its sensors do not notice it.

    That must be free of walls and of other bodies then. Robots that are carried at one instant may take each other's
    places. It is an event of the kind ``"kidnapped"``.
    """

    time: float = parameter(unit="s", ge=0, help="when; at the first step that begins then or later")
    x: float = parameter(0.0, unit="m", frame="world", help="where to")
    y: float = parameter(0.0, unit="m", frame="world", help="where to")
    heading: float = parameter(0.0, unit="rad", help="where it looks then, anticlockwise from x")
