"""Rays that jump read the same bits as rays that walk cell by cell."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from amorsim.kernels.grid.draft import grid_from_array
from amorsim.kernels.grid.grid import Grid, occupied_boxes
from amorsim.kernels.grid.rasterise import grid_from_segments
from amorsim.kernels.raycast.rays import cast, cast_ray, occupied_points
from tests import naive
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps"
UNTURNED = (0.0, 0.0, 0.0)


def both(
    cells: np.ndarray,
    resolution: float,
    poses: np.ndarray,
    bearings: np.ndarray,
    range_max: float | np.ndarray = np.inf,
    origin: tuple[float, float, float] = UNTURNED,
    grid: Grid | None = None,
) -> np.ndarray:
    """Distances by `cast`, after a check that walking gives the same bits."""
    if grid is None:
        grid = grid_from_array(cells, resolution)
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    bearings = np.atleast_2d(bearings)
    cosines, sines = np.cos(bearings), np.sin(bearings)
    reach = np.atleast_1d(np.asarray(range_max, dtype=np.float64))
    out = np.full((len(poses), bearings.shape[1]), -1.0)
    cast(grid, *origin, poses, cosines, sines, reach, out)
    expected = naive.cast(cells, resolution, origin, poses, cosines, sines, reach)
    differ = np.argwhere(out.view(np.int64) != expected.view(np.int64))
    for n, k in differ[:1]:
        pytest.fail(
            f"{len(differ)} of {out.size} differ; pose {poses[n].tolist()}, beam {k}: {out[n, k]}, "
            f"expected {expected[n, k]}"
        )
    return out


def random_cells(rng: np.random.Generator, rows: int, cols: int) -> np.ndarray:
    cells = (rng.random((rows, cols)) < rng.choice([0.0, 0.0005, 0.01, 0.2])).astype(np.uint8)
    for _ in range(rng.integers(0, 12)):
        row, col = rng.integers(0, rows), rng.integers(0, cols)
        if rng.random() < 0.5:
            cells[row, col : col + rng.integers(1, cols + 1)] = 1
        else:
            cells[row : row + rng.integers(1, rows + 1), col] = 1
    return cells


def random_poses(rng: np.random.Generator, cells: np.ndarray, resolution: float, count: int) -> np.ndarray:
    """Poses mostly on free cells, some of them on grid lines or grid points, some along an axis."""
    free = np.argwhere(cells == 0)
    chosen = free[rng.integers(0, len(free), count)]
    within = rng.random((count, 2))
    within[::5, 0] = 0.0
    within[1::5, 1] = 0.0
    within[2::5] = 0.0
    x, y = ((chosen[:, ::-1] + within) * resolution).T
    heading = rng.random(count) * 2 * np.pi - np.pi
    heading[::7] = rng.choice(np.arange(-4, 5) * (np.pi / 4), len(heading[::7]))
    poses = np.stack([x, y, heading], axis=1)
    poses[::97, :2] += rng.normal(size=(len(poses[::97]), 2)) * cells.shape[0] * resolution
    return poses


def compare_on_random_maps(maps: int, poses: int, seed: int) -> tuple[int, int]:
    rng = np.random.default_rng(seed)
    bearings = np.concatenate([np.linspace(-np.pi, np.pi, 33), rng.random(8) * 7, [1e-9, -1e-13, np.pi / 2 + 1e-12]])
    rays = hits = 0
    for m in range(maps):
        rows, cols = rng.integers(1, 700, 2) if m % 3 else rng.integers(1, 70, 2)
        cells = random_cells(rng, rows, cols)
        if cells.all():
            continue
        resolution = rng.choice([0.001, 0.05, 0.1, 1.0, 1 / 3, 7.3])
        turned = (rng.normal(), rng.normal(), rng.random() * 6 - 3) if m % 4 == 3 else UNTURNED
        range_max = rng.choice([np.inf, 8.0, 40 * resolution])
        starts = random_poses(rng, cells, resolution, poses)
        if turned != UNTURNED:
            c, s = math.cos(turned[2]), math.sin(turned[2])
            x, y = starts[:, 0].copy(), starts[:, 1].copy()
            starts[:, 0], starts[:, 1] = turned[0] + c * x - s * y, turned[1] + s * x + c * y
        out = both(cells, resolution, starts, bearings, range_max, turned)
        rays += out.size
        hits += np.count_nonzero(np.isfinite(out) & (out > 0))
    return rays, hits


def test_jumping_finds_what_walking_finds() -> None:
    rays, hits = compare_on_random_maps(maps=40, poses=40, seed=0)
    assert rays > 50_000
    assert hits > rays / 3


@pytest.mark.long
def test_jumping_finds_what_walking_finds_a_million_times() -> None:
    rays, _ = compare_on_random_maps(maps=300, poses=90, seed=1)
    assert rays > 1_000_000


def line_walls(name: str) -> np.ndarray:
    """Walls [m] of a world file's lines of four whole numbers, frames left out."""
    walls = []
    for line in (MAPS / "wld" / name).read_text().splitlines():
        words = line.split(";")[0].split()
        if len(words) == 4 and all(word.lstrip("-").isdigit() for word in words):
            walls.append([int(word) for word in words])
    return np.array(walls, dtype=np.float64) / 1000


