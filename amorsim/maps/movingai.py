"""Maps and scenarios of the MovingAI benchmarks: ``.map`` files of letters, and ``.scen`` files of problems on them.

A map (https://movingai.com/benchmarks/formats.html)::

    type octile
    height 2
    width 3
    map
    @.T
    ..W

``.`` and ``G`` are passable, ``@``, ``O`` and ``T`` are not. ``S`` is a swamp, which is passable, and ``W`` water,
which is not from land; options change both. The first row is the top one.

A scenario file begins with ``version 1``. Its rows are ``bucket map width height start_x start_y goal_x goal_y
optimal``, separated by tabs, where x counts columns and y counts rows from the top, both from 0.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import ClassVar

import attrs
import numpy as np
from numpy.typing import NDArray

from amorsim.contracts import MapLoader
from amorsim.core.errors import MapError
from amorsim.core.files.reading import read_bytes, reason
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter

__all__ = ["MovingAI", "Problem", "read_problems"]

_RESOLUTION = 1.0  # [m]
_NO_RESOLUTION = (
    f"no resolution is given, so a cell is taken for {_RESOLUTION:g} m; say how large one is, as in resolution = 0.5"
)
_KEYS = ("type", "height", "width")
_MOST_CELLS = 90_000_000  # which fit into a file of 100 MB with their line ends
_LINE_END = re.compile(rb"\r\n|\r|\n")
_WHOLE = re.compile(r"[0-9]{1,9}")
_BLOCKED, _FREE = b"@OT", b".G"


@attrs.frozen(kw_only=True)
class MovingAI(MapLoader):
    """Maps of the MovingAI benchmarks (``.map``): a letter for each cell."""

    extensions: ClassVar[tuple[str, ...]] = (".map",)

    resolution: float | None = parameter(None, unit="m", gt=0, help="side of a cell; without it 1, with a warning")
    origin_x: float = parameter(0.0, unit="m", help="x of the lower left corner")
    origin_y: float = parameter(0.0, unit="m", help="y of the lower left corner")
    origin_yaw: float = parameter(0.0, unit="rad", help="turn of the map about that corner")
    swamp: str = parameter("free", choices=("free", "occupied"), help="what S is")
    water: str = parameter("occupied", choices=("free", "occupied"), help="what W is")

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with the key ``type``."""
        return re.match(rb"\s*type[ \t]+[a-z]+[ \t]*[\r\n]", head) is not None

    def load(self, path: Path) -> Map:
        """The map of a file.

        Raises
        ------
        MapError
            If the file cannot be read, its header is not whole, a row is missing or of another width, or a letter is
            none that maps have; with the line.
        """
        try:
            letters, first, extra = _read_rows(_read_lines(path))
            occupied = self._table()[letters]
            if (occupied > 1).any():
                row, column = np.argwhere(occupied > 1)[0].tolist()
                raise MapError(
                    f"line {first + row}, column {column + 1}: {chr(letters[row, column])!r} is not a cell; expected "
                    "one of '.GSW@OT'"
                )
            warnings = [] if self.resolution is not None else [_NO_RESOLUTION]
            return Map.from_array(
                np.ascontiguousarray(occupied[::-1]),
                resolution=_RESOLUTION if self.resolution is None else self.resolution,
                origin=(self.origin_x, self.origin_y, self.origin_yaw),
                warnings=(*warnings, *extra),
                name=path.stem,
            )
        except MapError as error:
            raise MapError(f"{path}: {error}") from error

    @classmethod
    def save(cls, world: Map, path: Path) -> MovingAI:
        """Write a map's cells, ``@`` where they are occupied; see `amorsim.save_map`.

        The file holds neither resolution nor origin: the options of the loader do.
        """
        rows, columns = world.shape
        lines = np.full((rows, columns + 1), ord("\n"), dtype=np.uint8)
        lines[:, :-1] = np.where(world.to_array()[::-1] != 0, ord("@"), ord("."))
        header = f"type octile\nheight {rows}\nwidth {columns}\nmap\n"
        path.write_bytes(header.encode() + lines.tobytes())
        x, y, yaw = world.origin
        return cls(resolution=world.resolution, origin_x=x, origin_y=y, origin_yaw=yaw)

    def _table(self) -> NDArray[np.uint8]:
        """For each letter 0 for free, 1 for occupied, and 2 if it is not a map's."""
        table = np.full(256, 2, np.uint8)
        table[list(_FREE)] = 0
        table[list(_BLOCKED)] = 1
        table[ord("S")] = self.swamp == "occupied"
        table[ord("W")] = self.water == "occupied"
        return table


