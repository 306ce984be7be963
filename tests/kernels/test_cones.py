"""A cone's nearest return against the definition: the least over its rays, cast one by one."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.maps.map import Map
from amorsim.kernels.grid.segment_boxes import index_segments
from amorsim.kernels.kinematics import poses as pose_kernels
from amorsim.kernels.raycast import rays
from amorsim.kernels.raycast.cones import cast_cones
from amorsim.simulation.world.directions import cone_bearings
from tests.examples import settings
from tests.kernels.test_outlines import random_cells
from tests.kernels.test_scans import random_poses, random_walls

NO_RAYS = np.empty(0, dtype=np.int64)


def both(map_: Map, poses: np.ndarray, half_angle: float, range_max: float) -> tuple[np.ndarray, np.ndarray]:
    least, every = by_rays(map_, poses, half_angle, cone_bearings(half_angle), range_max, NO_RAYS)
    return least, every.min(axis=1)


def check(map_: Map, poses: np.ndarray, half_angle: float, range_max: float) -> np.ndarray:
    """The least ranges, after a comparison of both ways to get them; of 31 rays also which ray it is."""
    fan = half_angle * np.linspace(-1.0, 1.0, 31)[None, :]
    ray = np.full(len(poses), -1)
    least, every = by_rays(map_, poses, half_angle, fan, range_max, ray)
    np.testing.assert_array_equal(least, every.min(axis=1))
    np.testing.assert_array_equal(ray, every.argmin(axis=1))
    least, expected = both(map_, poses, half_angle, range_max)
    np.testing.assert_array_equal(least, expected)
    return expected


def by_rays(
    map_: Map, poses: np.ndarray, half_angle: float, bearings: np.ndarray, range_max: float, ray: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    cos_b, sin_b = np.empty(bearings.shape), np.empty(bearings.shape)
    pose_kernels.directions(bearings, cos_b, sin_b)
    limits = np.full(len(poses), range_max)
    every, least = np.empty((len(poses), bearings.shape[1])), np.empty(len(poses))
    rays.cast(map_.grid, *map_.origin, poses, cos_b, sin_b, limits, every)
    cast_cones(*map_.grid, *map_.segment_index, *map_.origin, poses, half_angle, cos_b, sin_b, limits, least, ray)
    return least, every


def clutter(seed: int, resolution: float, yaw: float = 0.0, share: float = 0.003) -> Map:
    cells = np.random.default_rng(seed).random((300, 400)) < share
    return Map.from_array(cells, resolution=resolution, origin=(-1.0, 2.0, yaw))


def somewhere(map_: Map, seed: int, count: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    x, y, yaw = map_.origin
    inside = rng.uniform((0.0, 0.0), map_.size, (count, 2))
    turned = inside @ np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
    return np.column_stack((turned + np.array([x, y]), rng.uniform(-math.pi, math.pi, count)))


@pytest.mark.parametrize("half_deg", [0.02, 0.5, 7.5, 15.0, 40.0, 85.0, 100.0])
@pytest.mark.parametrize("resolution", [0.001, 0.05])
def test_in_clutter_the_bits_are_the_same(half_deg: float, resolution: float) -> None:
    for seed, yaw in ((1, 0.0), (2, 0.7)):
        map_ = clutter(seed, resolution, yaw)
        poses = somewhere(map_, seed, 60)
        for range_max in (20 * resolution, 1000 * resolution):
            check(map_, poses, math.radians(half_deg), range_max)


def test_in_the_office_the_bits_are_the_same() -> None:
    map_ = am.load("demo").map
    expected = check(map_, somewhere(map_, 3, 400), math.radians(15.0), 5.0)
    assert 0.3 < np.isfinite(expected).mean() <= 1.0


def compare_in_line_worlds(worlds: int, poses: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(worlds):
        resolution = float(rng.choice([0.001, 0.01, 0.05, 1 / 3]))
        size = float(resolution * rng.choice([40, 300, 2000]))
        walls = random_walls(rng, int(rng.choice([1, 8, 40, 150])), size, resolution)
        # Nearly along an axis: into the next row of cells, or within a rounding of a grid line.
        walls[1::7, 3] = walls[1::7, 1] + rng.choice([0.0, 0.4, 1e-6, -2e-6], len(walls[1::7])) * resolution
        map_ = Map.from_segments(walls + rng.normal() * np.tile(rng.random(2) * 10, 2), resolution=resolution)
        half_angle = math.radians(float(rng.choice([0.0, 0.3, 5.0, 15.0, 60.0, 85.0])))
        reach = float(rng.choice([np.inf, 8.0, size / 3, 3 * resolution]))
        check(map_, random_poses(rng, map_, poses), half_angle, reach)


def test_among_walls_of_all_kinds_the_bits_are_the_same() -> None:
    compare_in_line_worlds(worlds=40, poses=24, seed=0)


@pytest.mark.nightly
def test_among_walls_of_all_kinds_the_bits_are_the_same_at_length() -> None:
    compare_in_line_worlds(worlds=1500, poses=100, seed=1)


def compare_in_bitmaps(worlds: int, poses: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for m in range(worlds):
        cells = random_cells(rng)
        if cells.all():
            continue
        resolution = float(rng.choice([0.001, 0.05, 1 / 3]))
        map_ = Map.from_array(cells, resolution=resolution, origin=(0.0, 0.0, 0.7 * (m % 3)))
        free = np.argwhere(cells == 0)
        # At grid lines, all but at them, and anywhere.
        within = rng.choice([0.0, 0.5, 1e-9, 1.0 - 1e-9], (poses, 2)) + rng.random((poses, 2)) * (m % 2)
        places = (free[rng.integers(0, len(free), poses), ::-1] + within) * resolution
        c, s = np.cos(map_.origin[2]), np.sin(map_.origin[2])
        heading = rng.random(poses) * 7
        heading[::3] = rng.integers(-4, 5, len(heading[::3])) * (np.pi / 4)
        starts = np.column_stack([places @ np.array([[c, s], [-s, c]]), heading + map_.origin[2]])
        half_angle = math.radians(float(rng.choice([0.3, 5.0, 15.0, 60.0, 85.0])))
        reach = float(rng.choice([np.inf, 8.0, 50 * resolution]))
        least, expected = both(map_, starts, half_angle, reach)
        np.testing.assert_array_equal(least.view(np.int64), expected.view(np.int64))


def test_among_boxes_of_all_kinds_the_bits_are_the_same() -> None:
    compare_in_bitmaps(worlds=60, poses=24, seed=2)


@pytest.mark.nightly
def test_among_boxes_of_all_kinds_the_bits_are_the_same_at_length() -> None:
    compare_in_bitmaps(worlds=1500, poses=100, seed=3)


def test_walls_are_believed() -> None:
    # A wall index in the wrong place changes the readings: so the agreement elsewhere does not come from the cells.
    map_ = Map.from_segments([[0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0], [2, 1, 3, 2.5]])
    poses = somewhere(map_, 4, 20)
    least, expected = both(map_, poses, 0.26, 5.0)
    np.testing.assert_array_equal(least, expected)
    wrong = index_segments(np.empty((0, 4)), map_.shape[0] * 2, map_.shape[1] * 2, map_.resolution)
    assert (both(attrs.evolve(map_, segment_index=wrong), poses, 0.26, 5.0)[0] != expected).mean() > 0.5


def test_boxes_are_believed() -> None:
    # A box where no wall is, in front of the real walls: its reading comes from its lines, not from cells or rays.
    map_ = Map.from_segments([[0, 0, 6, 0], [6, 0, 6, 4], [6, 4, 0, 4], [0, 4, 0, 0]], resolution=0.01)
    pose = np.array([[2.0, 2.0, 0.0]])
    expected = check(map_, pose, 0.26, 5.0)
    walls = map_.segment_index.walls.copy()
    (east,) = np.flatnonzero((walls[6] < walls[8]) & (walls[6] > 500) & (walls[6] < map_.shape[1]))
    walls[6, east] -= 100.0
    wrong = attrs.evolve(map_, segment_index=map_.segment_index._replace(walls=walls))
    assert both(wrong, pose, 0.26, 5.0)[0] == pytest.approx(expected - 1.0)


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2, math.pi / 4])
@pytest.mark.parametrize("start", [(0.5, 0.5), (1.0, 1.0), (0.3, 1.0), (0.001, 0.001), (1.999, 0.25)])
def test_along_axes_borders_and_corners(heading: float, start: tuple[float, float]) -> None:
    walls = np.array([[0.0, 0.0, 2.0, 0.0], [0.0, 2.0, 2.0, 2.0], [1.5, 0.5, 1.5, 1.5]])
    for resolution in (0.001, 0.25):
        map_ = Map.from_segments(walls, resolution=resolution)
        poses = np.array([[*start, heading]])
        for half_deg in (5.0, 15.0, 60.0):
            check(map_, poses, math.radians(half_deg), 10.0)


def test_where_there_is_no_wall_the_end_of_the_map_is_heard() -> None:
    map_ = Map.from_segments(np.empty((0, 4)), resolution=0.001, extent=(0.0, 0.0, 3.0, 2.0))
    least = check(map_, np.array([[1.0, 1.0, 0.4], [2.9, 1.9, 2.0], [9.0, 9.0, 0.0]]), 0.2, 10.0)
    assert np.isfinite(least).all()
    assert least[2] == 0.0


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 10_000),
    half_deg=st.floats(0.1, 80.0),
    range_max=st.floats(0.0, 1.0),
    share=st.sampled_from([0.0, 0.0005, 0.05]),
)
def test_anything(seed: int, half_deg: float, range_max: float, share: float) -> None:
    map_ = clutter(seed, 0.001, share=share)
    check(map_, somewhere(map_, seed, 8), math.radians(half_deg), range_max)


def test_a_range_that_ends_just_at_the_wall_still_hears_it() -> None:
    map_ = clutter(5, 0.001)
    poses = somewhere(map_, 5, 50)
    _, expected = both(map_, poses, math.radians(10.0), 10.0)
    for pose, distance in zip(poses, expected, strict=True):
        least, _ = both(map_, pose[None], math.radians(10.0), float(distance))
        assert least[0] == distance


def test_nan_gives_nan() -> None:
    least, _ = both(clutter(1, 0.001), np.array([[np.nan, 2.1, 0.0], [-0.9, 2.1, np.nan]]), 0.2, 5.0)
    assert np.isnan(least).all()