def wall_map(name: str, resolution: float) -> tuple[np.ndarray, Grid]:
    walls = line_walls(name)
    walls -= np.tile(walls.reshape(-1, 2).min(axis=0), 2)
    cols, rows = (np.ceil(walls.reshape(-1, 2).max(axis=0) / resolution)).astype(int)
    grid = grid_from_segments(walls, int(rows), int(cols), resolution)
    cells = np.empty((rows, cols), dtype=np.uint8)
    row, col = np.arange(rows), np.arange(cols)
    occupied_boxes(grid, row, row, col, col, cells)
    return cells, grid


def on_line_worlds(name: str, resolution: float, poses: int) -> None:
    if not MAPS.is_dir():
        pytest.skip("the real maps are not here")
    cells, grid = wall_map(name, resolution)
    starts = random_poses(np.random.default_rng(3), cells, resolution, poses)
    out = both(cells, resolution, starts, np.linspace(-np.pi / 2, np.pi / 2, 181), 8.0, grid=grid)
    assert np.isfinite(out).mean() > 0.2


def on_ros_map(name: str, poses: int) -> None:
    if not MAPS.is_dir():
        pytest.skip("the real maps are not here")
    with Image.open(MAPS / "ros" / name) as image:
        cells = np.ascontiguousarray(np.asarray(image)[::-1] < 100).astype(np.uint8)
    starts = random_poses(np.random.default_rng(4), cells, 0.05, poses)
    out = both(cells, 0.05, starts, np.linspace(-np.pi / 2, np.pi / 2, 181), 30.0)
    assert np.isfinite(out).mean() > 0.2


@pytest.mark.long
@pytest.mark.parametrize(("name", "resolution"), [("serp-sm.wld", 0.001), ("hallway.wld", 0.05)])
def test_line_worlds(name: str, resolution: float) -> None:
    on_line_worlds(name, resolution, poses=8)


def test_a_ros_map() -> None:
    on_ros_map("turtlebot3_world.pgm", poses=60)


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "resolution"),
    [
        ("serp-sm.wld", 0.001),
        ("table.wld", 0.001),
        # The twin needs an array of all cells: worlds of 50 m are walked at 1 cm.
        ("uwa-ee4.wld", 0.01),
        ("hallway.wld", 0.01),
        ("serp.wld", 0.05),
    ],
)
def test_line_worlds_at_length(name: str, resolution: float) -> None:
    on_line_worlds(name, resolution, poses=200)


@pytest.mark.long
@pytest.mark.parametrize("name", ["depot.pgm", "willow-full-0.05.pgm", "empty_room.pgm"])
def test_ros_maps_at_length(name: str) -> None:
    on_ros_map(name, poses=1000)


def room(rows: int = 20, cols: int = 30) -> np.ndarray:
    return np.zeros((rows, cols), dtype=np.uint8)


