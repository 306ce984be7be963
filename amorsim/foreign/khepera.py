"""Worlds of the Khepera Simulator 2.0 (``.world``): a playground of a metre with bricks, corks and lamps.

A text file. Commas and blanks separate numbers::

    ANY,TYPE                    whether there are objects, and the type that was chosen last
    NAME                        three times, of bricks, lamps and corks: name and angle in its construction kit
    ANGLE
    WORD,WORD, ...              8000 hexadecimal words of 32 bits: column after column of 32 x 500 pixels of 2 mm
    TYPE,X,Y,ANGLE,MORE         an object: 0 a brick, 1 a lamp, 2 a cork, 3 a lamp that is off; mm, degrees

y counts downwards. A brick is 50 mm x 20 mm, a cork a disc of 16 mm, a lamp one of 34 mm.
"""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import MapLoader, ScenarioDocument, ScenarioLoader
from amorsim.core.errors import Fault, MapError, ScenarioError
from amorsim.core.maps.map import Map
from amorsim.foreign.text import Faults, is_binary, read_text

__all__ = ["Khepera", "KheperaMap", "Playground", "Thing", "read_playground"]

_MOST_BYTES = 5_000_000
_MOST_THINGS = 10_000
_PIXELS, _COLUMNS, _BITS = 500, 16, 32
_PIXEL = 0.002  # [m]
_SIZE = _PIXELS * _PIXEL
_BRICK, _LAMP, _CORK, _LAMP_OFF = 0, 1, 2, 3
_BRICK_SIZE = 0.050, 0.020
_RADIUS = {_LAMP: 0.017, _LAMP_OFF: 0.017, _CORK: 0.008}
_FIRST = re.compile(rb"\s*[01]\s*,\s*[0-9]+\s*\r?\n\s*[A-Za-z]")
_WORD = re.compile(r"[0-9a-fA-F]{1,16}")
_WHOLE = re.compile(r"[+-]?[0-9]{1,6}")


class Thing(NamedTuple):
    """An object: its type, place [m] with y upwards, and its angle [deg]."""

    kind: int
    x: float
    y: float
    degrees: float


@attrs.frozen(eq=False)
class Playground:
    """The content of a world: its picture, row 0 lowest, True where something was drawn; and its objects."""

    pixels: Bools
    things: tuple[Thing, ...]

    def walls(self) -> Bools:
        """The picture with all bricks in it and without lamps, which let light through and block nothing."""
        cells = self.pixels.copy()
        for thing in self.things:
            if thing.kind in (_LAMP, _LAMP_OFF):
                cells &= ~_disc(thing, _RADIUS[thing.kind] + _PIXEL)
        for thing in self.things:
            if thing.kind == _BRICK:
                cells |= _brick(thing)
        return cells

    def is_drawn(self, thing: Thing) -> bool:
        """Whether the picture has something where a thing has its middle."""
        row, col = int(thing.y / _PIXEL), int(thing.x / _PIXEL)
        return bool(self.pixels[min(row, _PIXELS - 1), min(col, _PIXELS - 1)])


def _middles() -> tuple[Array, Array]:
    middle = (np.arange(_PIXELS, dtype=np.float64) + 0.5) * np.float64(_PIXEL)
    return middle[None, :], middle[:, None]


def _disc(thing: Thing, radius: float) -> Bools:
    x, y = _middles()
    found: Bools = (x - thing.x) ** 2 + (y - thing.y) ** 2 <= radius**2
    return found


def _brick(thing: Thing) -> Bools:
    x, y = _middles()
    c, s = math.cos(math.radians(thing.degrees)), math.sin(math.radians(thing.degrees))
    along, across = (x - thing.x) * c + (y - thing.y) * s, (y - thing.y) * c - (x - thing.x) * s
    length, width = (side + 1e-9 for side in _BRICK_SIZE)  # with the pixels whose middles lie on its border
    found: Bools = (np.abs(along) <= length / 2) & (np.abs(across) <= width / 2)
    return found


def read_playground(path: Path) -> Playground:
    """The world in a file.

    Raises
    ------
    ScenarioError
        If it cannot be read, its picture is not whole, or with the line of an object that is none.
    """
    lines = read_text(path, _MOST_BYTES, "a world of the Khepera Simulator").splitlines()
    faults = Faults(path)
    words: list[tuple[str, int]] = []  # with their lines
    for number, text in enumerate(lines[7:], start=8):
        words += ((word, number) for word in re.split(r"[,\s]+", text) if word)
    if len(lines) < 7 or not _FIRST.match("\n".join(lines[:2]).encode()):
        message = "expected ANY,TYPE and three times a name and an angle in the first seven lines"
        raise ScenarioError([Fault(file=str(path), path="", line=1, message=message)])
    count = _COLUMNS * _PIXELS
    image, objects = words[:count], words[count:]
    if len(image) < count:
        message = f"expected a picture of {count} hexadecimal words, got {len(image)}"
        raise ScenarioError([Fault(file=str(path), path="", line=len(lines), message=message)])
    values = np.zeros(count, dtype=np.uint64)
    for at, (word, line) in enumerate(image):
        if not _WORD.fullmatch(word):
            faults.add(
                line, f"expected a hexadecimal word, number {at + 1} of the picture's {count}, got {word[:20]!r}"
            )
        else:
            values[at] = int(word, 16) & 0xFFFFFFFF
    things = _things(objects, faults)
    faults.raise_if_any()
    bits = (values.reshape(_COLUMNS, _PIXELS, 1) >> np.arange(_BITS, dtype=np.uint64)) & np.uint64(1)
    # (column of words, row, bit) to (row, column); 12 of the 512 columns of pixels lie outside.
    pixels = bits.transpose(1, 0, 2).reshape(_PIXELS, -1)[:, :_PIXELS].astype(bool)
    return Playground(np.ascontiguousarray(pixels[::-1]), tuple(things))


