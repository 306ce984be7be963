"""Warehouses: rows of shelves with aisles between them."""

from __future__ import annotations

import math

import attrs

from amorsim.core.parameters import parameter
from amorsim.worlds.cells import CellWorld, Sheet
from amorsim.worlds.random_numbers import Numbers

__all__ = ["Warehouse"]


@attrs.frozen(kw_only=True)
class Warehouse(CellWorld):
    """A warehouse: double rows of shelves with aisles between them, cross aisles, and a free area at the left."""

    size: tuple[float, float] = parameter((30.0, 20.0), unit="m", gt=0, le=10_000, help="width and height of the world")
    aisle: float = parameter(2.0, unit="m", gt=0, help="width of the aisles")
    shelf: float = parameter(1.0, unit="m", gt=0, help="depth of a single row of shelves; two stand back to back")
    section: float = parameter(2.5, unit="m", gt=0, help="length of a section of shelves")
    block: int = parameter(4, ge=1, help="sections in a row between two cross aisles")
    dock: float = parameter(4.0, unit="m", gt=0, help="width of the free area at the left, where robots start")
    empty: float = parameter(0.1, ge=0, le=1, help="share of the sections that are not there")

    def draw(self, sheet: Sheet, numbers: Numbers) -> None:
        """Draw the shelves, in as many rows and blocks as there is place for."""
        wall = self.in_cells(0.1)
        aisle, dock = self.need_passage("aisle", self.aisle), self.need_passage("dock", self.dock)
        shelf, section = self.in_cells(self.shelf), self.in_cells(self.section)
        self.need_size(2 * wall + dock, 2 * wall + 2 * aisle + 2 * shelf, "a warehouse of one row of shelves")
        sheet.border(wall)
        rows, cols = sheet.cells.shape
        sheet.start = (rows / 2, wall + dock / 2)
        count = (rows - 2 * wall - aisle) // (aisle + 2 * shelf)
        pitch = (rows - 2 * wall - aisle) / count  # aisles are a little wider where the size asks for it
        spare = (pitch - 2 * shelf - aisle) / 2
        last = cols - wall - aisle  # a cross aisle is at the right too
        for row in range(count):
            low = wall + aisle + int(row * pitch + spare)
            for double in (0, 1):
                col, placed = wall + dock, 0
                while col + section <= last:
                    if not numbers.chance(self.empty):
                        sheet.fill(col, low + double * shelf, col + section, low + (double + 1) * shelf)
                    col += section
                    placed += 1
                    if placed % self.block == 0:
                        col += aisle
        sheet.heading = math.pi / 2
