"""Draws the worlds of the scenarios that ship, but for the office; run it to write them again.

``car-park.wld``, ``hall.wld``, ``maze.wld`` and ``yard.wld`` in ``amorsim/scenarios``. All lengths are whole mm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

__all__ = ["WORLDS", "draw"]

FOLDER = Path(__file__).parents[1] / "amorsim" / "scenarios"

Line = tuple[int, int, int, int]


def _chain(*points: tuple[int, int], closed: bool = False) -> list[Line]:
    """Lines from point to point."""
    ends = [*points[1:], points[0]] if closed else points[1:]
    return [(*a, *b) for a, b in zip(points, ends, strict=False)]


def _box(left: int, low: int, right: int, high: int) -> list[Line]:
    return _chain((left, low), (right, low), (right, high), (left, high), closed=True)


def _column(x: int, y: int, radius: int) -> list[Line]:
    """An octagonal column about a point, flat sides along the axes."""
    half = round(radius * 0.41421)
    corners = [(half, -radius), (radius, -half), (radius, half), (half, radius)]
    corners += [(-a, -b) for a, b in corners]
    return _chain(*((x + a, y + b) for a, b in corners), closed=True)


def _part(title: str, lines: Sequence[Line]) -> list[str]:
    return [f";; {title}", *(" ".join(map(str, line)) for line in lines), ""]


def _parked(x: int, y: int) -> list[Line]:
    """A parked car, 4.3 m by 1.76 m, about a point, its corners cut: nose and tail look up or down."""
    points = [(620, -2150), (880, -1800), (880, 1850), (560, 2150)]
    left = [(-a, b) for a, b in reversed(points)]
    return _chain(*((x + a, y + b) for a, b in (*points, *left)), closed=True)


def car_park() -> str:
    """Bays along two walls and on an island between two aisles; four of them at the top left are empty."""
    width, height, bay = 45000, 35000, 3000
    out = [
        ";; A car park: draw it anew with tools/draw_worlds.py",
        f"width {width}",
        f"height {height}",
        "position 4000 8500 0",
        "",
    ]
    out += _part("walls", _box(0, 0, width, height))
    out += _part("the kerb of the island", _box(9000, 12000, 36000, 22000))
    for title, y, free in (
        ("bays below", 2800, {3, 4, 9}),
        ("bays above", 32200, {4, 5, 6, 7, 12}),
    ):
        for i in range(14):
            if i not in free:
                out += _part(f"{title}, {i + 1}", _parked(3000 + bay // 2 + i * (bay - 200), y))
    for i in range(9):
        for y in (14600, 19400):
            if (i, y) not in ((2, 14600), (6, 19400)):
                out += _part(f"on the island, {i + 1}", _parked(10500 + i * bay, y))
    return "\n".join(out)


def hall() -> str:
    """A hall with columns, two niches and a counter."""
    width, height = 20000, 14000
    out = [";; A hall: draw it anew with tools/draw_worlds.py", f"width {width}", f"height {height}"]
    out += ["position 3000 3000 0", ""]
    outline = [
        (0, 0),
        (8000, 0),
        (8000, 900),
        (12000, 900),
        (12000, 0),
        (width, 0),
        (width, 9000),
        (19200, 9000),
        (19200, 12000),
        (width, 12000),
        (width, height),
        (0, height),
    ]
    out += _part("walls", _chain(*outline, closed=True))
    for i in range(3):
        for j in range(2):
            out += _part("column", _column(5000 + 5000 * i, 5000 + 4000 * j, 450))
    out += _part("counter", _chain((900, 11200), (3800, 11200), (3800, 11900), (900, 11900), closed=True))
    return "\n".join(out)


def maze() -> str:
    """A maze on a table of 1 m: two rings with gaps, stubs that turn a robot that goes round, and a core."""
    out = [";; A maze on a table: draw it anew with tools/draw_worlds.py", "width 1000", "height 1000"]
    out += ["position 110 110 90", ""]
    out += _part("rim", _box(0, 0, 1000, 1000))
    walls = [
        ((220, 400), (220, 220), (620, 220)),
        ((780, 220), (780, 560)),
        ((780, 720), (780, 780), (420, 780)),
        ((260, 780), (220, 780), (220, 560)),
        ((400, 400), (480, 400)),
        ((400, 400), (400, 560), (460, 620)),
        ((640, 380), (640, 600)),
        ((0, 500), (60, 500)),
        ((540, 1000), (540, 930)),
        ((1000, 380), (930, 380)),
        ((480, 0), (480, 60)),
        ((0, 900), (100, 1000)),
        ((900, 1000), (1000, 900)),
        ((1000, 110), (890, 0)),
    ]
    for wall in walls:
        out += _part("wall", _chain(*wall))
    return "\n".join(out)


def yard() -> str:
    """A yard around a shed, in two halves with a fence between them; a gate on either side of the shed."""
    width, height = 24000, 16000
    out = [";; A yard: draw it anew with tools/draw_worlds.py", f"width {width}", f"height {height}"]
    out += ["position 5000 3000 0", ""]
    out += _part("walls", _box(0, 0, width, height))
    out += _part("shed", _box(8000, 5500, 16000, 10500))
    for left, right in ((0, 2400), (5000, 8000), (16000, 18600), (21200, width)):
        out += _part("fence", _box(left, 7950, right, 8050))
    out += _part("pile of pallets", _chain((500, 14000), (1700, 14400), (1400, 15500), (500, 15500), closed=True))
    return "\n".join(out)


WORLDS: dict[str, Callable[[], str]] = {
    "car-park.wld": car_park,
    "hall.wld": hall,
    "maze.wld": maze,
    "yard.wld": yard,
}


def draw(name: str) -> str:
    """The text of a world's file."""
    return WORLDS[name]().rstrip("\n") + "\n"


if __name__ == "__main__":
    for world in WORLDS:
        (FOLDER / world).write_text(draw(world), encoding="utf-8")
