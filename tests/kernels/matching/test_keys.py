"""A key: the points of the last scans, in the frame of the newest."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import icp, keys
from tests.kernels.matching.scenes import HALF, room, scan

SIZE = 3 * len(HALF)


def points_of(key):
    return key.points[np.isfinite(key.points[:, 0])]


def test_a_key_keeps_what_the_newest_scan_does_not_see():
    world, first, second = room(), np.array([1.5, 1.2, 0.4]), np.array([1.6, 1.3, 0.4 + math.pi / 2.0])
    key = icp.reference(SIZE)
    for pose, moved in ((first, np.zeros(3)), (second, am.relative(first[None], second[None])[0])):
        keys.extend(scan(world, pose)[1], key, moved)
    found = points_of(key)
    alone = points_of(scan(world, second)[1])
    assert len(found) > 1.3 * len(alone)
    beams = world.cast_rays(np.repeat(second[None], 1, axis=0), np.arctan2(found[:, 1], found[:, 0]), 50.0)[0]
    assert np.abs(np.hypot(*found.T) - beams).max() < 0.2  # every point lies on a wall that can be seen from there
    lines = np.isfinite(key.lines[:, 0]).sum()
    assert (np.diff(key.along[:lines]) >= 0.0).all()
    assert np.isinf(key.along[lines:]).all()


def test_what_the_newest_scan_sees_through_is_gone():
    around = np.array([[-4, -4, 4, -4], [4, -4, 4, 4], [4, 4, -4, 4], [-4, 4, -4, -4]], dtype=float)
    box = np.array([[2.0, -0.3, 2.0, 0.3]])
    key = icp.reference(SIZE)
    for walls, is_there in ((np.concatenate((around, box)), True), (around, False)):
        world = am.Map.from_segments(walls, resolution=0.001)
        keys.extend(scan(world, (0.0, 0.0, 0.0))[1], key, np.zeros(3))
        near = np.abs(points_of(key) - (2.0, 0.0)).max(axis=1) < 0.35
        assert near.any() == is_there


@pytest.mark.parametrize("scans", [1, 5, 30])
def test_a_key_holds_so_many_points_and_the_newest_scan_whole(scans):
    world = room()
    key = icp.reference(SIZE)
    before = np.array([1.5, 1.2, 0.0])
    for n in range(scans):
        pose = np.array([1.5, 1.2, 0.5 * n])
        seen = scan(world, pose)[1]
        keys.extend(seen, key, am.relative(before[None], pose[None])[0])
        before = pose
    held, newest = points_of(key), points_of(seen)
    assert len(held) <= SIZE
    np.testing.assert_array_equal(held[-len(newest) :], newest)
