"""Draws the office that ships with amorsim; run it to write ``amorsim/scenarios/office.wld`` again.

The plan is in whole mm. Walls are bands with doors cut out of them; each edge of what remains is written with
the room that it faces, and the furniture of the room after it, every piece in a frame of its own.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path

import attrs
import shapely

__all__ = ["PLAN", "draw"]

OFFICE = Path(__file__).parents[1] / "amorsim" / "scenarios" / "office.wld"
WIDTH, HEIGHT = 24000, 16000
OUTER, INNER = 200, 60  # thickness of the outer walls; half that of the inner ones
# Where corridors and lobby open into each other over their whole width, as doors are written.
_OPEN_ENDS = (
    (4400, 4860, 4400, 6740),
    (4400, 9660, 4400, 11540),
    (18260, 6800, 20140, 6800),
    (18260, 9600, 20140, 9600),
)

Point = tuple[int, int]


@attrs.frozen
class Piece:
    """A piece of furniture: closed outlines in its own frame, and where that is: x, y [mm], turn [deg]."""

    name: str
    outlines: tuple[tuple[Point, ...], ...]
    x: int
    y: int
    turn: int = 0


@attrs.frozen
class Room:
    """A room: its box between the middles of walls, a place that is free, doors as (x1, y1, x2, y2)."""

    name: str
    box: tuple[int, int, int, int]
    place: Point
    doors: tuple[tuple[int, int, int, int], ...] = ()
    leaves: tuple[tuple[int, int, int, int], ...] = ()
    pieces: tuple[Piece, ...] = ()


def _box(width: int, depth: int, x: int = 0, y: int = 0) -> tuple[Point, ...]:
    """A rectangle around a point."""
    left, right, low, high = x - width // 2, x + width // 2, y - depth // 2, y + depth // 2
    return (left, low), (right, low), (right, high), (left, high)


def _round(radius: int, sides: int = 8, x: int = 0, y: int = 0) -> tuple[Point, ...]:
    """A regular polygon around a point, a side of it below."""
    angles = [2 * math.pi * (side + 0.5) / sides - math.pi / 2 for side in range(sides)]
    return tuple((x + round(radius * math.cos(a)), y + round(radius * math.sin(a))) for a in angles)


def _filling(name: str, left: int, low: int, right: int, high: int) -> Piece:
    """A piece that fills a rectangle of the plan."""
    middle = (left + right) // 2, (low + high) // 2
    return Piece(name, (_box(right - left, high - low),), *middle)


def _desk(x: int, y: int, turn: int, length: int = 1600, depth: int = 800) -> Piece:
    """A desk with its chair drawn up; the sitter's side is below before it is turned."""
    return Piece("desk", (_box(length, depth), _round(230, x=0, y=-depth // 2 - 100)), x, y, turn)


def _table_on_legs(x: int, y: int, turn: int, span: int) -> Piece:
    corners = [(i * span // 2, j * span // 2) for i in (-1, 1) for j in (-1, 1)]
    return Piece("table on four legs", tuple(_box(60, 60, *corner) for corner in corners), x, y, turn)


def _round_table(x: int, y: int, turn: int, radius: int, chairs: Sequence[int]) -> Piece:
    reach = radius + 90
    seats = [(round(reach * math.cos(math.radians(a))), round(reach * math.sin(math.radians(a)))) for a in chairs]
    outlines = (_round(radius, 16), *(_round(220, x=i, y=j) for i, j in seats))
    return Piece("round table", outlines, x, y, turn)


def _sofa(x: int, y: int, turn: int, length: int) -> Piece:
    end, seat = length // 2, length // 2 - 200
    outline = (
        (-end, -400),
        (end, -400),
        (end, 400),
        (seat, 400),
        (seat, -150),
        (-seat, -150),
        (-seat, 400),
        (-end, 400),
    )
    return Piece("sofa", (outline,), x, y, turn)


def _plant(x: int, y: int) -> Piece:
    return Piece("plant", (_round(180, 6),), x, y, 15)


def _pillar(x: int, y: int) -> Piece:
    return Piece("pillar", (_round(200, 12),), x, y)


_CONFERENCE_SEATS = [(i, j) for j in (-690, 690) for i in (-1100, -370, 370, 1100)] + [(-1690, 0), (1690, 0)]
_COUNTER = tuple(
    (round(1000 * math.cos(math.radians(angle))), round(1000 * math.sin(math.radians(angle))))
    for angle in range(90, 271, 15)
)
_CONFERENCE_TABLE = (
    (-1300, -600),
    (1300, -600),
    (1600, -300),
    (1600, 300),
    (1300, 600),
    (-1300, 600),
    (-1600, 300),
    (-1600, -300),
)
_L_BENCH = ((-1940, -350), (1940, -350), (1940, 3050), (1340, 3050), (1340, 350), (-1940, 350))
_CORNER_DESK = ((-970, 400), (-970, -400), (170, -400), (170, -1800), (970, -1800), (970, 400))
_MILL = ((-600, -520), (200, -520), (600, -120), (600, 520), (-600, 520))

PLAN = (
    Room(
        "Lobby",
        (0, 4800, 4400, 11600),
        (1700, 8200),
        pieces=(
            Piece("reception counter", (_COUNTER, _round(230, x=-330)), 4340, 8200),
            _sofa(600, 6400, -90, 2000),
            _sofa(600, 10250, -90, 1400),
            _pillar(2350, 6500),
            _pillar(2350, 9900),
            _plant(430, 5090),
            _plant(430, 11310),
        ),
    ),
    Room("South corridor", (4400, 4800, 24000, 6800), (11000, 5800), pieces=(_plant(23580, 6520),)),
    Room(
        "North corridor",
        (4400, 9600, 20200, 11600),
        (11000, 10600),
        pieces=(Piece("bench", (_box(1600, 400),), 14600, 9860), _plant(19930, 11330)),
    ),
    Room("Cross corridor", (18200, 6800, 20200, 9600), (19200, 8200)),
    Room(
        "Director",
        (0, 0, 4200, 4800),
        (3400, 3700),
        doors=((2900, 4800, 3900, 4800),),
        pieces=(
            _desk(2170, 2150, 20),
            _filling("cabinet", 300, 4290, 1900, 4740),
            _plant(430, 430),
        ),
    ),
    Room(
        "Office 1",
        (4200, 0, 8000, 4800),
        (6500, 3000),
        doors=((6600, 4800, 7600, 4800),),
        leaves=((7600, 4740, 7600, 3790),),
        pieces=(
            _desk(4660, 1000, 90),
            _desk(4660, 2600, 90),
            _filling("shelves", 7490, 200, 7940, 2600),
        ),
    ),
    Room(
        "Office 2",
        (8000, 0, 11800, 4800),
        (9400, 2500),
        doors=((8400, 4800, 9400, 4800),),
        leaves=((8400, 4740, 8400, 3790),),
        pieces=(
            _desk(10940, 2070, 0),
            _desk(10940, 2870, 180),
            _filling("cabinet", 8060, 200, 8510, 1800),
        ),
    ),
    Room(
        "Team room",
        (11800, 0, 16200, 4800),
        (14000, 4050),
        doors=((12200, 4800, 13300, 4800), (14800, 4800, 15800, 4800)),
        leaves=((15800, 4740, 15800, 3790),),
        pieces=(
            _desk(13650, 1000, -90, depth=700),
            _desk(14350, 1000, 90, depth=700),
            _desk(13650, 2600, -90, depth=700),
            _desk(14350, 2600, 90, depth=700),
        ),
    ),
    Room(
        "Laboratory",
        (16200, 0, 20200, 4800),
        (17600, 4000),
        doors=((16600, 4800, 17650, 4800),),
        pieces=(
            Piece("bench", (_L_BENCH,), 18200, 550),
            _table_on_legs(17900, 2600, 0, 1120),
        ),
    ),
    Room(
        "Library",
        (20200, 0, 24000, 4800),
        (20800, 3900),
        doors=((21500, 4800, 22550, 4800),),
        pieces=(
            _filling("shelves", 21400, 1250, 23800, 1650),
            _filling("shelves", 21400, 2700, 23800, 3100),
        ),
    ),
    Room(
        "Small meeting room",
        (0, 11600, 4400, 16000),
        (700, 12400),
        doors=((1600, 11600, 2600, 11600),),
        pieces=(_round_table(2270, 13720, 9, 600, range(0, 360, 72)), _plant(430, 15570)),
    ),
    Room(
        "Office 3",
        (4400, 11600, 8000, 16000),
        (6000, 13000),
        doors=((4800, 11600, 5750, 11600),),
        leaves=((4800, 11660, 4800, 12560),),
        pieces=(
            Piece("corner desk", (_CORNER_DESK, _round(230, x=-60, y=-640)), 6970, 15400),
            _filling("cabinet", 4460, 13600, 4910, 15800),
            _plant(7720, 11880),
        ),
    ),
    Room(
        "Office 4",
        (8000, 11600, 11600, 16000),
        (10000, 12700),
        doors=((10300, 11600, 11300, 11600),),
        leaves=((11300, 11660, 11300, 12610),),
        pieces=(
            Piece(
                "desk",
                (
                    _box(1600, 800),
                    _round(230, y=500),
                    _round(220, x=-380, y=-560),
                    _round(220, x=380, y=-560),
                ),
                9000,
                14860,
                45,
            ),
            _filling("cabinet", 11090, 13800, 11540, 15800),
        ),
    ),
    Room(
        "Open-plan office",
        (11600, 11600, 17600, 16000),
        (15600, 13800),
        doors=((12000, 11600, 13100, 11600), (16100, 11600, 17100, 11600)),
        pieces=(
            _desk(13370, 13700, -90, 1400, 700),
            _desk(14070, 13700, 90, 1400, 700),
            _desk(13370, 15100, -90, 1400, 700),
            _desk(14070, 15100, 90, 1400, 700),
            _desk(17190, 13700, -90, 1400, 700),
            _desk(17190, 15100, -90, 1400, 700),
        ),
    ),
    Room(
        "Conference room",
        (17600, 11600, 24000, 16000),
        (23200, 12200),
        doors=((18200, 11600, 19300, 11600),),
        leaves=((18200, 11660, 18200, 12710),),
        pieces=(
            Piece(
                "conference table",
                (_CONFERENCE_TABLE, *(_round(220, x=i, y=j) for i, j in _CONFERENCE_SEATS)),
                20730,
                13730,
            ),
            _plant(23570, 15570),
        ),
    ),
    Room(
        "Store",
        (4400, 6800, 6800, 9600),
        (5700, 7700),
        doors=((5100, 6800, 6100, 6800),),
        pieces=(
            _filling("shelves", 4460, 9090, 6740, 9540),
            _filling("shelves", 4460, 7000, 4910, 9090),
            Piece("box", (_box(420, 380),), 6440, 8790, 20),
        ),
    ),
    Room(
        "Printers",
        (6800, 6800, 9400, 9600),
        (8100, 8500),
        doors=((7600, 9600, 8600, 9600),),
        pieces=(_filling("copier", 6960, 6860, 7660, 7510), _filling("table", 7800, 6860, 9340, 7460)),
    ),
    Room(
        "Kitchen",
        (9400, 6800, 13400, 9600),
        (11200, 7900),
        doors=((9900, 6800, 10950, 6800), (11800, 9600, 12850, 9600)),
        pieces=(
            _filling("fridge", 9460, 8860, 10140, 9540),
            _filling("counter", 10140, 8940, 11500, 9540),
            _round_table(12540, 7620, 0, 450, (60, 180, 300)),
        ),
    ),
    Room(
        "Washroom",
        (13400, 6800, 15800, 9600),
        (14400, 7500),
        doors=((14100, 6800, 15100, 6800),),
        pieces=(
            *(_filling("stall, shut", left, 8140, left + 760, 9540) for left in (13460, 14220, 14980)),
            _filling("basins", 15290, 6940, 15740, 7940),
        ),
    ),
    Room(
        "Servers",
        (15800, 6800, 18200, 9600),
        (17500, 8200),
        doors=((18200, 7700, 18200, 8700),),
        pieces=tuple(_filling("rack", 15860, low, 16860, low + 600) for low in range(7000, 9400, 600)),
    ),
    Room(
        "Workshop",
        (20200, 6800, 24000, 11600),
        (21700, 8500),
        doors=((20200, 8000, 20200, 9050),),
        pieces=(
            _filling("workbench", 23000, 6860, 23800, 10200),
            Piece("milling machine", (_MILL,), 23200, 11020),
            Piece("pallet", (_box(1000, 800),), 20900, 10950, 25),
        ),
    ),
)
"""The rooms and corridors of the office; a door is listed with the room it belongs to."""


def draw() -> str:
    """The text of the office's line world."""
    lines = [
        "; An office of 24 m x 16 m, drawn for amorsim by tools/draw_office.py (change it there).",
        "; Lengths in mm, angles in degrees; a push turns clockwise.",
        "",
        f"width {WIDTH}",
        f"height {HEIGHT}",
        "",
        "; inside the entrance, facing the reception",
        "position 1400 8200 0",
        "",
        "; the building from outside",
        *_edges(_box(WIDTH, HEIGHT, WIDTH // 2, HEIGHT // 2)),
    ]
    faces = _faces()
    for room in PLAN:
        left, low, right, high = room.box
        lines += [
            "",
            f";; {room.name}, {(right - left) / 1000:.1f} m x {(high - low) / 1000:.1f} m, "
            f"free at {room.place[0]} {room.place[1]}",
            *faces[room.name],
        ]
        for leaf in room.leaves:
            lines.append("{} {} {} {}  ; door leaf, open".format(*leaf))
        for piece in room.pieces:
            lines += ["", f"push {piece.x} {piece.y} {-piece.turn}  ; {piece.name}"]
            for outline in piece.outlines:
                lines += _edges(outline)
            lines.append("pop")
    return "\n".join(lines) + "\n"


def _edges(outline: Sequence[Point]) -> list[str]:
    """The sides of a closed outline, a statement each."""
    ends = [*outline[1:], outline[0]]
    return [f"{x1} {y1} {x2} {y2}" for (x1, y1), (x2, y2) in zip(outline, ends, strict=True)]


def _faces() -> dict[str, list[str]]:
    """The edges of the walls that face each room; a door's jambs go with the room of the door."""
    inside = shapely.box(OUTER, OUTER, WIDTH - OUTER, HEIGHT - OUTER)
    floors = {}
    for room in PLAN:
        floor = shapely.box(*room.box).buffer(-INNER, join_style="mitre").intersection(inside)
        floors[room.name] = shapely.union_all([floor, *map(_doorway, room.doors)])
    free = shapely.union_all([*floors.values(), *map(_doorway, _OPEN_ENDS)])
    faces: dict[str, list[str]] = {room.name: [] for room in PLAN}
    for ring in (free.exterior, *free.interiors):
        corners = [(round(x), round(y)) for x, y in ring.simplify(0).coords]
        for (x1, y1), (x2, y2) in itertools.pairwise(corners):
            middle = shapely.Point((x1 + x2) / 2, (y1 + y2) / 2)
            owner = min(floors, key=lambda name: float(middle.distance(floors[name])))
            faces[owner].append(f"{x1} {y1} {x2} {y2}")
    return faces


def _doorway(door: tuple[int, int, int, int]) -> shapely.Polygon:
    """What a door leaves open in the wall that it is in."""
    x1, y1, x2, y2 = door
    across, along = (INNER, 0) if x1 == x2 else (0, INNER)
    return shapely.box(x1 - across, y1 - along, x2 + across, y2 + along)


if __name__ == "__main__":
    OFFICE.write_text(draw(), encoding="utf-8", newline="\n")