def test_along_the_axes_and_on_cell_borders() -> None:
    cells = room()
    cells[10, 20] = 1
    quarter_turns = np.arange(4) * (np.pi / 2)
    poses = [
        [5.5, 10.5, 0.0],
        [5.0, 10.0, 0.0],
        [20.0, 3.0, 0.0],
        [20.5, 15.0, 0.0],
        [21.0, 10.0, 0.0],
        [25, 11, 0],
    ]
    out = both(cells, 1.0, poses, quarter_turns)
    assert out[0, 0] == 14.5
    assert out[0, 2] == 5.5  # outside the map is occupied
    assert out[1, 0] == 15.0  # a start on a line belongs to the cell above it
    assert out[2, 1] == pytest.approx(7.0)
    assert out[3, 3] == pytest.approx(4.0)
    assert out[4, 2] == 0.0  # the cell left of the line it stands on is occupied
    assert out[5, 2] == 25.0  # along the upper border of the cell: it belongs to the row above


def test_through_corners_x_goes_first() -> None:
    beside, above = room(), room()
    beside[5, 6] = 1
    above[6, 5] = 1
    # An exact diagonal: each grid point is a tie, and the cell right of it is entered before the one above.
    start = np.array([[5.5, 5.5]])
    for cells, expected in ((beside, 0.5), (above, 14.5)):
        grid = grid_from_array(cells, 1.0)
        assert cast_ray(grid, start[0, 0], start[0, 1], 1.0, 1.0, np.inf) == expected
        assert naive.traverse(cells, 1.0, 5.5, 5.5, 1.0, 1.0, np.inf) == expected


def test_from_walls_and_from_outside_it_is_nought() -> None:
    cells = room()
    cells[3, 4] = 1
    poses = [
        [4.5, 3.5, 0.3],
        [4.0, 3.0, 2.0],
        [-0.1, 5, 0],
        [30.0, 5, 0],
        [5, 20.0, 0],
        [1e300, 0, 0],
        [-np.inf, 1, 0],
    ]
    assert not both(cells, 1.0, poses, np.linspace(0, 6, 9)).any()


def test_range_nought_and_huge() -> None:
    cells = room()
    cells[10, 20] = 1
    poses = [[20.0, 3.0, 0.0], [21.0, 10.5, np.pi], [3, 3, 0.2], [20.5, 10.5, 1.0]]
    out = both(cells, 1.0, poses, np.array([0.0, 1.0]), 0.0)
    assert out[1, 0] == 0.0
    assert np.isinf(out[0]).all()
    assert not out[3].any()
    assert np.isfinite(both(cells, 1.0, poses, np.array([0.0, 1.0]), 1e308)).all()
    per_row = both(cells, 1.0, poses, np.array([0.0, 1.0]), np.array([1.0, 2.0, 3.0, 30.0]))
    assert np.isinf(per_row[2]).all()


def test_a_range_ends_exactly_at_the_wall() -> None:
    cells = room()
    cells[:, 20] = 1
    pose = [[5.5, 10.5, 0.0]]
    assert both(cells, 1.0, pose, np.array([0.0]), 14.5)[0, 0] == 14.5
    assert both(cells, 1.0, pose, np.array([0.0]), np.nextafter(14.5, 0))[0, 0] == np.inf


def test_nan_gives_nan_and_nothing_loops() -> None:
    cells = room()
    poses = np.array([[np.nan, 1, 0], [1, np.nan, 0], [1, 1, np.nan], [1, 1, np.inf], [1, 1, 0]])
    out = both(cells, 1.0, poses, np.array([0.0, 1.0]))
    assert np.isnan(out[:4]).all()
    assert np.isfinite(out[4]).all()
    grid = grid_from_array(cells, 1.0)
    assert math.isnan(cast_ray(grid, 1.0, 1.0, np.nan, 1.0, 5.0))
    assert cast_ray(grid, 1.0, 1.0, 0.0, 0.0, 5.0) == np.inf


