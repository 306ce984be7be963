"""The file of a map as a text that is edited: a line world as it is, a bitmap as runs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from amorsim.core.reading import read_bytes, reason
from amorsim.ui.editor.bitmaps import CODEC, SUFFIXES, decode, encode
from amorsim.ui.editor.walls import WallsError

__all__ = ["MapText", "read_map_text"]


@attrs.define(kw_only=True)
class MapText:
    """The text of a map's file, and what is in the file: None where there is none."""

    text: str
    saved: str | None
    encoding: str = "utf-8"

    def data(self, suffix: str) -> bytes:
        """As it is written into a file."""
        return encode(self.text, suffix) if self.encoding == CODEC else self.text.encode(self.encoding)


def read_map_text(path: Path, world: Mapping[str, Any]) -> MapText:
    """The text of a map's file, for a scenario's table of the world.

    Raises
    ------
    WallsError
        If it cannot be read, or is a bitmap that cannot be painted on.
    """
    try:
        data = read_bytes(path)
    except (OSError, ValueError) as error:
        raise WallsError(f"{path.name}: cannot be read: {reason(error)}") from None
    if path.suffix.lower() in SUFFIXES:
        text, encoding = decode(data, path.name, has_threshold=isinstance(world.get("threshold"), (int, float))), CODEC
    else:
        try:
            text, encoding = data.decode(), "utf-8"
        except UnicodeDecodeError:
            text, encoding = data.decode("latin-1"), "latin-1"
    return MapText(text=text, saved=text, encoding=encoding)
