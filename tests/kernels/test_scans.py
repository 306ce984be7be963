"""Scans whose beams help one another read the same bits as rays cast one by one, and as rays that walk."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from amorsim.core.maps.map import Map
from amorsim.kernels.grid.segment_boxes import index_segments, no_segments
from amorsim.kernels.raycast.rays import cast
from amorsim.kernels.raycast.scans import cast_scans, sorted_beams
from amorsim.maps.wld import Wld
from tests import naive

WORLDS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "wld"
FAN = np.linspace(-np.pi / 2, np.pi / 2, 181)


def scanned(world: Map, poses: np.ndarray, bearings: np.ndarray, range_max: float | np.ndarray = 8.0) -> np.ndarray:
    """Distances by `cast_scans`, after a check that rays cast one by one have the same bits."""
    poses = np.ascontiguousarray(poses, dtype=np.float64)
    bearings = np.atleast_2d(bearings)
    cosines, sines = np.cos(bearings), np.sin(bearings)
    reach = np.atleast_1d(np.asarray(range_max, dtype=np.float64))
    out, alone = np.full((2, len(poses), bearings.shape[1]), -1.0)
    beams = sorted_beams(cosines, sines, len(poses))
    cast_scans(*world.grid, *world.segment_index, *world.origin, poses, *beams, reach, out)
    cast(world.grid, *world.origin, poses, cosines, sines, reach, alone)
    differ = np.argwhere(out.view(np.int64) != alone.view(np.int64))
    for n, k in differ[:1]:
        pytest.fail(
            f"{len(differ)} of {out.size} differ; pose {poses[n].tolist()}, beam {k}: {out[n, k]}, alone {alone[n, k]}"
        )
    return out


def walked(world: Map, poses: np.ndarray, bearings: np.ndarray, range_max: float) -> np.ndarray:
    """Distances by the plain twin."""
    bearings = np.atleast_2d(bearings)
    reach = np.array([range_max])
    return naive.cast(
        world.to_array(), world.resolution, world.origin, poses, np.cos(bearings), np.sin(bearings), reach
    )


def random_walls(rng: np.random.Generator, count: int, size: float, resolution: float) -> np.ndarray:
    """Walls of all kinds: askew, along the axes, on borders of cells, points, doubles, and a frame."""
    start = rng.random((count, 2)) * size
    angle = rng.choice([0.0, np.pi / 2, np.pi / 4], count)
    angle[::2] = rng.random(len(angle[::2])) * 7
    length = rng.exponential(size / 8, count)
    length[::9] = 0.0
    walls = np.column_stack([start, start + length[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])])
    walls[::3] = np.round(walls[::3] / resolution) * resolution
    return np.concatenate([walls, walls[:2], [[0, 0, size, 0], [0, 0, 0, size]]])


def random_poses(rng: np.random.Generator, world: Map, count: int) -> np.ndarray:
    """Poses all over a world and a little around it, many on walls, beside them, in line with them, or on borders."""
    width, height = world.size
    poses = np.column_stack([rng.random((count, 2)) * [width, height] * 1.02, rng.random(count) * 8 - 4])
    poses[:, :2] += world.origin[:2]
    walls = np.asarray(world.segments)[rng.integers(0, len(world.segments), count)]
    along = rng.random(count)[:, None] * 3 - 1
    beside = rng.choice([0.0, 0.5, 1.0, 1.3, 2.0, 2.5, 5.0], (count, 2)) * rng.choice([-1, 1], (count, 2))
    near = walls[:, :2] + along * (walls[:, 2:] - walls[:, :2]) + beside * world.resolution
    poses[1::3, :2] = near[1::3]
    poses[2::6, :2] = np.round(poses[2::6, :2] / world.resolution) * world.resolution
    poses[::5, 2] = rng.integers(-4, 5, len(poses[::5])) * (np.pi / 4)
    return poses


def compare_on_random_walls(worlds: int, poses: int, seed: int) -> int:
    rng = np.random.default_rng(seed)
    fans = [
        FAN,
        np.linspace(-np.pi, np.pi, 97),
        rng.random(64) * 20 - 10,
        np.concatenate([np.arange(4) * (np.pi / 2), np.arange(30) * 1e-7, [1e-9, -1e-13]]),
        np.linspace(3, -3, 12),
        np.zeros(1),
    ]
    rays = 0
    for w in range(worlds):
        resolution = float(rng.choice([0.001, 0.01, 0.05, 1 / 3]))
        # At most a few thousand cells across, so that the twin can walk them.
        size = float(resolution * rng.choice([40, 300, 2000]))
        walls = random_walls(rng, int(rng.choice([1, 8, 40, 150])), size, resolution)
        world = Map.from_segments(walls + rng.normal() * np.tile(rng.random(2) * 10, 2), resolution=resolution)
        starts = random_poses(rng, world, poses)
        fan = fans[w % len(fans)]
        reach = float(rng.choice([np.inf, 8.0, size / 3, 3 * resolution, 1e300]))
        out = scanned(world, starts, fan, reach)
        expected = walked(world, starts, fan, reach)
        np.testing.assert_array_equal(out.view(np.int64), expected.view(np.int64))
        rays += out.size
    return rays


def test_scans_read_what_walking_reads() -> None:
    assert compare_on_random_walls(worlds=36, poses=30, seed=0) > 50_000


@pytest.mark.long
def test_scans_read_what_walking_reads_a_million_times() -> None:
    assert compare_on_random_walls(worlds=240, poses=150, seed=1) > 1_000_000


def on_world(name: str, poses: int) -> None:
    if not WORLDS.is_dir():
        pytest.skip("the real maps are not here")
    world = Wld().load(WORLDS / name)
    assert world.resolution == 0.001
    rng = np.random.default_rng(2)
    starts = random_poses(rng, world, poses)
    for fan in (FAN, np.linspace(-np.pi, np.pi, 361)):
        out = scanned(world, starts, fan)
        assert np.isfinite(out).mean() > 0.1
    scanned(world, starts, FAN + rng.normal(0.0, 0.002, (poses, 181)), rng.random(poses) * 10)


@pytest.mark.parametrize("name", ["serp-sm.wld", "uwa-ee4.wld"])
def test_real_worlds(name: str) -> None:
    on_world(name, poses=60)


@pytest.mark.long
@pytest.mark.parametrize(
    "name", ["serp-sm.wld", "serp.wld", "table.wld", "hallway.wld", "uwa-ee4.wld", "concentric.wld"]
)
def test_real_worlds_at_length(name: str) -> None:
    on_world(name, poses=2000)


def a_room() -> Map:
    return Map.from_segments([[0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0], [2, 1, 3, 2.5]])


def test_walls_are_believed_and_no_beam_starts_at_its_pose() -> None:
    room = a_room()
    poses = np.array([[1.0, 2.0, 0.3], [4.0, 3.0, -2.0]])
    right = scanned(room, poses, FAN)
    # An index that has walls too far away makes beams start behind them: so the agreement elsewhere is not the march's.
    wrong = index_segments(np.empty((0, 4)), room.shape[0] * 2, room.shape[1] * 2, room.resolution)
    out, beams = np.empty_like(right), sorted_beams(np.cos(FAN)[None], np.sin(FAN)[None], len(poses))
    for lines, same in ((no_segments(), True), (wrong, False)):
        cast_scans(*room.grid, *lines, *room.origin, poses, *beams, np.array([8.0]), out)
        assert bool((out == right).all()) == same


def test_order_and_company_of_beams_do_not_matter() -> None:
    room = a_room()
    rng = np.random.default_rng(3)
    poses = random_poses(rng, room, 40)
    bearings = rng.random(100) * 7
    ranges = scanned(room, poses, bearings)
    order = rng.permutation(100)
    np.testing.assert_array_equal(scanned(room, poses, bearings[order]), ranges[:, order])
    np.testing.assert_array_equal(scanned(room, poses, np.tile(bearings, (40, 1))), ranges)
    np.testing.assert_array_equal(scanned(room, poses, bearings[:3]), ranges[:, :3])
    np.testing.assert_array_equal(scanned(room, poses[7:8], bearings), ranges[7:8])


def test_ends_of_the_range_and_numbers_that_are_none() -> None:
    room = a_room()
    pose = np.array([[1.0, 2.0, 0.0]])
    wall = float(scanned(room, pose, np.zeros(20), np.inf)[0, 0])
    assert wall == pytest.approx(1.666, abs=0.002)
    assert (scanned(room, pose, np.zeros(20), wall) == wall).all()
    assert np.isinf(scanned(room, pose, np.zeros(20), np.nextafter(wall, 0.0))).all()
    assert np.isinf(scanned(room, pose, FAN, 0.0)).all()
    beams = FAN.copy()
    beams[[3, 100]] = np.nan
    assert (np.isnan(scanned(room, pose, beams)) == np.isnan(beams)).all()
    strange = np.array([[np.nan, 1, 0], [1, 1, np.nan], [-1, 1, 0], [1e300, 1, 0], [0.0, 0.0, 1.0], [2.0, 1.0, 0.0]])
    out = scanned(room, strange, FAN)
    assert np.isnan(out[:2]).all()
    assert not out[2:].any()


@pytest.mark.parametrize("bad", [np.inf, -np.inf, np.nan, 1e308])
def test_beams_of_no_direction_are_sorted_without_harm(bad: float) -> None:
    cosines = np.tile(np.cos(FAN), (3, 1))
    sines = np.tile(np.sin(FAN), (3, 1))
    cosines[1] = sines[1] = bad
    order, cos_s, _, starts = sorted_beams(cosines, sines, 3)
    for scan in range(3):
        assert sorted(order[scan].tolist()) == list(range(len(FAN)))
        assert (starts[scan, 0], starts[scan, -1]) == (0, len(FAN))
    np.testing.assert_array_equal(cos_s[0, : len(FAN)], cosines[0, order[0]])


def test_a_large_world_of_many_walls() -> None:
    rng = np.random.default_rng(4)
    start = rng.random((6000, 2)) * 300
    angle, length = rng.random(6000) * 7, rng.random(6000) * 3
    ends = start + length[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    world = Map.from_segments(np.column_stack([start, ends]), resolution=0.005)
    assert world.segment_index.boxes.shape[1] > 100
    poses = random_poses(rng, world, 60)
    assert np.isfinite(scanned(world, poses, FAN)).mean() > 0.2
    # So many walls are within this range that beams go alone.
    scanned(world, poses, FAN, math.inf)


def test_every_wall_is_in_one_block_and_its_cells_in_the_box() -> None:
    rng = np.random.default_rng(5)
    walls = random_walls(rng, 500, 20.0, 0.05)
    lines = index_segments(walls, 400, 400, 0.05)
    assert lines.first[0] == 0
    assert lines.first[-1] == lines.walls.shape[1] == len(walls) + 4  # and the border
    assert (np.diff(lines.first) > 0).all()
    block = np.repeat(np.arange(lines.boxes.shape[1]), np.diff(lines.first))
    begin = lines.walls[:2].T
    for end in (begin, begin + (lines.walls[2:4] * lines.walls[4]).T):
        assert (end - lines.walls[5][:, None] >= lines.boxes[:2, block].T).all()
        assert (end + lines.walls[5][:, None] <= lines.boxes[2:, block].T).all()
    assert (lines.walls[5] >= 0.05).mean() > 0.5
