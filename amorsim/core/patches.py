"""Patches of the floor, as they are drawn."""

from __future__ import annotations

from typing import NamedTuple

from amorsim.array_types import Array

__all__ = ["DROP", "Patch"]

DROP = "#4a515c"
"""The colour of drops."""


class Patch(NamedTuple):
    """A line of a width, or an area, on the floor; in metres of the world."""

    points: Array  # (V, 2) along the line, its first point again where it is closed; or the outline
    width: float  # [m] of the line, 0 for an area
    colour: str
    is_drop: bool = False
