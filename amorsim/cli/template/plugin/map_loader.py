"""A map loader: walls drawn with characters."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np

import amorsim as am

__all__ = ["Letters"]


@attrs.frozen(kw_only=True)
class Letters(am.MapLoader):
    """Reads a text in which each character is a square: ``#`` is wall, all else is free; the first line is on top.

    Parameters
    ----------
    resolution
        Side of a square [m].
    """

    extensions: ClassVar[tuple[str, ...]] = (".letters",)

    resolution: float = am.parameter(0.5, unit="m", gt=0, help="side of a square")

    def load(self, path: Path) -> am.Map:
        """The map in a file; `MapError` if it cannot be read, or is empty."""
        try:
            lines = path.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise am.MapError(f"{path}: cannot be read as text: {error}") from error
        width = max((len(line) for line in lines), default=0)
        if width == 0:
            raise am.MapError(f"{path}: expected lines of # and blanks, got nothing")
        cells = np.array([[letter == "#" for letter in line.ljust(width)] for line in reversed(lines)], dtype=np.uint8)
        return am.Map.from_array(cells, resolution=self.resolution, name=path.name)
