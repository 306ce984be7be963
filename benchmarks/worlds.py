"""The worlds of the benchmarks, built the same every time: nothing is read from files."""

from __future__ import annotations

import functools
import math
from pathlib import Path

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = [
    "HALL",
    "World",
    "bitmap_room",
    "city",
    "city_walls",
    "furnished_office",
    "line_room",
    "office",
    "office_with_hall",
    "open_field",
    "places",
    "room_walls",
    "write_wld",
]

Array = npt.NDArray[np.float64]
Cells = npt.NDArray[np.uint8]

OFFICE_CELL = 0.05  # m
_ROOM = 5.0  # m, from wall to wall in the office
_DOOR = 1.2  # m


@attrs.frozen(kw_only=True, eq=False)
class World:
    """A world as each side wants it; its lower left corner is the origin.

    `walls` `(M, 4)` [m] are line segments; of a bitmap, the borders between its free and occupied cells.
    """

    name: str
    map: am.Map
    walls: Array

    @property
    def size(self) -> tuple[float, float]:
        """Width and height [m]."""
        return self.map.size

    @functools.cached_property
    def cells(self) -> Cells:
        """`(rows, cols)`, row 0 lowest, 1 where occupied."""
        return self.map.to_array()


def room_walls() -> Array:
    """The 40 walls `(40, 4)` [m] of a room of 10 m x 10 m: its sides, six pillars, and twelve screens askew."""
    walls = _rectangle(0.0, 0.0, 10.0, 10.0)
    for x, y in ((2.0, 2.2), (5.1, 1.9), (8.0, 2.4), (2.3, 7.6), (4.8, 8.1), (7.9, 7.5)):
        walls += _rectangle(x - 0.2, y - 0.15, x + 0.2, y + 0.15)
    for k in range(12):
        x, y = 1.6 + 2.2 * (k % 4), 3.6 + 1.4 * (k // 4)
        angle = 0.35 + 0.9 * k
        dx, dy = 0.3 * math.cos(angle), 0.3 * math.sin(angle)
        walls.append((x - dx, y - dy, x + dx, y + dy))
    return np.array(walls)


@functools.cache
def line_room(resolution: float = 0.001) -> World:
    """The room of `room_walls` as a line world."""
    walls = room_walls()
    room = am.Map.from_segments(walls, resolution=resolution, extent=(0.0, 0.0, 10.0, 10.0))
    return World(name=f"room of 40 lines, {1000 * resolution:g} mm", map=room, walls=walls)


@functools.cache
def bitmap_room() -> World:
    """The same cells of 1 mm as in `line_room`, but without the lines that they came from."""
    lines = line_room()
    return World(
        name="the same room as a bitmap, 1 mm",
        map=am.Map.from_array(lines.cells, resolution=lines.map.resolution),
        walls=lines.walls,
    )


@functools.cache
def office(side: float = 50.0) -> World:
    """A square bitmap of 5 cm cells: rooms of 5 m with a door in every wall and a cupboard in every other one."""
    n, room, door = round(side / OFFICE_CELL), round(_ROOM / OFFICE_CELL), round(_DOOR / OFFICE_CELL)
    cells = np.zeros((n, n), dtype=np.uint8)
    cells[::room] = cells[:, ::room] = cells[-1] = cells[:, -1] = 1
    draw = np.random.default_rng(20261121)
    for low in range(0, n, room):
        for left in range(0, n, room):
            up, along = draw.integers(10, room - door - 10, size=2)
            if left and low + up + door < n - 1:
                cells[low + up : low + up + door, left] = 0
            if low and left + along + door < n - 1:
                cells[low, left + along : left + along + door] = 0
            if (low + left) // room % 2:
                y, x = draw.integers(25, room - 45, size=2)
                cells[low + y : low + y + 20, left + x : left + x + 12] = 1
    return World(
        name=f"office of {side:.3g} m, 5 cm",
        map=am.Map.from_array(cells, resolution=OFFICE_CELL),
        walls=_borders(cells, OFFICE_CELL),
    )


@functools.cache
def furnished_office(side: float = 50.0) -> World:
    """The office with walls of 15 cm, and in the middle of each room two desks and six round stools about them."""
    bare = office(side).cells
    cells = bare.copy()
    cells[1:] |= bare[:-1]
    cells[:-1] |= bare[1:]
    thick = cells.copy()
    cells[:, 1:] |= thick[:, :-1]
    cells[:, :-1] |= thick[:, 1:]
    n, room = len(cells), round(_ROOM / OFFICE_CELL)
    up, across = np.ogrid[-4:5, -4:5]
    stool = up * up + across * across <= 18
    draw = np.random.default_rng(20261123)
    for low in range(0, n, room):
        for left in range(0, n, room):
            for desk in (0, 1):
                y, x = low + 28 + 28 * desk + draw.integers(0, 4), left + 30 + draw.integers(0, 8)
                cells[y : y + 16, x : x + 32] = 1
                for y0, x0 in ((y - 6, x + 6), (y + 22, x + 24), (y + 8, x - 6 + 44 * desk)):
                    cells[y0 - 4 : y0 + 5, x0 - 4 : x0 + 5] |= stool
    return World(
        name=f"furnished office of {side:.3g} m, 5 cm",
        map=am.Map.from_array(cells, resolution=OFFICE_CELL),
        walls=_borders(cells, OFFICE_CELL),
    )


HALL = (10.0, 10.0, 40.0, 40.0)
"""Of `office_with_hall` [m]: least x and y, most x and y."""


@functools.cache
def office_with_hall() -> World:
    """The office of 50 m with a hall in place of thirty-six rooms, where cars can turn."""
    cells = office().cells.copy()
    low, end = round(HALL[0] / OFFICE_CELL), round(HALL[2] / OFFICE_CELL)
    cells[low + 1 : end, low + 1 : end] = 0
    return World(
        name="office of 50 m with a hall, 5 cm",
        map=am.Map.from_array(cells, resolution=OFFICE_CELL),
        walls=_borders(cells, OFFICE_CELL),
    )


@functools.cache
def open_field(side: float = 30.0) -> World:
    """A square field with a fence around it, and nothing else, in cells of 5 cm."""
    fence = np.array(_rectangle(0.0, 0.0, side, side))
    field = am.Map.from_segments(fence, resolution=OFFICE_CELL, extent=(0.0, 0.0, side, side))
    return World(name=f"open field of {side:.3g} m", map=field, walls=fence)


def city_walls(side: float) -> Array:
    """The walls `(M, 4)` [m] of a square of `side`: its four sides, and houses of 10 m x 10 m, turned.

    A square of 1 km has 400 houses and so 20 km of walls; smaller ones are as densely built.
    """
    draw = np.random.default_rng(20261122)
    count = round(20.0 * side / 1000.0)
    walls = _rectangle(0.0, 0.0, side, side)
    for k in range(count * count):
        middle = (np.array([k % count, k // count]) + 0.5) * (side / count) + draw.uniform(-10.0, 10.0, 2)
        angle = draw.uniform(0.0, math.pi / 2.0)
        turns = angle + math.pi / 4.0 + math.pi / 2.0 * np.arange(5)
        corners = middle + 5.0 * math.sqrt(2.0) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
        walls += [(*a, *b) for a, b in zip(corners[:-1].tolist(), corners[1:].tolist(), strict=True)]
    return np.array(walls)


def city(side: float) -> World:
    """The city of `city_walls` in cells of 1 mm."""
    walls = city_walls(side)
    return World(name=f"city of {side:g} m, 1 mm", map=am.Map.from_segments(walls), walls=walls)


def places(world: World, count: int, clearance: float, apart: float = 0.0, seed: int = 1) -> Array:
    """Poses `(count, 3)` drawn at random, `clearance` [m] away from all that is occupied, and `apart` from others.

    Raises
    ------
    ValueError
        If there is no room for that many.
    """
    draw = np.random.default_rng(seed)
    width, height = world.size
    # Twelve rings of 64: the corner of a 5 cm wall does not slip between them.
    turns = np.linspace(0.0, 2.0 * math.pi, 65)[:-1]
    rings = [ring / 12.0 * clearance * np.stack([np.cos(turns), np.sin(turns)], axis=1) for ring in range(1, 13)]
    offsets = np.concatenate([[(0.0, 0.0)], *rings])
    side = max(apart, 1e-3)
    taken: dict[tuple[int, int], list[tuple[float, float]]] = {}
    found: list[tuple[float, float]] = []
    # Enough draws for any count that leaves fair room between, and soon an error for one that does not.
    for _ in range(8 + count // 160):
        points = draw.uniform((0.0, 0.0), (width, height), size=(1024, 2))
        free = ~world.map.occupied((points[:, None] + offsets).reshape(-1, 2)).reshape(len(points), -1).any(axis=1)
        for x, y in points[free].tolist():
            i, j = int(x // side), int(y // side)
            near = [p for a in (i - 1, i, i + 1) for b in (j - 1, j, j + 1) for p in taken.get((a, b), ())]
            if apart and any((x - a) ** 2 + (y - b) ** 2 < apart**2 for a, b in near):
                continue
            taken.setdefault((i, j), []).append((x, y))
            found.append((x, y))
            if len(found) == count:
                return np.column_stack([np.array(found), draw.uniform(-math.pi, math.pi, count)])
    raise ValueError(f"{world.name}: room for {len(found)} of {count} places with {clearance} m around them")


def write_wld(walls: Array, side: float, path: Path) -> None:
    """Write the walls `(M, 4)` [m] of a square as a `.wld` file, in whole millimetres."""
    lines = [f"width {1000.0 * side:.0f}", f"height {1000.0 * side:.0f}"]
    lines += [" ".join(f"{value:.0f}" for value in 1000.0 * wall) for wall in walls]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> list[tuple[float, float, float, float]]:
    return [(x0, y0, x1, y0), (x1, y0, x1, y1), (x1, y1, x0, y1), (x0, y1, x0, y0)]


def _borders(cells: Cells, side: float) -> Array:
    """Straight pieces `(M, 4)` [m] of the border between free and occupied cells."""
    found: list[tuple[float, float, float, float]] = []
    for turned in (False, True):
        array = cells.T if turned else cells
        for line in range(1, len(array)):
            change = np.concatenate([[0], (array[line] != array[line - 1]).astype(np.int8), [0]])
            starts, ends = np.flatnonzero(np.diff(change) == 1), np.flatnonzero(np.diff(change) == -1)
            for a, b in zip((starts * side).tolist(), (ends * side).tolist(), strict=True):
                at = line * side
                found.append((at, a, at, b) if turned else (a, at, b, at))
    return np.array(found)
