"""The inputs that are tried: scenarios, numbers, maps, recorded tracks, other programs' files; each wrong at random."""

from __future__ import annotations

import copy
import functools
import io
import os
import signal
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any, Protocol

from PIL import Image

import amorsim as am
from amorsim.core.errors import AmorsimError
from amorsim.maps.bmp import Bitmap
from amorsim.maps.wld import Wld
from amorsim.motions.track import read_track
from amorsim.plugins.manager import make_registry
from amorsim.scenario.files.resolved import resolved
from amorsim.scenario.reading.read import loads
from amorsim.scenario.toml.angles import parse_float
from tests.fuzz.api import Api
from tests.fuzz.damage import damaged
from tests.fuzz.foreign import FOREIGN
from tests.fuzz.maps import LOADERS, MAPS
from tests.fuzz.recorded import RECORDED
from tests.fuzz.scenarios import BASES, ROOM, TRACK

__all__ = ["FUZZERS", "Fuzzer"]

Key = tuple[Any, ...]

EXTREMES = (
    *(0, -0.0, 1, -1, 0.1, 2, 1e-320, 1e-300, 1e-20, 1e-9, 1e-6, 1e-3, 10.0, 1e3, 1e5, 1e9, 1e12, 1e15, 1e20, 1e100),
    *(1e300, 1.7e308, -1e-9, -1e-3, -1e3, -1e9, -1e20, -1e300, 2**31, 2**53 + 1, 2**63, 2**64, 10**30, 10**400),
)
FACTORS = (1e-12, 1e-9, 1e-6, 1e-5, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e5, 1e6, 1e9, 1e12, -1.0)
JUNK = (
    *(
        None,
        True,
        False,
        "",
        "x",
        "none",
        "\0",
        "n" * 300,
        "\N{SNOWMAN}",
        [],
        {},
        [[]],
        [None],
        [1, "x"],
        {"use": "laser"},
    ),
    *({"random": "anywhere"}, {"circle": 0.1}, {"polygon": [[0, 0], [1, 1]]}, [[0.0, 0.0]] * 3, [{}], {"x": {"x": 1}}),
    *("nan", "/dev/zero", "..", "room.wld", "track.csv", "wander", "encoder", "laser", float("nan"), float("inf"), -1),
)
STEPS = 2
FORMATS = {"bmp": "BMP", "png": "PNG", "pgm": "PPM", "gif": "GIF", "jpg": "JPEG", "tif": "TIFF"}


class Fuzzer(Protocol):
    """Makes inputs and tries them; `said` is the last one, in words."""

    said: str

    def attempt(self, rng: Random) -> None:
        """Make an input and try it."""


