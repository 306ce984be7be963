"""A closed segment fills the cells that its line touches: those that shapely says intersect it."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.grid.grid import Grid, occupied_boxes
from amorsim.kernels.grid.rasterise import SNAP, grid_from_segments, snapped
from tests.examples import settings

SIDE = 24
COLUMN, ROW = np.meshgrid(np.arange(SIDE), np.arange(SIDE))
BOXES = shapely.box(COLUMN, ROW, COLUMN + 1, ROW + 1)


def cells_of(grid: Grid) -> np.ndarray:
    out = np.empty((grid.rows, grid.cols), dtype=np.uint8)
    rows, cols = np.arange(grid.rows), np.arange(grid.cols)
    occupied_boxes(grid, rows, rows, cols, cols, out)
    return out.astype(bool)


def touched(segment: np.ndarray) -> np.ndarray:
    return shapely.intersects(BOXES, shapely.LineString(np.reshape(segment, (2, 2))))


def check(segment: np.ndarray) -> None:
    cells = cells_of(grid_from_segments(np.array([segment]), SIDE, SIDE, 1.0))
    np.testing.assert_array_equal(cells, touched(np.asarray(segment, dtype=float)), err_msg=str(segment))


def some_segments(kind: str, count: int) -> np.ndarray:
    rng = np.random.default_rng(0)
    if kind == "whole":
        segments = rng.integers(-3, SIDE + 4, (count, 4)).astype(float)
    elif kind == "halves":
        segments = rng.integers(-6, 2 * SIDE + 8, (count, 4)) / 2
    elif kind == "dyadic":
        segments = rng.integers(-3 * 64, 64 * SIDE + 200, (count, 4)) / 64.0
    else:
        segments = rng.random((count, 4)) * (SIDE + 6) - 3
    segments[::11, 2:] = segments[::11, :2]
    segments[1::11, 2] = segments[1::11, 0]
    segments[2::11, 3] = segments[2::11, 1]
    return segments


@pytest.mark.parametrize("kind", ["whole", "halves", "dyadic", "anywhere"])
def test_fills_what_shapely_says_is_touched(kind: str) -> None:
    for segment in some_segments(kind, 600):
        check(segment)


# Through grid points and within roundings of them, where estimates cannot tell.
near_lines = st.builds(
    lambda whole, part: float(whole) + part,
    st.integers(-2, SIDE + 2),
    st.sampled_from([0.0, 0.5, 1 / 3, 2 / 3, 0.25, 0.1, 2 * SNAP, -2 * SNAP]),
)


@settings(max_examples=300, deadline=None)
@given(st.tuples(near_lines, near_lines, near_lines, near_lines))
def test_fills_what_shapely_says_near_grid_points(segment: tuple[float, float, float, float]) -> None:
    check(np.array(segment))


@settings(max_examples=200, deadline=None)
@given(
    st.integers(3, 20),
    st.integers(3, 20),
    st.integers(-7, 7),
    st.integers(-7, 7),
    st.floats(-1.5, 1.5),
    st.floats(0, 1.5),
)
def test_lines_almost_through_a_grid_point_are_decided_exactly(
    x: int, y: int, dx: int, dy: int, before: float, after: float
) -> None:
    # End points are rounded, so the line passes the grid point by about 1e-16: on which side, GEOS works out
    # too.
    check(snapped(np.array([x - before * dx, y - before * dy, x + after * dx, y + after * dy])))


def test_a_wall_on_a_grid_line_fills_both_sides_in_metres() -> None:
    # 1.009 m is not a whole number of doubles' millimetres.
    for millimetres in range(1000, 1100):
        wall = np.array([[millimetres / 1000, 0.0, millimetres / 1000, 0.01]])
        cells = cells_of(grid_from_segments(wall, 10, 1200, 0.001))
        assert set(np.argwhere(cells[5]).ravel()) == {millimetres - 1, millimetres}


def test_a_diagonal_through_corners_fills_the_four_cells_at_each() -> None:
    cells = cells_of(grid_from_segments(np.array([[2.0, 2.0, 5.0, 5.0]]), 8, 8, 1.0))
    expected = np.zeros((8, 8), dtype=bool)
    for corner in range(2, 6):
        expected[corner - 1 : corner + 1, corner - 1 : corner + 1] = True
    np.testing.assert_array_equal(cells, expected)


def test_either_direction_fills_the_same() -> None:
    for segment in some_segments("anywhere", 200):
        there = cells_of(grid_from_segments(segment[None], SIDE, SIDE, 1.0))
        back = cells_of(grid_from_segments(segment[None, [2, 3, 0, 1]], SIDE, SIDE, 1.0))
        np.testing.assert_array_equal(there, back)


def test_many_walls_make_the_union_of_each() -> None:
    segments = some_segments("anywhere", 40)
    cells = cells_of(grid_from_segments(segments, SIDE, SIDE, 1.0))
    np.testing.assert_array_equal(cells, np.any([touched(s) for s in segments], axis=0))


def test_an_offset_moves_the_window() -> None:
    segment = np.array([[3.2, 4.1, 19.7, 15.3]])
    whole = cells_of(grid_from_segments(segment, SIDE, SIDE, 1.0))
    part = cells_of(grid_from_segments(segment, 10, 12, 1.0, (5, 3)))
    np.testing.assert_array_equal(part, whole[3:13, 5:17])


def test_memory_follows_the_walls_not_the_area() -> None:
    rng = np.random.default_rng(0)
    start = rng.random((200, 2)) * 1000
    angle = rng.random(200) * 2 * np.pi
    walls = np.c_[start, start + 10 * np.c_[np.cos(angle), np.sin(angle)]]
    grid = grid_from_segments(walls, 1_000_000, 1_000_000, 0.001)
    # A page a 64 mm of wall, sqrt(2) of that on a slant, and one at each end.
    assert len(grid.pages) < 1.42 * 2000 / 0.064 + 2 * 200
    assert sum(array.nbytes for array in grid[4:]) < 60e6
