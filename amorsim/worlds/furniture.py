"""Furniture in a rectangular room, placed so that the robot passes between all pieces."""

from __future__ import annotations

from amorsim.worlds.cells import Sheet
from amorsim.worlds.passable import cells_of
from amorsim.worlds.random_numbers import Numbers

__all__ = ["furnish"]

Box = tuple[int, int, int, int]
"""First column, first row, last column and last row (both exclusive)."""

_PIECES = ((1.4, 0.7), (1.0, 0.45), (1.8, 0.45), (0.8, 0.8), (1.6, 0.9), (0.5, 0.5))  # length and depth [m]
_STANDING = 0.25  # share of pieces that stand free, not at a wall


def furnish(
    sheet: Sheet, numbers: Numbers, room: Box, doors: list[Box], tries: int, passage: int, resolution: float
) -> None:
    """Put furniture into a room, as many pieces as find a place in a number of tries.

    Pieces touch a wall or are at least `passage` cells away from it, and as far from each other. So a robot that needs
    such a passage gets around all of them. The places inside the doors stay free.
    """
    # A robot comes in by its passage, and half a passage more for the turn.
    kept = [_grown(door, passage) for door in doors if _overlap(_grown(door, 1), room)]
    kept = [_grown(each, passage // 2) for each in kept]
    pieces: list[Box] = []
    for _ in range(tries):
        length, depth = _PIECES[numbers.below(len(_PIECES))]
        piece = _place(numbers, room, cells_of(length, resolution), cells_of(depth, resolution))
        if piece is None or not _keeps_walls(piece, room, passage):
            continue
        around = _grown(piece, passage)
        if not any(_overlap(piece, each) for each in kept) and not any(_overlap(around, each) for each in pieces):
            pieces.append(piece)
            sheet.fill(*piece)


def _place(numbers: Numbers, room: Box, length: int, depth: int) -> Box | None:
    """A place for a piece, with its back to a wall or free; None if it is larger than the room."""
    col0, row0, col1, row1 = room
    side = numbers.below(4)  # below, above, left, right
    stands = numbers.chance(_STANDING)
    wide, high = (length, depth) if side < 2 else (depth, length)
    if wide > col1 - col0 or high > row1 - row0:
        return None
    col, row = numbers.between(col0, col1 - wide), numbers.between(row0, row1 - high)
    if not stands:
        row = row0 if side == 0 else row1 - high if side == 1 else row
        col = col0 if side == 2 else col1 - wide if side == 3 else col
    return col, row, col + wide, row + high


def _keeps_walls(piece: Box, room: Box, passage: int) -> bool:
    gaps = (piece[0] - room[0], piece[1] - room[1], room[2] - piece[2], room[3] - piece[3])
    return all(gap == 0 or gap >= passage for gap in gaps) and (max(gaps[0], gaps[2]) > 0 and max(gaps[1], gaps[3]) > 0)


def _grown(box: Box, by: int) -> Box:
    return box[0] - by, box[1] - by, box[2] + by, box[3] + by


def _overlap(one: Box, other: Box) -> bool:
    return one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3]
