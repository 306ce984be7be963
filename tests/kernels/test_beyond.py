"""Beams whose near ends do not matter have the bits of rays cast one by one, or 0 where those end too soon."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.core.maps.map import Map
from amorsim.kernels.raycast.beyond import cast_beyond
from amorsim.kernels.raycast.rays import cast
from tests.kernels.test_scans import random_poses, random_walls

FAN = np.linspace(-0.26, 0.26, 61)
ROOM = [[0, 0, 9, 0], [9, 0, 9, 6], [9, 6, 0, 6], [0, 6, 0, 0], [4, 0, 4, 2.4], [4, 3.4, 4, 6], [6, 5, 7, 5]]


def world_of(walls: object, resolution: float = 0.05) -> Map:
    return Map.from_segments(np.asarray(walls, dtype=np.float64), resolution=resolution)


def both(
    world: Map, poses: np.ndarray, bearings: np.ndarray, nearest: np.ndarray, reach: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Distances by `cast_beyond`, and those of rays cast one by one."""
    bearings = np.atleast_2d(bearings)
    beams = np.cos(bearings), np.sin(bearings)
    out, alone = np.full((2, len(poses), bearings.shape[1]), -1.0)
    cast_beyond(*world.grid, *world.segment_index, *world.origin, poses, *beams, nearest, reach, out)
    cast(world.grid, *world.origin, poses, *beams, reach, alone)
    return out, alone


def check(world: Map, poses: np.ndarray, bearings: np.ndarray, nearest: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """Which beams `(N, k)` were not cast, after a check that no other differs from a ray by itself."""
    out, alone = both(world, poses, bearings, nearest, reach)
    differ = out.view(np.int64) != alone.view(np.int64)
    assert (out[differ] == 0.0).all()
    _, ends = both(world, poses, bearings, nearest, np.full(len(poses), math.inf))
    assert ((ends < nearest) | (nearest == math.inf))[differ].all()
    return differ


@pytest.mark.parametrize("seed", range(24))
def test_only_beams_that_end_too_soon_are_left_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    resolution = float(rng.choice([0.01, 0.05, 1 / 3]))
    size = float(resolution * rng.choice([40, 300]))
    walls = random_walls(rng, int(rng.choice([8, 40, 150])), size, resolution)
    world = world_of(walls + rng.normal() * np.tile(rng.random(2) * 10, 2), resolution)
    fans = FAN, rng.random(20) * 20 - 10, np.linspace(-np.pi, np.pi, 97), np.zeros(1), rng.uniform(-1, 1, (40, 33))
    bearings = fans[seed % len(fans)]
    poses = random_poses(rng, world, 40)
    poses[7] = math.nan
    nearest = rng.exponential(size / 3, (40, bearings.shape[-1]))
    nearest[rng.random(nearest.shape) < 0.2] = math.inf
    nearest[rng.random(nearest.shape) < 0.1] = -1.0
    reach = rng.choice([math.inf, size / 2, size, -1.0], 40)
    assert check(world, poses, bearings, nearest, reach).any()


def test_few_beams_of_a_room_are_cast() -> None:
    """All that end nearer than asked by more than a cell, but those that pass a wall's edge or a corner by a hair."""
    rng = np.random.default_rng(0)
    world = world_of(ROOM)
    poses = np.column_stack([rng.uniform(0.2, 3.8, 400), rng.uniform(0.2, 5.8, 400), rng.uniform(-4, 4, 400)])
    nearest, reach = np.full((400, 61), 4.0), np.full(400, 8.0)
    left_out = check(world, poses, FAN, nearest, reach)
    _, alone = both(world, poses, FAN, nearest, reach)
    ends_soon = alone < 4.0 - world.resolution
    assert (alone >= 4.0).sum() > 1000
    assert left_out[ends_soon].mean() > 0.999


def test_what_is_known_of_one_place_serves_only_places_near_it() -> None:
    """The second pose is farther away than the boxes that were found for the first."""
    world = world_of([[0, 0, 60, 0], [60, 0, 60, 4], [60, 4, 0, 4], [0, 4, 0, 0]])
    poses = np.array([[2.0, 2.0, 0.0], [57.0, 2.0, 0.0], [2.5, 2.0, math.pi]])
    left_out = check(world, poses, FAN, np.full((3, 61), 5.0), np.full(3, 80.0))
    assert left_out.sum(axis=1).tolist() == [0, 61, 61]


def test_walls_askew_are_cast() -> None:
    """Their cells are no boxes, and may be free."""
    world = world_of([[0, 0, 20, 0], [20, 0, 20, 20], [20, 20, 0, 20], [0, 20, 0, 0], [11, 6, 12, 14]])
    out, alone = both(world, np.array([[10.0, 10.0, 0.1]]), FAN, np.full((1, 61), 5.0), np.array([8.0]))
    np.testing.assert_array_equal(out, alone)
    assert (out < 2.0).all()
