"""The walls of a scenario's map, where they can be changed: in line worlds, whose text is edited."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

import attrs

from amorsim.core.errors import AmorsimError
from amorsim.maps.wld_text import with_walls

__all__ = ["EMPTY_WORLD", "WallsError", "World", "world_of"]

EMPTY_WORLD = "width 12000\nheight 8000\n"  # mm


class WallsError(AmorsimError):
    """Walls that cannot be changed."""


@attrs.frozen(kw_only=True)
class World:
    """How the text of a line world is read."""

    push_sign: str

    def changed(self, text: str, *, add: list[list[float]], change: dict[int, list[float]], remove: set[int]) -> str:
        """The text with other walls; raises `MapError` if it would be no line world."""
        return with_walls(text, add=add, change=change, remove=remove, push_sign=self.push_sign)


def world_of(table: Mapping[str, Any] | None, name: str) -> World:
    """How the map that a scenario names is read.

    Raises
    ------
    WallsError
        If it is not a line world.
    """
    table = table or {}
    use = table.get("use")
    if use != "wld" and (use is not None or PurePath(name).suffix.lower() != ".wld"):
        raise WallsError(
            f"{name}: walls can be drawn in line worlds (.wld) only; this map is of another format, and stays as it is"
        )
    sign = table.get("push_sign")
    return World(push_sign=sign if sign in ("clockwise", "anticlockwise") else "clockwise")
