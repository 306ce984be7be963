"""Line worlds: the ``.wld`` files of Saphira, Pioneer simulators and EyeSim, read into a map of fine cells."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import ClassVar

import attrs

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.maps.cell_lines import extent_of, wall_lines
from amorsim.core.maps.map import Map
from amorsim.core.numbers import millimetres
from amorsim.core.parameters import parameter
from amorsim.maps.wld_statements import PUSH_SIGNS, begins_a_world, parse_world

__all__ = ["Wld"]

# Tab, line ends, form feed and the end-of-file mark of DOS occur in texts; other control characters do not.
_BINARY = re.compile(rb"[\x00-\x08\x0b\x0e-\x19\x1b-\x1f]")


@attrs.frozen(kw_only=True)
class Wld(MapLoader):
    """Line worlds (``.wld``): walls drawn as thin lines into cells of `resolution`.

    Thickness, height and colour of EyeSim's walls are left out: a wall is its centre line.
    """

    extensions: ClassVar[tuple[str, ...]] = (".wld",)

    resolution: float = parameter(0.001, unit="m", gt=0, help="side of a cell")
    push_sign: str = parameter("clockwise", choices=tuple(PUSH_SIGNS), help="which way the angle of a push counts")

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether the first statement in a file's first bytes is one of a line world."""
        return not _BINARY.search(head) and begins_a_world(_decode(head))

    def load(self, path: Path) -> Map:
        """The map of a file; lines that could not be read are among its warnings.

        Raises
        ------
        MapError
            If the file cannot be read, is not text, holds a number that is not finite, or neither a wall nor a
            size.
        """
        try:
            data = read_bytes(path)
        except (OSError, ValueError) as error:
            raise MapError(f"{path}: cannot be read: {reason(error)}") from error
        binary = _BINARY.search(data)
        if binary:
            raise MapError(
                f"{path}: byte {binary.start()} is {binary.group()[0]:#04x}: this is not a text file, and a "
                "line world (.wld) is one"
            )
        try:
            world = parse_world(_decode(data), push_sign=self.push_sign)
            return Map.from_segments(
                world.segments,
                resolution=self.resolution,
                extent=world.extent,
                start=world.start,
                warnings=world.warnings,
                name=path.stem,
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    @classmethod
    def save(cls, world: Map, path: Path) -> Wld:
        """Write the walls of a map as lines, those of cells from middle to middle; see `amorsim.save_map`."""
        left, bottom, right, top = extent_of(world)
        width, height = world.size if world.origin[2] == 0.0 else (right - left, top - bottom)
        lines = [
            f"origin {millimetres(left)} {millimetres(bottom)}",
            f"width {millimetres(width)}",
            f"height {millimetres(height)}",
        ]
        if world.start is not None:
            x, y, heading = world.start
            lines.append(f"position {millimetres(x)} {millimetres(y)} {math.degrees(heading)!r}")
        lines += [" ".join(map(millimetres, wall)) for wall in wall_lines(world).tolist()]
        path.write_text("\n".join(lines) + "\n", encoding="ascii", newline="\n")
        return cls(resolution=world.resolution)


def _decode(data: bytes) -> str:
    """The text, as UTF-8; otherwise as Latin 1, in which every byte is a letter."""
    data = data.rstrip(b"\x1a")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")