@pytest.mark.parametrize("tiny", [5e-324, 1e-310, 1e-101, 1e-99, 1e-17, 1e-9])
def test_directions_all_but_along_an_axis(tiny: float) -> None:
    cells = room(200, 300)
    cells[100, 250] = 1
    grid = grid_from_array(cells, 0.1)
    for x, y in (
        (0.0, 0.0),
        (5.05, 10.05),
        (5.0, 10.0),
        (5.0, 10.1),
        (5.0, 10.099999999999998),
        (24.9, 10.0),
    ):
        for dx in (0.0, tiny, -tiny, 1.0, -1.0):
            for dy in (0.0, tiny, -tiny, 1.0, -1.0):
                for reach in (np.inf, 2.0):
                    expected = naive.traverse(cells, 0.1, x, y, dx, dy, reach)
                    assert cast_ray(grid, x, y, dx, dy, reach) == expected


def test_beams_of_their_own_for_every_row() -> None:
    rng = np.random.default_rng(5)
    cells = random_cells(rng, 300, 300)
    cells[150, :] = 1
    poses = random_poses(rng, cells, 0.01, 50)
    both(cells, 0.01, poses, rng.random((50, 7)) * 6, rng.random(50) * 3)


def test_a_turned_map_reads_as_an_unturned_one() -> None:
    cells = room()
    cells[10, 20] = 1
    straight = both(cells, 1.0, [[5.5, 10.5, 0.3]], np.linspace(-1, 1, 21))
    yaw = 0.7
    c, s = math.cos(yaw), math.sin(yaw)
    pose = [[3 + c * 5.5 - s * 10.5, -2 + s * 5.5 + c * 10.5, 0.3 + yaw]]
    turned = both(cells, 1.0, pose, np.linspace(-1, 1, 21), origin=(3.0, -2.0, yaw))
    np.testing.assert_allclose(turned, straight, rtol=1e-12)


def test_no_yaw_is_exact_subtraction() -> None:
    cells = room()
    x, y = 0.1 + 0.2, 7.7
    out = both(cells, 1.0, [[x + 3.3, y - 9.1, 0.0]], np.array([0.0]), origin=(3.3, -9.1, 0.0))
    assert out[0, 0] == 30.0 - ((x + 3.3) - 3.3)


coordinates = st.one_of(st.floats(-0.5, 6.5), st.sampled_from([i * 0.1 for i in range(60)]), st.integers(0, 6))
components = st.one_of(st.floats(-1, 1), st.sampled_from([0.0, 1.0, -1.0, 0.6, 0.8, -0.6, 2**-0.5, -(2**-0.5)]))


@settings(max_examples=500, deadline=None)
@given(coordinates, coordinates, components, components, st.integers(0, 3))
def test_any_ray_jumps_as_it_walks(x: float, y: float, dx: float, dy: float, seed: int) -> None:
    cells = (np.random.default_rng(seed).random((60, 60)) < [0.0, 0.001, 0.01, 0.1][seed]).astype(np.uint8)
    grid = grid_from_array(cells, 0.1)
    for range_max in (np.inf, 2.0):
        jumped = cast_ray(grid, float(x), float(y), dx, dy, range_max)
        assert jumped == naive.traverse(cells, 0.1, float(x), float(y), dx, dy, range_max)
        assert jumped == np.inf or 0.0 <= jumped <= range_max


def test_points_are_occupied_as_their_cells_are() -> None:
    rng = np.random.default_rng(6)
    cells = (rng.random((50, 70)) < 0.3).astype(np.uint8)
    grid = grid_from_array(cells, 0.1)
    points = rng.random((1000, 2)) * [9, 7] - 1
    out = np.empty(1000, dtype=np.bool_)
    occupied_points(grid, *UNTURNED, points, out)
    for (x, y), answer in zip(points, out, strict=True):
        inside = 0 <= x < 7 and 0 <= y < 5
        assert answer == (bool(cells[int(y / 0.1), int(x / 0.1)]) if inside else True)
    occupied_points(grid, *UNTURNED, np.array([[np.nan, 1.0]]), out[:1])
    assert out[0]
