"""Draws the maps of the scenarios that move: a concourse for a crowd, an arena for a swarm, rooms with doors.

Run it to write ``amorsim/scenarios/*.wld`` again; lengths are in whole mm::

    python tools/draw_halls.py
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path

__all__ = ["HALLS", "arena", "concourse", "rooms"]

SCENARIOS = Path(__file__).parents[1] / "amorsim" / "scenarios"

Point = tuple[int, int]


def _box(left: int, low: int, right: int, high: int) -> tuple[Point, ...]:
    return (left, low), (right, low), (right, high), (left, high)


def _round(x: int, y: int, radius: int, sides: int = 16) -> tuple[Point, ...]:
    angles = [2 * math.pi * (side + 0.5) / sides for side in range(sides)]
    return tuple((x + round(radius * math.cos(a)), y + round(radius * math.sin(a))) for a in angles)


def _lines(outlines: Iterable[Sequence[Point]]) -> list[str]:
    return [
        f"{x1} {y1} {x2} {y2}"
        for outline in outlines
        for (x1, y1), (x2, y2) in zip(outline, [*outline[1:], outline[0]], strict=True)
    ]


def _world(title: str, width: int, height: int, outlines: Iterable[Sequence[Point]]) -> str:
    head = [
        f"; {title}, drawn for amorsim by tools/draw_halls.py (change it there). Lengths in mm.",
        f"width {width}",
        f"height {height}",
    ]
    return "\n".join([*head, *_lines([_box(0, 0, width, height), *outlines])]) + "\n"


def concourse() -> str:
    """A concourse with pillars, two kiosks and benches."""
    pillars = [_round(x, y, 300) for x in (5000, 10000, 15000, 20000) for y in (4200, 8800)]
    kiosks = [_box(7000, 6000, 8200, 7000), _box(16600, 6000, 17800, 7000)]
    benches = [_box(2600, 6300, 3000, 6700), _box(11800, 300, 13200, 700), _box(11800, 12300, 13200, 12700)]
    return _world("A concourse of 25 m x 13 m", 25000, 13000, [*pillars, *kiosks, *benches])


def arena() -> str:
    """A square arena with nine blocks in it."""
    blocks = [_box(x - 700, y - 700, x + 700, y + 700) for x in (5000, 12000, 19000) for y in (5000, 12000, 19000)]
    return _world("An arena of 24 m x 24 m", 24000, 24000, blocks)


def rooms() -> str:
    """Four rooms on a corridor, with doorways of 1.1 m in walls of 100 mm."""
    walls = []
    for y in (3000, 5000):
        at = 0
        for door in (1500, 7500):
            walls.append(_box(at, y - 50, door, y + 50))
            at = door + 1100
        walls.append(_box(at, y - 50, 12000, y + 50))
    across = [_box(5950, 0, 6050, 2950), _box(5950, 5050, 6050, 8000)]
    return _world("Four rooms on a corridor, 12 m x 8 m", 12000, 8000, [*walls, *across])


HALLS = {"concourse": concourse, "arena": arena, "rooms": rooms}
"""What is drawn, by the name of its file."""


if __name__ == "__main__":
    for name, draw in HALLS.items():
        (SCENARIOS / f"{name}.wld").write_text(draw(), encoding="utf-8", newline="\n")
