"""Strips along outlines hold every side by which a ray can come into an occupied cell, and scans rely on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from PIL import Image

from amorsim.core.maps.map import Map
from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.outlines import strips_of
from amorsim.kernels.raycast.rays import cast
from tests import naive
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "ros"
FAN = np.linspace(-np.pi, np.pi, 181)


def sides(cells: np.ndarray) -> np.ndarray:
    """Ends (M, 4) of all sides between a free cell and an occupied one of the map."""
    free = np.pad(cells == 0, 1)
    taken = np.pad(cells != 0, 1)
    found = []
    for axis in range(2):
        for way in (1, -1):
            for row, col in np.argwhere(taken & np.roll(free, way, axis)) - 1:
                # The free neighbour is before the cell along the axis where `way` is 1.
                if axis == 0:
                    y = row + (0 if way == 1 else 1)
                    found.append((col, y, col + 1, y))
                else:
                    x = col + (0 if way == 1 else 1)
                    found.append((x, row, x, row + 1))
    return np.array(found, dtype=np.float64).reshape(-1, 4)


def held(strips: np.ndarray, points: np.ndarray, slack: float = 0.0) -> np.ndarray:
    """(strips, points): whether a strip, less some slack, holds a point."""
    run = strips[:, 2:4] - strips[:, :2]
    length = np.hypot(run[:, 0], run[:, 1])
    unit = np.where(length[:, None] > 0.0, run / np.where(length, length, 1.0)[:, None], [1.0, 0.0])
    away = points[None] - strips[:, None, :2]
    along = away[..., 0] * unit[:, None, 0] + away[..., 1] * unit[:, None, 1]
    across = away[..., 1] * unit[:, None, 0] - away[..., 0] * unit[:, None, 1]
    margin = strips[:, 4:5] - slack
    return (np.abs(across) <= margin) & (along >= -margin) & (along <= length[:, None] + margin)


def assert_held(cells: np.ndarray) -> np.ndarray:
    """The strips of some cells, after a check that each side lies in one, both its ends with room for roundings."""
    strips = strips_of(grid_from_array(cells, 1.0), cells)
    borders = sides(cells)
    lies_in_one = np.zeros(len(borders), dtype=bool)
    for some in np.array_split(strips, len(strips) // 32 + 1):  # all by all would be hundreds of megabytes
        inside = held(some, borders[:, :2], 5e-7) & held(some, borders[:, 2:], 5e-7)
        lies_in_one |= inside.any(axis=0)
    assert lies_in_one.all() if len(borders) else not len(strips)
    return strips


@settings(max_examples=200, deadline=None)
@given(
    hnp.arrays(np.uint8, hnp.array_shapes(min_dims=2, max_dims=2, max_side=24), elements=st.integers(0, 1)),
)
def test_every_side_lies_in_a_strip(cells: np.ndarray) -> None:
    assert_held(cells)


@pytest.mark.parametrize("share", [0.002, 0.05, 0.4, 0.6, 0.95])
def test_every_side_lies_in_a_strip_of_larger_maps(share: float) -> None:
    assert_held((np.random.default_rng(1).random((150, 83)) < share).astype(np.uint8))


def test_solid_pages_of_which_the_grid_keeps_no_bits() -> None:
    cells = np.zeros((256, 256), dtype=np.uint8)
    cells[64:128, 64:192] = 1
    assert len(assert_held(cells)) == 4
    assert len(assert_held(1 - cells)) == 4


def test_what_stands_at_the_border() -> None:
    for place in (np.s_[:, :9], np.s_[:, 9:], np.s_[:9], np.s_[9:], np.s_[30:, 20:], np.s_[:5, :5], np.s_[3:4, :]):
        cells = np.zeros((40, 40), dtype=np.uint8)
        cells[place] = 1
        assert_held(cells)
    assert not len(assert_held(np.zeros((70, 9), dtype=np.uint8)))
    assert not len(assert_held(np.ones((70, 9), dtype=np.uint8)))


def test_a_thin_wall_is_one_strip_of_just_its_cells() -> None:
    cells = np.zeros((50, 50), dtype=np.uint8)
    cells[20, 5:45] = 1
    (strip,) = assert_held(cells)
    assert strip == pytest.approx([5.5, 20.5, 44.5, 20.5, 0.500001], abs=1e-9)


@pytest.mark.parametrize("slope", [0.03, 0.21, 0.5, 0.77, 1.0])
def test_an_oblique_wall_is_a_few_strips(slope: float) -> None:
    wall = Map.from_segments([[1.0, 1.0, 9.0, 1.0 + 8.0 * slope]], resolution=0.01, extent=(0, 0, 10, 10))
    strips = assert_held(wall.to_array())
    assert len(strips) <= 6
    assert strips[:, 4].max() < 3.0


def random_cells(rng: np.random.Generator) -> np.ndarray:
    rows, cols = rng.integers(1, 400, 2)
    cells = (rng.random((rows, cols)) < rng.choice([0.0, 0.001, 0.01, 0.2])).astype(np.uint8)
    for _ in range(rng.integers(0, 12)):
        row, col = rng.integers(0, rows), rng.integers(0, cols)
        wide, high = rng.choice([[1, 60], [60, 1], [20, 30], [1, 1]])
        cells[row : row + high, col : col + wide] = 1
    return cells


def scans_on_random_cells(maps: int, poses: int, seed: int) -> int:
    rng = np.random.default_rng(seed)
    rays = 0
    for m in range(maps):
        cells = random_cells(rng)
        if cells.all():
            continue
        resolution = float(rng.choice([0.001, 0.05, 1 / 3]))
        origin = (rng.normal(), rng.normal(), rng.random() * 6 - 3) if m % 3 == 0 else (0.0, 0.0, 0.0)
        world = Map.from_array(cells, resolution=resolution, origin=origin)
        free = np.argwhere(cells == 0)
        within = rng.choice([0.0, 0.5, 1e-9, 1.0 - 1e-9], (poses, 2)) + rng.random((poses, 2)) * (m % 2)
        x, y = ((free[rng.integers(0, len(free), poses), ::-1] + within) * resolution).T
        c, s = np.cos(origin[2]), np.sin(origin[2])
        heading = rng.random(poses) * 7
        heading[::3] = rng.integers(-4, 5, len(heading[::3])) * (np.pi / 4)
        starts = np.column_stack([origin[0] + c * x - s * y, origin[1] + s * x + c * y, heading + origin[2]])
        reach = float(rng.choice([np.inf, 8.0, 50 * resolution]))
        out = world.cast_rays(starts, FAN, reach)
        cosines, sines, range_max = np.cos(FAN)[None], np.sin(FAN)[None], np.array([reach])
        alone = np.empty_like(out)
        cast(world.grid, *world.origin, starts, cosines, sines, range_max, alone)
        np.testing.assert_array_equal(out.view(np.int64), alone.view(np.int64))
        walked = naive.cast(cells, resolution, world.origin, starts, cosines, sines, range_max)
        np.testing.assert_array_equal(out.view(np.int64), walked.view(np.int64))
        rays += out.size
    return rays


def test_scans_of_bitmaps_read_what_walking_reads() -> None:
    assert scans_on_random_cells(maps=40, poses=20, seed=2) > 100_000


@pytest.mark.long
def test_scans_of_bitmaps_read_what_walking_reads_a_million_times() -> None:
    assert scans_on_random_cells(maps=200, poses=100, seed=3) > 1_000_000


@pytest.mark.long
@pytest.mark.parametrize("name", ["depot.pgm", "willow-full-0.05.pgm", "turtlebot3_world.pgm"])
def test_scans_of_real_bitmaps_at_length(name: str) -> None:
    if not MAPS.is_dir():
        pytest.skip("the real maps are not here")
    with Image.open(MAPS / name) as image:
        cells = np.ascontiguousarray(np.asarray(image)[::-1] < 100).astype(np.uint8)
    world = Map.from_array(cells, resolution=0.05)
    rng = np.random.default_rng(4)
    free = np.argwhere(cells == 0)
    places = (free[rng.integers(0, len(free), 2000), ::-1] + rng.random((2000, 2))) * 0.05
    poses = np.column_stack([places, rng.random(2000) * 7])
    for reach in (8.0, 30.0):
        out = world.cast_rays(poses, FAN, reach)
        walked = naive.cast(cells, 0.05, world.origin, poses, np.cos(FAN)[None], np.sin(FAN)[None], np.array([reach]))
        np.testing.assert_array_equal(out.view(np.int64), walked.view(np.int64))
        assert np.isfinite(out).mean() > 0.2


def test_a_bitmap_has_walls_that_scans_look_up() -> None:
    cells = np.zeros((100, 100), dtype=np.uint8)
    cells[10:90, 60] = 1
    world = Map.from_array(cells, resolution=0.1)
    assert world.segment_index.walls.shape[1] == 1 + 4  # and the border
    assert world.cast_rays([[1.0, 5.0, 0.0]], np.zeros(20), 8.0) == pytest.approx(np.full((1, 20), 5.0))


def test_noise_is_given_up_early() -> None:
    cells = (np.random.default_rng(1).random((60, 60)) < 0.5).astype(np.uint8)
    grid = grid_from_array(cells, 1.0)
    count = len(strips_of(grid, cells))
    assert len(strips_of(grid, cells, count)) == count
    with pytest.raises(OverflowError, match=f"more than {count - 1} strips"):
        strips_of(grid, cells, count - 1)