class _Documents:
    """Documents of small scenarios, complete, as they are read; in a folder with their files."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.said = ""
        self.registry = make_registry(entry_points=(), disabled="")
        (folder / "room.wld").write_text(ROOM)
        (folder / "track.csv").write_text(TRACK)
        Image.new("1", (40, 30), 1).save(folder / "room.bmp")
        self.given = [tomllib.loads(text, parse_float=parse_float) for text in BASES]
        self.whole = [resolved(loads(document, folder, registry=self.registry)) for document in self.given]

    def simulate(self, document: dict[str, Any]) -> None:
        scenario = loads(document, self.folder, registry=self.registry)
        simulation = am.Simulation(scenario)
        for _ in range(STEPS):
            simulation.step()


def _leaves(value: Any, path: Key = ()) -> Iterator[tuple[Key, Any]]:
    """Every place in a document and what stands there, tables and lists too."""
    if path:
        yield path, value
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, part in inner:
        yield from _leaves(part, (*path, key))


def _at(document: Any, path: Key) -> Any:
    for key in path:
        document = document[key]
    return document


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


class Numbers(_Documents):
    """One to three numbers of a whole scenario are too large or too small."""

    def attempt(self, rng: Random) -> None:
        document = copy.deepcopy(rng.choice(self.whole))
        places = [path for path, value in _leaves(document) if _is_number(value)]
        changes = []
        for path in rng.sample(places, rng.choice((1, 1, 2, 3))):
            owner, key = _at(document, path[:-1]), path[-1]
            old = owner[key]
            extreme = rng.choice(EXTREMES) if old == 0 or rng.random() < 0.5 else old * rng.choice(FACTORS)
            owner[key] = round(extreme) if isinstance(old, int) and abs(extreme) < 1e15 else extreme
            changes.append(f"{'.'.join(map(str, path))} = {str(owner[key])[:40]}")
        self.said = "; ".join(changes)
        self.simulate(document)


class Scenarios(_Documents):
    """Parts of a scenario are left out, moved, doubled, renamed or replaced; or letters of its text are."""

    def attempt(self, rng: Random) -> None:
        if rng.random() < 0.3:
            return self._text(rng)
        document = copy.deepcopy(rng.choice(self.given if rng.random() < 0.7 else self.whole))
        self.said = ""
        for _ in range(rng.choice((1, 1, 2, 4))):
            self._change(document, rng)
        return self.simulate(document)

    def _change(self, document: dict[str, Any], rng: Random) -> None:
        places = list(_leaves(document))
        if not places:
            return
        path, value = rng.choice(places)
        owner, key = _at(document, path[:-1]), path[-1]
        what = rng.choice(("drop", "junk", "number", "other", "double", "rename"))
        if what == "drop":
            del owner[key]
        elif what == "junk":
            owner[key] = copy.deepcopy(rng.choice(JUNK))
        elif what == "number":
            owner[key] = rng.choice(EXTREMES)
        elif what == "other":
            owner[key] = copy.deepcopy(rng.choice(places)[1])
        elif what == "double" and isinstance(owner, list):
            owner.extend(copy.deepcopy([value] * rng.choice((1, 3))))
        elif isinstance(owner, dict):
            owner[f"{key}{rng.choice(('s', '_deg', '', '.', ' '))}"] = owner.pop(key)
        self.said += f"{what} {'.'.join(map(str, path))}; "

    def _text(self, rng: Random) -> None:
        path = self.folder / "scenario.toml"
        data = damaged(rng.choice(BASES).encode(), rng)
        self.said = repr(data)
        path.write_bytes(data)
        simulation = am.Simulation(am.load(path, registry=self.registry))
        simulation.step()


_WORDS = (
    *("width", "height", "origin", "position", "push", "pop", "floor", "floor_texture", "wall", "corridor", "door"),
    *(";", "#", "(1)", "nan", "inf", "1e999", "-5", "junction", "x"),
)


class LineWorlds:
    """Statements with too many, too few or too large numbers; and files of others, damaged."""

    def __init__(self, folder: Path) -> None:
        self.path = folder / "world.wld"
        self.said = ""

    def attempt(self, rng: Random) -> None:
        text = "\n".join(self._line(rng) for _ in range(rng.randint(0, 12))) if rng.random() < 0.7 else ROOM
        data = text.encode()
        if rng.random() < 0.5:
            data = damaged(data, rng)
        self.said = repr(data)
        self.path.write_bytes(data)
        loader = Wld(
            resolution=rng.choice((0.001, 0.01, 0.01, 0.05, 0.5)), push_sign=rng.choice(("clockwise", "anticlockwise"))
        )
        world = loader.load(self.path)
        world.cast_rays([[*world.origin[:2], 0.3]], [0.0, 1.0], 10.0)

    def _line(self, rng: Random) -> str:
        if rng.random() < 0.5:
            return " ".join(self._number(rng) for _ in range(rng.choice((4, 4, 4, 6, 7, 9, 3, 5))))
        return " ".join([rng.choice(_WORDS), *(self._number(rng) for _ in range(rng.randint(0, 6)))])

    def _number(self, rng: Random) -> str:
        if rng.random() < 0.99:
            return str(round(rng.uniform(-5000, 5000), rng.choice((0, 0, 3))))
        if rng.random() < 0.99:
            return rng.choice((f"{rng.uniform(-1e6, 1e6):.0f}", "0", "-0", "1e-9", "1e-320", "1e12", "1e13", "1e300"))
        return rng.choice(("1e7", "25000000", "1e8", "1e9", "9e11"))


class Bitmaps:
    """Images of many kinds, as they are or damaged, as worlds of any resolution."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.said = ""

    def attempt(self, rng: Random) -> None:
        mode = rng.choice(("1", "L", "P", "RGB", "RGBA", "LA", "I;16"))
        kinds = ("png", "tif") if mode in ("LA", "I;16") else ("png", "bmp", "pgm", "gif", "jpg", "tif")
        if mode in ("P", "RGBA"):
            kinds = ("png", "bmp", "tif")
        kind = rng.choice(kinds)
        size = rng.choice((1, 2, 7, 40)), rng.choice((1, 3, 8, 30))
        image = Image.new("1", size)
        image.putdata([rng.choice((0, 255)) for _ in range(size[0] * size[1])])
        buffer = io.BytesIO()
        image.convert("L").convert(mode).save(buffer, FORMATS[kind])
        data = buffer.getvalue()
        if rng.random() < 0.8:
            data = damaged(data, rng) if rng.random() < 0.6 else _with_header(data, rng)
        path = self.folder / f"world.{kind}"
        path.write_bytes(data)
        self.said = f"{kind} {mode} {size} {data[:80]!r}"
        threshold = rng.choice((None, 0.0, 0.5, 1.0))
        world = Bitmap(
            resolution=rng.choice((1e-6, 1e-3, 0.05, 1.0, 1e3, 1e9)),
            threshold=threshold,
            transparent=rng.choice(("white", "black", "unknown")),
            size=rng.choice((None, None, None, (1.0, 2.0), (0.01, 100.0))),
        ).load(path)
        world.cast_rays([[*world.origin[:2], 0.3]], [0.0, 1.0], 10.0)


