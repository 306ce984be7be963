"""Cones against bodies: the bits of the least of all their beams."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.core.shapes import Shape
from amorsim.kernels.raycast.body_cones import nearest_bodies
from amorsim.simulation.world.directions import cone_bearings
from tests.examples import settings
from tests.kernels.test_body_rays import SHAPES, Scene, random_scene
from tests.some_cases import one_in

WIDTHS = [0.0, 0.01, 0.03, 0.06, 0.5, 15.0, 45.0, 90.0, 100.0, 170.0, 180.0]  # degrees, half of each cone


def nearest(scene, origins, half, *, own=-1, replica=0, range_max=math.inf, walls=math.inf):
    """What the kernel finds, of cones of half this angle."""
    origins = np.array(origins, dtype=float).reshape(-1, 3)
    rows, bearings = len(origins), cone_bearings(half)
    out = np.broadcast_to(np.asarray(walls, dtype=float), (rows,)).copy()
    nearest_bodies(
        *scene.around(rows, own, replica),
        origins,
        half,
        np.cos(bearings),
        np.sin(bearings),
        np.broadcast_to(np.asarray(range_max, dtype=float), (rows,)).copy(),
        out,
    )
    return out


def least_of_beams(scene, origins, half, *, walls=math.inf, **asked):
    """The same of every beam by itself."""
    walls = np.broadcast_to(np.asarray(walls, dtype=float), (len(origins),))[:, None]
    ranges, _ = scene.cast(origins, cone_bearings(half), walls=walls, **asked)
    return ranges.min(axis=1)


@pytest.mark.parametrize("spread", [0.3, 3.0, 8.0])
@pytest.mark.parametrize("half_deg", one_in(3, WIDTHS))
def test_a_cone_reads_the_least_of_its_beams(half_deg, spread):
    """Of bodies ahead, aside, behind and around; behind walls, and beyond the range; whoever carries the sensor."""
    half = math.radians(half_deg)
    scene, rng = random_scene(1, count=30, spread=spread)
    origins = np.c_[rng.uniform(-spread, spread, (200, 2)), rng.uniform(-4, 4, 200)]
    asked = {"own": rng.integers(-1, 30, 200), "walls": rng.uniform(0, 9, 200)}
    seen = 0
    for range_max in (0.0, 0.5, rng.uniform(0, 6, 200), math.inf):
        found = nearest(scene, origins, half, **asked, range_max=range_max)
        np.testing.assert_array_equal(found, least_of_beams(scene, origins, half, **asked, range_max=range_max))
        seen += (found < asked["walls"]).sum()
    assert seen > 20


@pytest.mark.parametrize("index", range(len(SHAPES)))
@pytest.mark.parametrize("half_deg", [0.06, 15.0, 90.0, 180.0])
def test_one_body_at_any_distance_reads_the_least_of_the_beams(half_deg, index):
    """From close to its border on, where the nearest point moves far as the sensor moves little."""
    half, shape = math.radians(half_deg), SHAPES[index]
    rng = np.random.default_rng(2)
    away = np.repeat([1e-15, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5, 1e-3, 0.1, 1.0, 100.0, 1e5], 40)
    scene = Scene([shape], [(0.7, -0.3, 0.9)])
    ahead = rng.uniform(-4, 4, len(away))
    far = np.c_[0.7 + 9.0 * np.cos(ahead), -0.3 + 9.0 * np.sin(ahead), ahead + math.pi + rng.normal(0, 0.02, len(away))]
    reach, _ = scene.cast(far, [0.0])
    assert np.isfinite(reach).sum() > 50
    where = np.where(np.isfinite(reach), reach, 9.0) - away[:, None]
    origins = (
        far + np.c_[where * np.c_[np.cos(far[:, 2]), np.sin(far[:, 2])], rng.normal(0, 1.5 * half + 0.1, len(away))]
    )
    np.testing.assert_array_equal(nearest(scene, origins, half), least_of_beams(scene, origins, half))


@settings(deadline=None)
@given(
    st.integers(0, 10**6),
    st.floats(0.0, math.pi),
    st.sampled_from([0.0, 1e3, 1e6]),
    st.sampled_from([1e-9, 1e-3, 1.0, 30.0]),
)
def test_polygons_of_any_size_and_place_read_the_least_of_the_beams(seed, half, far, size):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * math.pi, 7))
    while (np.diff(angles, append=angles[0] + 2 * math.pi) > 3.0).any():
        angles = np.sort(rng.uniform(0, 2 * math.pi, 7))
    radii = rng.uniform(0.5, 1.0) * np.r_[1.0, rng.uniform(0.2, 1.0)] * (0.5 + 1e-3 * size)
    corners = np.c_[radii[0] * np.cos(angles), radii[1] * np.sin(angles)]
    rounding = float(rng.choice([0.0, 0.1 * radii.min()]))
    shape = Shape.polygon(corners.tolist(), rounding=rounding)
    scene = Scene([shape], [(far, -far, rng.uniform(-4, 4))])
    ways = rng.uniform(-4, 4, 30)
    reach = shape.reach + size * rng.uniform(0, 1, 30)
    origins = np.c_[far + reach * np.cos(ways), -far + reach * np.sin(ways), ways + rng.normal(math.pi, half + 0.3, 30)]
    np.testing.assert_array_equal(nearest(scene, origins, half), least_of_beams(scene, origins, half))


@pytest.mark.parametrize("spread", [0.3, 3.0, 40.0])
@pytest.mark.parametrize("buckets", [(2, 2), (8, 16), (64, 64)])
def test_a_hash_of_bodies_changes_no_bit(spread, buckets):
    rng = np.random.default_rng(3)
    shapes = [SHAPES[i] for i in rng.integers(0, len(SHAPES), 200)]
    poses = np.c_[rng.uniform(-spread, spread, (200, 2)), rng.uniform(-4, 4, 200)]
    plain, hashed = (Scene(shapes, poses, [0, 0, 140, 200], b) for b in ((1, 1), buckets))
    origins = np.c_[rng.uniform(-spread, spread, (60, 2)), rng.uniform(-4, 4, 60)]
    asked = {"own": rng.integers(-1, 200, 60), "replica": rng.integers(0, 3, 60), "walls": rng.uniform(0, 9, 60)}
    for range_max in (0.0, 0.5, rng.uniform(0, 6, 60), math.inf):
        found = nearest(hashed, origins, 0.26, **asked, range_max=range_max)
        np.testing.assert_array_equal(found, nearest(plain, origins, 0.26, **asked, range_max=range_max))
    assert (found < asked["walls"]).any()


def test_nobody_changes_nothing():
    assert nearest(Scene([], []), [(0, 0, 0)] * 2, 0.3, walls=[1.5, math.inf]).tolist() == [1.5, math.inf]