def _things(words: list[tuple[str, int]], faults: Faults) -> list[Thing]:
    if len(words) % 5:
        faults.add(words[-1][1], f"expected objects of 5 numbers each, TYPE,X,Y,ANGLE,MORE; got {len(words)} numbers")
    found: list[Thing] = []
    for begin in range(0, len(words) - 4, 5):
        line = words[begin][1]
        if len(found) == _MOST_THINGS:
            faults.add(line, f"expected at most {_MOST_THINGS} objects")
            break
        texts = [word for word, _ in words[begin : begin + 5]]
        if not all(_WHOLE.fullmatch(word) for word in texts):
            faults.add(
                line, f"expected an object of 5 whole numbers, TYPE,X,Y,ANGLE,MORE, got {','.join(texts)[:60]!r}"
            )
            continue
        kind, x, y, degrees, _ = map(int, texts)
        if kind not in (_BRICK, _LAMP, _CORK, _LAMP_OFF):
            faults.add(line, f"expected an object of type 0 (brick), 1 or 3 (lamp) or 2 (cork), got {kind}")
        elif not (0 <= x <= 1000 and 0 <= y <= 1000):
            faults.add(line, f"expected an object at 0 to 1000 mm, got ({x}, {y})")
        else:
            found.append(Thing(kind, x / 1000, _SIZE - y / 1000, float(degrees % 360)))
    return found


def _looks_like_one(head: bytes) -> bool:
    return bool(_FIRST.match(head)) and not is_binary(head)


@attrs.frozen(kw_only=True)
class KheperaMap(MapLoader):
    """The walls of the Khepera Simulator's worlds (``.world``): the picture, 2 mm to a pixel, and the bricks."""

    extensions: ClassVar[tuple[str, ...]] = (".world",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with two numbers, and then a name."""
        return _looks_like_one(head)

    def load(self, path: Path) -> Map:
        """The map of a world; raises `MapError` if it cannot be read, or is not whole."""
        try:
            walls = read_playground(path).walls()
        except ScenarioError as error:
            raise MapError(str(error)) from error
        return Map.from_array(walls, resolution=_PIXEL, name=path.stem)


@attrs.frozen(kw_only=True)
class Khepera(ScenarioLoader):
    """Worlds of the Khepera Simulator 2.0 (``.world``) with a Khepera in them, where it has most room.

    Bricks and what else was drawn are walls; corks that were not drawn are obstacles, and lamps that are on are lights.
    A world does not contain where the robot is.
    """

    extensions: ClassVar[tuple[str, ...]] = (".world",)

    @classmethod
    def sniff(cls, head: bytes) -> bool:
        """Whether a file begins with two numbers, and then a name."""
        return _looks_like_one(head)

    def read(self, path: Path) -> ScenarioDocument:
        """The scenario of a world; raises `ScenarioError` with the lines of what is wrong."""
        ground = read_playground(path)
        robot = {"name": "khepera", "model": "khepera", "controller": {"use": "braitenberg", "speed": 0.06}}
        tables: dict[str, Any] = {
            "format": 1,
            "world": {"map": path.name, "use": "khepera"},
            "simulation": {"dt": 0.05},
            "robots": [robot | {"on_collision": "continue"}],
        }
        corks = [each for each in ground.things if each.kind == _CORK and not ground.is_drawn(each)]
        if corks:
            tables["obstacles"] = [
                {"name": f"cork{number}", "shape": {"circle": _RADIUS[_CORK]}, "pose": _place(cork), "height": 0.03}
                for number, cork in enumerate(corks, start=1)
            ]
        if lamps := [each for each in ground.things if each.kind == _LAMP]:
            tables["lights"] = [_place(lamp) for lamp in lamps]
        off = sum(each.kind == _LAMP_OFF for each in ground.things)
        remarks = (f"{off} lamps that are off are left out",) if off else ()
        return ScenarioDocument(tables=tables, remarks=remarks)


def _place(thing: Thing) -> dict[str, float]:
    return {"x": round(thing.x, 6), "y": round(thing.y, 6)}