def _with_header(data: bytes, rng: Random) -> bytes:
    """An image whose header says something else, such as another size."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 3)):
        at = rng.randrange(min(len(changed) - 4, 54))
        changed[at : at + 4] = rng.choice((0, 1, 2**31 - 1, 2**32 - 1, 13_000, 100_000, rng.randrange(2**32))).to_bytes(
            4, rng.choice(("little", "big"))
        )
    return bytes(changed)


class Tracks:
    """Tables of times and places, with wrong columns, cells and letters, and what goes along them."""

    def __init__(self, folder: Path) -> None:
        self.documents = _Documents(folder)
        self.path = folder / "other.csv"
        self.said = ""

    def attempt(self, rng: Random) -> None:
        columns = rng.sample(("time", "x", "y", "heading_deg", "z", "time"), rng.choice((2, 3, 3, 4, 4, 5)))
        if rng.random() < 0.7:
            columns = ["time", "x", "y", *(["heading_deg"] * rng.randrange(2))]
        time = 0.0
        lines = [",".join(columns)]
        for _ in range(rng.choice((0, 1, 2, 3, 8))):
            time += rng.choice((1.0, 0.1, 1e-9, 1e-300, 1e6, 0.0, -1.0)) if rng.random() < 0.3 else 0.5
            cells = [repr(time) if column == "time" else self._cell(rng) for column in columns]
            lines.append(",".join(cells))
        data = "\n".join(lines).encode()
        if rng.random() < 0.4:
            data = damaged(data, rng)
        self.said = repr(data)
        self.path.write_bytes(data)
        track = read_track(self.path)
        assert track.fastest >= 0.0
        document = copy.deepcopy(self.documents.given[-1])
        document["obstacles"][-1]["motion"] = {"use": "track", "file": "other.csv", "repeat": rng.random() < 0.5}
        self.documents.simulate(document)

    def _cell(self, rng: Random) -> str:
        if rng.random() < 0.9:
            return f"{rng.uniform(0.5, 3.5):.3f}"
        return rng.choice(("", "x", "nan", "inf", "1e11", "-1e11", "1e13", "1e300", "1_0", '"2"', '"', " 3 ", "0x1"))


class Faulty:
    """Goes wrong in each way that there is, to show that the harness finds it; which inputs do is in `HOW`."""

    HOW = ("well", "busy", "killed", "refused", "raises", "large")

    def __init__(self, folder: Path) -> None:
        self.said = "on purpose"

    def attempt(self, rng: Random) -> None:
        how = self.HOW[rng.randrange(len(self.HOW))]
        if how == "busy":
            while True:
                pass
        if how == "killed":
            os.kill(os.getpid(), signal.SIGKILL)
        if how == "refused":
            raise AmorsimError("no")
        if how == "raises":
            raise ZeroDivisionError
        if how == "large":
            bytearray(2 * 10**9)


class Maps:
    """Files of a format of maps, or of all but line worlds and bitmaps: damaged, with any options, and renamed."""

    def __init__(self, folder: Path, only: str = "") -> None:
        self.folder = folder
        self.only = only
        self.said = ""
        Image.new("L", (6, 5), 205).save(folder / "lab.pgm")

    def attempt(self, rng: Random) -> None:
        name = self.only or rng.choice(tuple(MAPS))
        if not self.only and name == "dxf" and rng.random() < 0.8:  # which takes a hundred times as long as others
            name = "svg"
        data = MAPS[name]
        if rng.random() < 0.9:
            data = damaged(data, rng, most=rng.choice((1, 3, 10)))
        if rng.random() < 0.2:  # a number that is too large, or none
            words = data.split(b" ")
            words[rng.randrange(len(words))] = str(rng.choice(EXTREMES))[:40].encode()
            data = b" ".join(words)
        ending = name if rng.random() < 0.95 else rng.choice(tuple(MAPS))
        path = self.folder / f"world.{ending}"
        path.write_bytes(data)
        cls, options = LOADERS[ending]
        chosen = {option: rng.choice(values) for option, values in options.items() if rng.random() < 0.3}
        self.said = f"{ending} {chosen} {data!r}"
        world = cls(**{"resolution": rng.choice((0.01, 0.05, 1.0)), **chosen}).load(path)
        world.cast_rays([[*world.origin[:2], 0.3]], [0.0, 1.0], 10.0)


FUZZERS: dict[str, Callable[[Path], Fuzzer]] = {
    "scenarios": Scenarios,
    "numbers": Numbers,
    "line_worlds": LineWorlds,
    "bitmaps": Bitmaps,
    "maps": Maps,
    **{name: functools.partial(Maps, only=name) for name in MAPS},
    "tracks": Tracks,
    **FOREIGN,
    **RECORDED,
    "api": Api,
    "faulty": Faulty,
}
