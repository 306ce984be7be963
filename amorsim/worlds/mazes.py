"""Mazes of square cells."""

from __future__ import annotations

import attrs

from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Maze"]

_STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))  # (row, column)


@attrs.frozen(kw_only=True)
class Maze(CellWorld):
    """A maze of square cells, made by a random walk that turns back at dead ends; loops open some of the walls left."""

    size: tuple[float, float] = parameter((12.0, 9.0), unit="m", gt=0, le=10_000, help="width and height of the world")
    corridor: float = parameter(1.1, unit="m", gt=0, help="width of the ways")
    wall: float = parameter(0.1, unit="m", gt=0, help="thickness of the walls")
    loops: float = parameter(0.0, ge=0, le=1, help="share of the other walls that are opened; 0 for one way only")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the maze; corridors are a little wider where the size leaves room."""
        corridor, wall = self.need_passage("corridor", self.corridor), self.in_cells(self.wall)
        pitch = corridor + wall
        self.need_size(pitch + wall, pitch + wall, "a maze of one cell")
        rows, cols = ((count - wall) // pitch for count in sheet.cells.shape)
        # The lower or left border of each wall, the first and the last included.
        up, right = (
            [number * (cells - wall) // count for number in range(count + 1)]
            for cells, count in zip(sheet.cells.shape, (rows, cols), strict=True)
        )
        sheet.cells[:] = 1
        for row in range(rows):
            for col in range(cols):
                sheet.fill(right[col] + wall, up[row] + wall, right[col + 1], up[row + 1], 0)
        for row, col, is_up in _openings(rows, cols, numbers, self.loops):
            if is_up:
                sheet.fill(right[col] + wall, up[row + 1], right[col + 1], up[row + 1] + wall, 0)
            else:
                sheet.fill(right[col + 1], up[row] + wall, right[col + 1] + wall, up[row + 1], 0)
        sheet.start = (wall + corridor / 2, wall + corridor / 2)


def _openings(rows: int, cols: int, numbers: Numbers, loops: float) -> list[tuple[int, int, bool]]:
    """The walls that are opened: the cell below or left of each, and whether it is the wall above that cell."""
    opened: set[tuple[int, int, bool]] = set()
    seen = {(0, 0)}
    way = [(0, 0)]
    while way:
        row, col = way[-1]
        ahead = [
            (row + up, col + right)
            for up, right in _STEPS
            if 0 <= row + up < rows and 0 <= col + right < cols and (row + up, col + right) not in seen
        ]
        if not ahead:
            way.pop()
            continue
        following = ahead[numbers.below(len(ahead))]
        seen.add(following)
        way.append(following)
        opened.add((min(row, following[0]), min(col, following[1]), col == following[1]))
    every = [(row, col, True) for row in range(rows - 1) for col in range(cols)]
    every += [(row, col, False) for row in range(rows) for col in range(cols - 1)]
    return [each for each in every if each in opened or (loops > 0.0 and numbers.chance(loops))]
