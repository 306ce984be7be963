"""Building a grid: bits are set in a draft that grows as walls need it, then the room is measured."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from amorsim.array_types import Ints, Ints32
from amorsim.kernels.compile import kernel
from amorsim.kernels.grid.grid import ALL, NONE, ONE, Grid, square_ahead, word_mask

__all__ = ["Draft", "finish", "grid_from_array", "grow", "mark_box", "new_draft"]

FREE = np.int32(-(2**31))
"""An entry that is free, its room not measured yet."""
MOST_ENTRIES = 127
MOST_WORDS = 15


class Draft(NamedTuple):
    """A grid in the building: `used` counts the tables and pages taken, of those there is space for."""

    rows: int
    cols: int
    super_cols: int
    supers: Ints32
    tables: Ints32
    pages: NDArray[np.uint64]
    used: Ints


def new_draft(rows: int, cols: int, most_pages: int = 64) -> Draft:
    """An empty draft of a map of rows x cols cells, all free, with space for `most_pages` pages to begin with."""
    super_rows, super_cols = -(-rows // 4096), -(-cols // 4096)
    supers = np.full(super_rows * super_cols, FREE, dtype=np.int32)
    tables = np.full((4, 4096), FREE, dtype=np.int32)
    tables[0] = 0
    pages = np.zeros((most_pages, 64), dtype=np.uint64)
    pages[0] = ALL
    return Draft(rows, cols, super_cols, supers, tables, pages, np.array([1, 1], dtype=np.int64))


def grow(draft: Draft) -> None:
    """Give a draft space for half as much again of whatever is used up, in place."""
    tables, pages = len(draft.tables), len(draft.pages)
    if draft.used[0] >= tables:
        # In place, so that a large map is never in memory twice; no other reference to these arrays exists.
        draft.tables.resize((tables + tables // 2 + 4, 4096), refcheck=False)
        draft.tables[tables:] = FREE
    if draft.used[1] >= pages:
        draft.pages.resize((pages + pages // 2 + 64, 64), refcheck=False)


@kernel
def page_slot(draft: Draft, page_row: int, page_col: int) -> int:
    """The index of a page in the draft, a new one if the page was free; -1 if there is no space for it."""
    top = (page_row >> 6) * draft.super_cols + (page_col >> 6)
    table = int(draft.supers[top])
    if table < 0:
        table = int(draft.used[0])
        if table >= draft.tables.shape[0]:
            return -1
        draft.used[0] = table + 1
        draft.supers[top] = table
    place = (page_row & 63) * 64 + (page_col & 63)
    page = int(draft.tables[table, place])
    if page < 0:
        page = int(draft.used[1])
        if page >= draft.pages.shape[0]:
            return -1
        draft.used[1] = page + 1
        draft.tables[table, place] = page
    return page


@kernel
def mark_box(draft: Draft, row0: int, row1: int, col0: int, col1: int) -> bool:
    """Occupy cells of rows row0..row1 and columns col0..col1, as far as they are in the map; False if the draft must
    grow first.
    """
    first = max(col0, 0)
    end = min(col1, draft.cols - 1)
    row = max(row0, 0)
    end_row = min(row1, draft.rows - 1)
    while row <= end_row:
        last_row = min(end_row, row | 63)
        col = first
        while col <= end:
            page = page_slot(draft, row >> 6, col >> 6)
            if page < 0:
                return False
            last = min(end, col | 63)
            if page > 0:  # page 0 is shared and has every bit set already
                _mark_words(draft.pages, page, row, last_row, col, last)
            col = last + 1
        row = last_row + 1
    return True


@kernel
def _mark_words(pages: NDArray[np.uint64], page: int, row: int, last_row: int, first: int, last: int) -> None:
    """Occupy cells of a page: rows row..last_row and columns first..last of the map, that are all in it."""
    while row <= last_row:
        stop_row = min(last_row, row | 7)
        col = first
        while col <= last:
            stop = min(last, col | 7)
            word = ((row >> 3) & 7) * 8 + ((col >> 3) & 7)
            pages[page, word] |= word_mask(row & 7, col & 7, stop_row & 7, stop & 7)
            col = stop + 1
        row = stop_row + 1


@kernel
def _mark_array(cells: NDArray[np.uint8], draft: Draft) -> bool:
    """Occupy the cells of an array that are not zero; False when the draft has to grow first."""
    for page_row in range((draft.rows + 63) >> 6):
        for page_col in range((draft.cols + 63) >> 6):
            count = 0
            row_end = min(draft.rows, page_row * 64 + 64)
            col_end = min(draft.cols, page_col * 64 + 64)
            for row in range(page_row * 64, row_end):
                for col in range(page_col * 64, col_end):
                    count += cells[row, col] != 0
            if count == 0:
                continue
            page = page_slot(draft, page_row, page_col)
            if page < 0:
                return False
            if count == 64 * 64:
                # Undo the taking: a page just taken is the last one, and the whole black ones share page 0.
                # (On a second # try after growth the place may hold page 0 already.)
                if page > 0:
                    draft.used[1] -= 1
                    table = draft.supers[(page_row >> 6) * draft.super_cols + (page_col >> 6)]
                    draft.tables[table, (page_row & 63) * 64 + (page_col & 63)] = 0
                continue
            for row in range(page_row * 64, row_end):
                for col in range(page_col * 64, col_end):
                    if cells[row, col] != 0:
                        word = ((row >> 3) & 7) * 8 + ((col >> 3) & 7)
                        draft.pages[page, word] |= ONE << np.uint64((row & 7) * 8 + (col & 7))
    return True


@kernel
def _mark_outside(draft: Draft) -> bool:
    """Set every bit beyond the map's rows and columns; False when the draft has to grow first."""
    page_rows = (draft.supers.shape[0] // draft.super_cols) * 64
    page_cols = draft.super_cols * 64
    for page_row in range(page_rows):
        low = page_row * 64
        inside_row = low + 64 <= draft.rows
        # Where all rows of the page are in the map only the pages at its right edge can reach beyond.
        first = draft.cols >> 6 if inside_row else 0
        for page_col in range(first, page_cols):
            left = page_col * 64
            page = page_slot(draft, page_row, page_col)
            if page < 0:
                return False
            if low >= draft.rows or left >= draft.cols:
                if page > 0:
                    draft.used[1] -= 1  # just taken, as nothing was ever marked out here
                    table = draft.supers[(page_row >> 6) * draft.super_cols + (page_col >> 6)]
                    draft.tables[table, (page_row & 63) * 64 + (page_col & 63)] = 0
                continue
            if page == 0:
                continue
            # The rows above the map, and the columns right of it; rows and columns here are the page's own.
            _mark_words(draft.pages, page, max(draft.rows - low, 0), 63, 0, 63)
            _mark_words(draft.pages, page, 0, 63, max(draft.cols - left, 0), 63)
    return True


@kernel
def _words_ahead(grid: Grid, block_row: int, block_col: int, quadrant: int) -> int:
    """The side [words], at least, of the free square ahead of a word in the direction `quadrant`; 0 outside."""
    if block_row < 0 or block_col < 0:
        return 0
    side, shift = square_ahead(grid, block_row * 8, block_col * 8, quadrant)
    inner = (1 << (shift - 3)) - 1
    ahead_col = block_col & inner if quadrant & 1 == 0 else inner - (block_col & inner)
    ahead_row = block_row & inner if quadrant & 2 == 0 else inner - (block_row & inner)
    return int((side >> 3) - max(ahead_row, ahead_col))


@kernel
def _ring(grid: Grid, row: int, col: int, shift: int, quadrant: int) -> int:
    """Units of ``8 << shift`` cells: one more than the least room of the three units ahead of a free one."""
    step_row = 1 if quadrant & 2 == 0 else -1
    step_col = 1 if quadrant & 1 == 0 else -1
    # The near word of a unit is the one that a ray of this quadrant comes in by.
    near_row = (0 if step_row > 0 else 1) * ((1 << shift) - 1)
    near_col = (0 if step_col > 0 else 1) * ((1 << shift) - 1)
    ahead_row = ((row + step_row) << shift) + near_row
    ahead_col = ((col + step_col) << shift) + near_col
    here_row = (row << shift) + near_row
    here_col = (col << shift) + near_col
    least = _words_ahead(grid, ahead_row, here_col, quadrant)
    least = min(least, _words_ahead(grid, here_row, ahead_col, quadrant))
    least = min(least, _words_ahead(grid, ahead_row, ahead_col, quadrant))
    return (least >> shift) + 1


@kernel
def _measure_table(grid: Grid, super_row: int, super_col: int, quadrant: int) -> None:
    """Write the room of the free pages of one table, after that of the tables ahead."""
    table = grid.supers[super_row * grid.super_cols + super_col]
    step_row = 1 if quadrant & 2 == 0 else -1
    step_col = 1 if quadrant & 1 == 0 else -1
    for i in range(64):
        row = 63 - i if step_row > 0 else i
        for j in range(64):
            col = 63 - j if step_col > 0 else j
            place = row * 64 + col
            if grid.tables[table, place] >= 0:
                continue
            if i == 0 or j == 0:
                side: Any = _ring(grid, super_row * 64 + row, super_col * 64 + col, 3, quadrant)
            else:
                side = 127
                for ahead in (place + step_col, place + step_row * 64, place + step_row * 64 + step_col):
                    entry = np.int64(grid.tables[table, ahead])
                    side = min(side, (entry >> (7 * quadrant)) & 127 if entry < 0 else 0)
                side += 1
            grid.tables[table, place] |= np.int32(min(side, MOST_ENTRIES) << (7 * quadrant))


@kernel
def _measure_page(grid: Grid, page_row: int, page_col: int, page: int, quadrant: int, sides: Ints) -> None:
    """Write the room of the empty words of one page, after that of the pages ahead.

    `sides` (9, 9) is to work in: what is known at the words next to the page, ahead of it, and then at its own.
    """
    # Both counted against the quadrant, from the words ahead.
    row, step_row = (page_row * 8 + 8, -1) if quadrant & 2 == 0 else (page_row * 8 - 1, 1)
    col, step_col = (page_col * 8 + 8, -1) if quadrant & 1 == 0 else (page_col * 8 - 1, 1)
    for k in range(9):
        sides[0, k] = _words_ahead(grid, row, col + step_col * k, quadrant)
    for k in range(1, 9):
        sides[k, 0] = _words_ahead(grid, row + step_row * k, col, quadrant)
    for i in range(1, 9):
        for j in range(1, 9):
            place = ((row + step_row * i) & 7) * 8 + ((col + step_col * j) & 7)
            side = 0
            if grid.pages[page, place] == NONE:
                side = min(min(sides[i - 1, j], sides[i, j - 1], sides[i - 1, j - 1]) + 1, MOST_WORDS)
                grid.room[page, place] |= np.uint16(side << (4 * quadrant))
            sides[i, j] = side


@kernel
def _measure(grid: Grid) -> None:
    """Write the room of everything free: all the tops first, then all pages, then words, as each looks at
    those above.

    Within a level the far units of a quadrant come first, because the room of a unit follows from that of its
    three neighbours ahead: a square one longer than the least of theirs.
    """
    super_rows = grid.supers.shape[0] // grid.super_cols
    sides = np.empty((9, 9), dtype=np.int64)
    for level in range(3):
        for quadrant in range(4):
            for i in range(super_rows):
                super_row = super_rows - 1 - i if quadrant & 2 == 0 else i
                for j in range(grid.super_cols):
                    super_col = grid.super_cols - 1 - j if quadrant & 1 == 0 else j
                    top = super_row * grid.super_cols + super_col
                    table = grid.supers[top]
                    if table < 0:
                        if level == 0:
                            side = _ring(grid, super_row, super_col, 9, quadrant)
                            grid.supers[top] |= np.int32(min(side, MOST_ENTRIES) << (7 * quadrant))
                    elif table > 0 and level == 1:
                        _measure_table(grid, super_row, super_col, quadrant)
                    elif table > 0 and level == 2:
                        for p in range(4096):
                            row = 63 - (p >> 6) if quadrant & 2 == 0 else p >> 6
                            col = 63 - (p & 63) if quadrant & 1 == 0 else p & 63
                            page = grid.tables[table, row * 64 + col]
                            if page > 0:
                                _measure_page(grid, super_row * 64 + row, super_col * 64 + col, page, quadrant, sides)


def finish(draft: Draft, resolution: float) -> Grid:
    """The grid of a draft, of cells `resolution` [m] wide, with outside occupied and all room measured.

    The draft is used up: the grid takes over its arrays.
    """
    while not _mark_outside(draft):
        grow(draft)
    draft.tables.resize((int(draft.used[0]), 4096), refcheck=False)
    draft.pages.resize((int(draft.used[1]), 64), refcheck=False)
    # The arrays stay writable although nothing writes to them: numba compiles every kernel a second time for
    # read-only ones, and a grid from a pickle has none.
    grid = Grid(
        resolution=float(resolution),
        rows=draft.rows,
        cols=draft.cols,
        super_cols=draft.super_cols,
        supers=draft.supers,
        tables=draft.tables,
        pages=draft.pages,
        room=np.zeros(draft.pages.shape, dtype=np.uint16),
    )
    _measure(grid)
    return grid


def grid_from_array(cells: NDArray[np.uint8], resolution: float) -> Grid:
    """The grid of an array (rows, cols), row 0 lowest, whose cells that are not zero are occupied."""
    cells = np.ascontiguousarray(cells, dtype=np.uint8)
    rows, cols = cells.shape
    # Space for all pages that there may be, an eighth of the array's own size: growing would mark all again.
    draft = new_draft(rows, cols, (rows // 64 + 2) * (cols // 64 + 2))
    while not _mark_array(cells, draft):
        grow(draft)
    return finish(draft, resolution)
