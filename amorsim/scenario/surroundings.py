"""Marks that sensors recognise, and lamps that they see."""

from __future__ import annotations

import attrs

from amorsim.contracts import parameter
from amorsim.scenario.kinds import check_colour

__all__ = ["Landmark", "Light"]


@attrs.frozen(kw_only=True)
class Landmark:
    """A mark that can be recognised: a disc that nothing touches, and that hides nothing."""

    id: int = parameter(ge=1, le=2**31 - 1, help="what is written on it")
    x: float = parameter(0.0, unit="m", frame="world", help="to the right in the world")
    y: float = parameter(0.0, unit="m", frame="world", help="up in the world")
    radius: float = parameter(
        0.05, unit="m", ge=0, le=100, help="of the disc: it is in sight if the line of sight comes so near to its place"
    )
    height: float = parameter(0.3, unit="m", gt=0, help="above the ground, to its top; for cameras")
    colour: str | None = parameter(None, help="a name of CSS or '#rrggbb', for cameras and pictures")

    def __attrs_post_init__(self) -> None:
        check_colour(self.colour)


@attrs.frozen(kw_only=True)
class Light:
    """A lamp that shines equally in all directions. Walls and bodies block its light; the lamp blocks none."""

    x: float = parameter(0.0, unit="m", frame="world", help="to the right in the world")
    y: float = parameter(0.0, unit="m", frame="world", help="up in the world")
    intensity: float = parameter(1.0, unit="cd", ge=0, help="how much it shines")