@attrs.frozen(kw_only=True)
class Problem:
    """A problem of a scenario file: from a start to a goal on a map.

    Cells count columns and rows from 0, rows from the *bottom*, as the cells of an `amorsim.Map` do. `optimal` is the
    length of the shortest path in cells, where a diagonal step counts √2 and both cells next to it must be free.
    """

    bucket: int
    map: str
    """The map's path, as the file has it."""
    width: int
    height: int
    start: tuple[int, int]
    """(row, column)"""
    goal: tuple[int, int]
    """(row, column)"""
    optimal: float

    @property
    def is_reachable(self) -> bool:
        """Whether there is a path; in files a length of 0 means that there is none."""
        return self.optimal > 0.0 or self.start == self.goal


def read_problems(path: str | Path) -> tuple[Problem, ...]:
    """The problems in a scenario file (``.scen``) of the MovingAI benchmarks, in its order.

    Raises
    ------
    MapError
        If the file cannot be read, or a row is not one of a scenario; with the line.
    """
    path = Path(path)
    try:
        lines = [line.decode("utf-8", "replace") for line in _read_lines(path)]
        if not lines or re.fullmatch(r"version\s+1(\.0)?\s*", lines[0]) is None:
            raise MapError("line 1: expected 'version 1'")
        return tuple(_problem(line, number) for number, line in enumerate(lines[1:], start=2) if line.strip())
    except MapError as error:
        raise MapError(f"{path}: {error}") from error


def _problem(line: str, number: int) -> Problem:
    words = line.split("\t") if "\t" in line else line.split()
    if len(words) != 9:
        raise MapError(f"line {number}: a row has {len(words)} columns; expected 9: bucket, map, width, height, ...")
    whole = [words[0].strip(), *(word.strip() for word in words[2:8])]
    for word in whole:
        if _WHOLE.fullmatch(word) is None:
            raise MapError(f"line {number}: {word!r} is not a whole number")
    bucket, width, height, start_x, start_y, goal_x, goal_y = map(int, whole)
    try:
        optimal = float(words[8])
    except ValueError:
        optimal = math.nan
    if not (math.isfinite(optimal) and optimal >= 0.0):
        raise MapError(f"line {number}: {words[8].strip()!r} is not a length of a path")
    if not (max(start_x, goal_x) < width and max(start_y, goal_y) < height):
        raise MapError(f"line {number}: start or goal is outside the map, which has {width} x {height} cells")
    return Problem(
        bucket=bucket,
        map=words[1].strip(),
        width=width,
        height=height,
        start=(height - 1 - start_y, start_x),
        goal=(height - 1 - goal_y, goal_x),
        optimal=optimal,
    )


def _read_lines(path: Path) -> list[bytes]:
    try:
        return _LINE_END.split(read_bytes(path).removeprefix(b"\xef\xbb\xbf").rstrip(b"\x1a"))
    except (OSError, ValueError) as error:
        raise MapError(f"cannot be read: {reason(error)}") from error


def _read_rows(lines: list[bytes]) -> tuple[NDArray[np.uint8], int, tuple[str, ...]]:
    """The letters (rows, columns) from the top, the line of the first row, and remarks."""
    sizes: dict[str, int] = {}
    at = 0
    for at, line in enumerate(lines, start=1):
        words = line.decode("latin-1").split()
        if not words:
            continue
        key = words[0].lower()
        if key == "map" and len(words) == 1:
            break
        if key not in _KEYS or len(words) != 2:
            raise MapError(
                f"line {at}: {line[:40].decode('latin-1')!r} is none of: type octile, height N, width N, map"
            )
        if key != "type":
            if _WHOLE.fullmatch(words[1]) is None or int(words[1]) == 0:
                raise MapError(f"line {at}: {key} is {words[1][:20]!r}; expected a whole number above 0")
            sizes[key] = int(words[1])
    else:
        raise MapError("there is no line 'map', after which the rows begin")
    for key in ("height", "width"):
        if key not in sizes:
            raise MapError(f"there is no line '{key} N' before the rows")
    height, width = sizes["height"], sizes["width"]
    if height * width > _MOST_CELLS:
        raise MapError(f"the map has {width} x {height} cells; expected {_MOST_CELLS} at most")
    rows = lines[at : at + height]
    for number, row in enumerate(rows, start=at + 1):
        if len(row.rstrip()) != width:
            raise MapError(f"line {number}: the row has {len(row.rstrip())} cells; expected {width}, the map's width")
    if len(rows) < height:
        raise MapError(f"line {len(lines)}: the map ends after {len(rows)} rows; expected {height}, the map's height")
    letters = np.frombuffer(b"".join(row.rstrip() for row in rows), np.uint8).reshape(height, width)
    more = [number for number, line in enumerate(lines[at + height :], start=at + height + 1) if line.strip()]
    return letters, at + 1, (f"line {more[0]}: what follows the {height} rows is left out",) if more else ()
