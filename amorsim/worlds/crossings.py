"""Streets that cross, between buildings."""

from __future__ import annotations

import attrs

from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Crossing"]

_SETBACK = 0.15  # of a block's side, the most that a building stands back from the street


@attrs.frozen(kw_only=True)
class Crossing(CellWorld):
    """Streets that cross at right angles, and buildings between them, some with yards that open to a street."""

    size: tuple[float, float] = parameter((40.0, 30.0), unit="m", gt=0, le=10_000, help="width and height of the world")
    street: float = parameter(4.0, unit="m", gt=0, help="width of the streets")
    along: int = parameter(2, ge=1, le=1000, help="streets from left to right")
    across: int = parameter(2, ge=1, le=1000, help="streets from bottom to top")
    yards: float = parameter(0.3, ge=0, le=1, help="share of the buildings that have a yard")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the buildings; streets end at the border of the world."""
        street = self.need_passage("street", self.street)
        rows, cols = sheet.cells.shape
        # Blocks of at least four cells.
        need = [count * street + 4 * (count + 1) for count in (self.across, self.along)]
        self.need_size(need[0], need[1], f"{self.across} streets across {self.along}")
        low, left = _blocks(rows, self.along, street, numbers), _blocks(cols, self.across, street, numbers)
        for row0, row1 in low:
            for col0, col1 in left:
                self._building(sheet, numbers, (col0, row0, col1, row1))
        sheet.start = ((low[0][1] + low[1][0]) / 2, (left[0][1] + left[1][0]) / 2)

    def _building(self, sheet: Sheet, numbers: Numbers, block: tuple[int, int, int, int]) -> None:
        rows, cols = sheet.cells.shape
        col0, row0, col1, row1 = block
        width, height = int(_SETBACK * (col1 - col0)), int(_SETBACK * (row1 - row0))
        # At the world's border nothing is behind the building.
        col0, col1 = col0 + (col0 > 0) * numbers.between(0, width), col1 - (col1 < cols) * numbers.between(0, width)
        row0, row1 = row0 + (row0 > 0) * numbers.between(0, height), row1 - (row1 < rows) * numbers.between(0, height)
        sheet.fill(col0, row0, col1, row1)
        if not numbers.chance(self.yards):
            return
        # A yard is open towards a street: above the building, or below one that is at the world's upper border.
        wide, deep = (col1 - col0) // 2, (row1 - row0) // 2
        if min(wide, deep) < self.passage:
            return
        left = numbers.between(col0 + wide // 4, col1 - wide - wide // 4)
        low = row1 - deep if row1 < rows else row0
        sheet.fill(left, low, left + wide, low + deep, 0)


def _blocks(cells: int, streets: int, street: int, numbers: Numbers) -> list[tuple[int, int]]:
    """First cell and last cell (exclusive) of each block between streets, with small random shifts."""
    block = (cells - streets * street) / (streets + 1)
    found, begin = [], 0
    for number in range(1, streets + 1):
        end = int(number * block + (number - 1) * street + (numbers.uniform() - 0.5) * 0.4 * block)
        found.append((begin, end))
        begin = end + street
    return [*found, (begin, cells)]
