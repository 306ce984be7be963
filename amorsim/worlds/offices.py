"""Office floors: corridors, rooms on both sides of them, doors and furniture."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import attrs

from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.furniture import furnish
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Office"]

_WALL = 0.1  # [m]


class _Row(NamedTuple):
    """A row of rooms, from `low` to `high` - 1, whose doors lead up to a corridor, or down."""

    low: int
    high: int
    doors_up: bool


@attrs.frozen(kw_only=True)
class Office(CellWorld):
    """An office floor: corridors, rooms on both sides, doors that stand open, and furniture that leaves ways free."""

    size: tuple[float, float] = parameter((25.0, 15.0), unit="m", gt=0, le=10_000, help="width and height of the world")
    corridor: float = parameter(1.8, unit="m", gt=0, help="width of the corridors")
    room: float = parameter(4.0, unit="m", gt=0, help="width and depth of a room, about")
    door: float = parameter(1.0, unit="m", gt=0, help="width of the doors")
    side_doors: float = parameter(0.15, ge=0, le=1, help="share of the walls between two rooms that have a door")
    furniture: float = parameter(0.5, unit="1/m^2", ge=0, le=10, help="pieces of furniture tried per area of a room")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the floor. Raises `MapError` if there is no place for a corridor and a row of rooms on each side."""
        wall = self.in_cells(_WALL)
        corridor, door = self.need_passage("corridor", self.corridor), self.need_passage("door", self.door)
        least, room = door + 2, max(self.in_cells(self.room), door + 2)
        self.need_size(
            max(least, corridor) + 2 * wall,
            corridor + 2 * least + 4 * wall,
            "an office with a corridor and a row of rooms on each side",
        )
        height, width = sheet.cells.shape
        sheet.cells[:] = 1
        floors, rows = _layout(height, corridor, room, least, wall, numbers)
        for low in floors:
            sheet.fill(wall, low, width - wall, low + corridor, 0)
        sheet.start = (floors[0] + corridor / 2, wall + corridor / 2)
        ways = []  # left end of the way from each corridor to the next
        for low, high in itertools.pairwise(floors):
            first, last = 2 * wall + least, width - 2 * wall - corridor - least
            ways.append(numbers.between(first, last) if first <= last else wall)
            sheet.fill(ways[-1], low, ways[-1] + corridor, high, 0)
        for number, row in enumerate(rows):
            between = (number - 1) // 2  # rows 1 and 2 lie between corridors 0 and 1, and so on
            inner = [(wall, width - wall)]
            if 0 <= between < len(ways):
                inner = [(wall, ways[between] - wall), (ways[between] + corridor + wall, width - wall)]
            for left, right in inner:
                if right - left >= least:
                    self._rooms(sheet, numbers, row, _split(left, right, room, least, wall, numbers))

    def _rooms(self, sheet: Sheet, numbers: Numbers, row: _Row, rooms: list[tuple[int, int]]) -> None:
        wall, door = self.in_cells(_WALL), self.in_cells(self.door)
        doors: list[tuple[int, int, int, int]] = []  # col0, row0, col1, row1
        for number, (left, right) in enumerate(rooms):
            at = numbers.between(left + 1, right - 1 - door)
            doors.append(
                (at, row.high, at + door, row.high + wall) if row.doors_up else (at, row.low - wall, at + door, row.low)
            )
            if number and numbers.chance(self.side_doors):
                at = numbers.between(row.low + 1, row.high - 1 - door)
                doors.append((rooms[number - 1][1], at, left, at + door))
        for left, right in rooms:
            sheet.fill(left, row.low, right, row.high, 0)
        for each in doors:
            sheet.fill(*each, 0)
        for left, right in rooms:
            tries = int(self.furniture * (right - left) * (row.high - row.low) * self.resolution**2)
            furnish(sheet, numbers, (left, row.low, right, row.high), doors, tries, self.passage, self.resolution)


def _layout(
    height: int, corridor: int, room: int, least: int, wall: int, numbers: Numbers
) -> tuple[list[int], list[_Row]]:
    """The lowest cell of each corridor, and the rows of rooms: one below and one above each."""
    most = (height - wall) // (corridor + 2 * least + 3 * wall)
    count = max(1, min(most, int((height - wall) / (corridor + 2 * room + 3 * wall) + 0.5)))
    depth, left_over = divmod(height - count * corridor - (3 * count + 1) * wall, 2 * count)
    floors, rows = [], []
    low = 0
    for number in range(count):
        shift = min(int(0.15 * depth), depth - least)
        below = depth + numbers.between(-shift, shift)
        above = 2 * depth - below + (left_over if number == count - 1 else 0)
        rows.append(_Row(low + wall, low + wall + below, doors_up=True))
        floors.append(low + 2 * wall + below)
        low = floors[-1] + corridor
        rows.append(_Row(low + wall, low + wall + above, doors_up=False))
        low += wall + above
    return floors, rows


def _split(left: int, right: int, room: int, least: int, wall: int, numbers: Numbers) -> list[tuple[int, int]]:
    """Rooms side by side from `left` to `right` - 1: first and last column (exclusive) of each."""
    count = max(1, int((right - left + wall) / (room + wall) + 0.5))
    count = max(1, min(count, (right - left + wall) // (least + wall)))
    pitch = (right - left + wall) / count
    shift = max(0, min(int(0.2 * pitch), (int(pitch) - wall - least) // 2))
    cuts = [left - wall]
    cuts += [left - wall + int(number * pitch) + numbers.between(-shift, shift) for number in range(1, count)]
    return [(cut + wall, after) for cut, after in zip(cuts, [*cuts[1:], right], strict=True)]
