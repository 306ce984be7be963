"""The sparse grid reads as the array it was built from, and its room is free."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.grid import (
    Grid,
    box_is_free,
    is_occupied,
    next_occupied,
    occupied_boxes,
    square_ahead,
    word_at,
    word_mask,
)

# Sizes about the borders of words, pages and tables.
SIZES = [(1, 1), (7, 9), (8, 8), (64, 64), (65, 63), (200, 331), (64, 4160), (4097, 70)]


def some_cells(rows: int, cols: int, seed: int = 0, share: float = 0.002) -> np.ndarray:
    rng = np.random.default_rng(seed)
    cells = (rng.random((rows, cols)) < share).astype(np.uint8)
    # Whole black pages beside whole free ones.
    cells[rows // 2 : rows // 2 + 150, cols // 3 : cols // 3 + 150] = rows > 150
    return cells


def read(grid: Grid, row0: int, col0: int, rows: int, cols: int) -> np.ndarray:
    out = np.empty((rows, cols), dtype=np.uint8)
    row, col = np.arange(row0, row0 + rows), np.arange(col0, col0 + cols)
    occupied_boxes(grid, row, row, col, col, out)
    return out


@pytest.mark.parametrize(("rows", "cols"), SIZES)
def test_reads_back_what_was_put_in(rows: int, cols: int) -> None:
    cells = some_cells(rows, cols)
    grid = grid_from_array(cells, 0.1)
    np.testing.assert_array_equal(read(grid, 0, 0, rows, cols), cells)
    rng = np.random.default_rng(1)
    for row, col in zip(rng.integers(-70, rows + 70, 500), rng.integers(-70, cols + 70, 500), strict=True):
        inside = 0 <= row < rows and 0 <= col < cols
        assert is_occupied(grid, row, col) == (bool(cells[row, col]) if inside else True)


@pytest.mark.parametrize(("rows", "cols"), [(7, 9), (64, 64), (200, 331)])
def test_words_hold_their_cells_and_outside_is_set(rows: int, cols: int) -> None:
    cells = some_cells(rows, cols)
    grid = grid_from_array(cells, 0.1)
    padded = np.ones((rows + 200, cols + 200), dtype=np.uint8)
    padded[80 : 80 + rows, 80 : 80 + cols] = cells
    for block_row in range(-3, rows // 8 + 4):
        for block_col in range(-3, cols // 8 + 4):
            block = padded[80 + block_row * 8 :, 80 + block_col * 8 :][:8, :8]
            word = np.uint64(np.packbits(block.ravel(), bitorder="little").view(np.uint64)[0])
            assert np.uint64(word_at(grid, block_row, block_col)) == word


def test_masks_hold_their_box() -> None:
    for row0, row1, col0, col1 in np.argwhere(np.ones((8, 8, 8, 8))):
        if row0 <= row1 and col0 <= col1:
            block = np.zeros((8, 8), dtype=np.uint8)
            block[row0 : row1 + 1, col0 : col1 + 1] = 1
            word = np.packbits(block.ravel(), bitorder="little").view(np.uint64)[0]
            assert np.uint64(word_mask(row0, col0, row1, col1)) == word


@pytest.mark.parametrize(("rows", "cols"), [(65, 63), (200, 331), (4200, 4200)])
@pytest.mark.parametrize("share", [0.0, 1e-5, 2e-3])
def test_boxes_are_free_where_no_cell_is_occupied(rows: int, cols: int, share: float) -> None:
    cells = some_cells(rows, cols, share=share)
    grid = grid_from_array(cells, 0.1)
    rng = np.random.default_rng(2)
    answers = set()
    for n in range(2000):
        row0, row1 = np.sort(rng.integers(-2, rows + 2, 2))
        col0, col1 = np.sort(rng.integers(-2, cols + 2, 2))
        if n % 2:
            row1, col1 = min(row1, row0 + 40), min(col1, col0 + 40)
        inside = row0 >= 0 and col0 >= 0 and row1 < rows and col1 < cols
        expected = bool(inside and not cells[row0 : row1 + 1, col0 : col1 + 1].any())
        assert box_is_free(grid, row0, col0, row1, col1) == expected
        answers.add(expected)
    assert answers == {True, False}


@pytest.mark.parametrize(("rows", "cols"), SIZES)
@pytest.mark.parametrize("share", [0.0, 0.002, 0.2])
def test_the_next_occupied_column_and_boxes_are_those_of_the_array(rows: int, cols: int, share: float) -> None:
    cells = some_cells(rows, cols, seed=2, share=share)
    grid = grid_from_array(cells, 0.1)
    rng = np.random.default_rng(4)
    for _ in range(200):
        row0, row1 = sorted(rng.integers(0, rows, 2))
        row1 = min(row1, row0 + rng.integers(0, 90))
        col = rng.integers(0, cols)
        found = np.flatnonzero(cells[row0 : row1 + 1, col:].any(axis=0))
        assert next_occupied(grid, row0, row1, col) == (col + found[0] if len(found) else cols)
    # Spans in any order, that overlap, are empty, or reach outside.
    low, left = rng.integers(-9, rows + 4, 40), rng.integers(-9, cols + 4, 40)
    high, right = low + rng.integers(-1, 30, 40), left + rng.integers(-1, 30, 40)
    left[20:], right[20:] = np.sort(left[20:]), np.sort(left[20:]) + 3
    out = np.empty((40, 40), dtype=np.uint8)
    occupied_boxes(grid, low, high, left, right, out)
    for i, j in np.ndindex(out.shape):
        inside = cells[max(low[i], 0) : max(high[i] + 1, 0), max(left[j], 0) : max(right[j] + 1, 0)]
        assert out[i, j] == (inside.any() if inside.size else 1), (i, j)


@pytest.mark.parametrize(("rows", "cols"), [(65, 63), (200, 331), (4100, 8300)])
def test_squares_ahead_are_free_and_hold_their_cell(rows: int, cols: int) -> None:
    cells = some_cells(rows, cols, share=1e-4)
    grid = grid_from_array(cells, 0.1)
    total = np.zeros((rows + 1, cols + 1), dtype=np.int64)
    total[1:, 1:] = cells.cumsum(0, dtype=np.int64).cumsum(1)
    rng = np.random.default_rng(3)
    shifts = set()
    for row, col in zip(rng.integers(0, rows, 2500), rng.integers(0, cols, 2500), strict=True):
        for quadrant in range(4):
            side, shift = square_ahead(grid, row, col, quadrant)
            unit = 1 << shift
            if side == 0:
                assert word_at(grid, row >> 3, col >> 3) != 0
                continue
            shifts.add(shift)
            left = (col & -unit) + (unit - side if quadrant & 1 else 0)
            low = (row & -unit) + (unit - side if quadrant & 2 else 0)
            assert left >= 0
            assert low >= 0
            assert left + side <= cols
            assert low + side <= rows
            assert left <= col < left + side
            assert low <= row < low + side
            held = total[low + side, left + side] - total[low, left + side]
            assert held - total[low + side, left] + total[low, left] == 0
    assert 3 in shifts


def test_room_reaches_across_pages_and_tables() -> None:
    grid = grid_from_array(np.zeros((3 * 4096, 3 * 4096), dtype=np.uint8), 0.001)
    assert square_ahead(grid, 0, 0, 0) == (3 * 4096, 12)
    assert square_ahead(grid, 4096, 4096, 3) == (2 * 4096, 12)
    cells = np.zeros((640, 640), dtype=np.uint8)
    cells[639, 639] = 1
    grid = grid_from_array(cells, 0.001)
    assert square_ahead(grid, 0, 0, 0) == (9 * 64, 6)
    assert square_ahead(grid, 500, 500, 3) == (8 * 64, 6)
    # In the page with the wall 15 words is the most that is kept.
    assert square_ahead(grid, 600, 600, 3) == (15 * 8, 3)
    assert square_ahead(grid, 9 * 64, 9 * 64, 0) == (7 * 8, 3)


def test_black_areas_cost_nothing() -> None:
    cells = np.ones((8192, 8192), dtype=np.uint8)
    cells[100:200, 100:200] = 0
    grid = grid_from_array(cells, 0.001)
    # Of the pages only the nine about the free place are neither all black nor all free.
    assert len(grid.pages) <= 10
    assert not is_occupied(grid, 150, 150)
    assert is_occupied(grid, 8000, 8000)


def test_boxes_partly_outside_count_what_is_inside() -> None:
    cells = np.zeros((10, 10), dtype=np.uint8)
    cells[9, 9] = 1
    grid = grid_from_array(cells, 1.0)
    low = np.array([-5, -5, 8, 8, 12])
    high = np.array([-1, 3, 8, 20, 20])
    out = np.empty((5, 5), dtype=np.uint8)
    occupied_boxes(grid, low, high, low, high, out)
    expected = np.array(
        [[1, 1, 1, 1, 1], [1, 0, 0, 0, 1], [1, 0, 0, 0, 1], [1, 0, 0, 1, 1], [1, 1, 1, 1, 1]], dtype=np.uint8
    )
    np.testing.assert_array_equal(out, expected)
