"""The correlative stage, and both stages from far off."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import correlative, icp, priors
from tests.kernels.matching.scenes import off, reference_of, room, scan

STEP = math.radians(1.0)


def drawn(points, resolution=0.04, blur=0.06):
    picture = correlative.picture(8.0, resolution, blur)
    correlative.draw(points, picture)
    return picture


def correlate(picture, points, start, window):
    out = np.empty(3)
    cells = np.empty((len(points), 2), np.int64)
    fit = correlative.correlate(picture, points, np.array(start, dtype=float), window, cells, out)
    return out, fit


def test_a_coarse_value_is_that_of_the_best_cell_in_its_block():
    picture = drawn(scan(room(), (1.5, 1.2, 0.4))[1].points)
    n = len(picture.coarse)
    blocks = picture.fine.reshape(n, correlative.BLOCK, n, correlative.BLOCK).max(axis=(1, 3))
    np.testing.assert_array_equal(picture.coarse, blocks)
    assert picture.fine.max() > 0.7


def test_it_finds_what_looking_at_every_pose_finds():
    rng = np.random.default_rng(1)
    key, moved = scan(room(), (1.5, 1.2, 0.4))[1], scan(room(), (1.6, 1.25, 0.5))[1]
    picture = drawn(key.points, resolution=0.08)
    points = np.ascontiguousarray(moved.points[rng.permutation(181)[:40]])
    window = correlative.Window(0.96, math.radians(6.0), math.radians(2.0))
    found, fit = correlate(picture, points, (0.0, 0.0, 0.0), window)
    best = -1.0
    for turn in np.radians([-6, -4, -2, 0, 2, 4, 6]):
        c, s = math.cos(turn), math.sin(turn)
        x, y = c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]
        cols, rows = (np.floor((v + 0.5 * picture.fine.shape[0] * 0.08) / 0.08).astype(int) for v in (x, y))
        for r in range(-12, 13):
            for q in range(-12, 13):
                pull = 0.05 * ((turn / math.radians(6.0)) ** 2 + (r * r + q * q) / 144.0)
                best = max(best, float(picture.fine[rows + r, cols + q].mean()) - pull)
    assert fit == pytest.approx(best, abs=1e-6)
    assert off(found, am.relative(np.array([[1.5, 1.2, 0.4]]), np.array([[1.6, 1.25, 0.5]]))[0])[0] < 0.12


def test_without_points_nothing_fits():
    picture = drawn(np.full((5, 2), np.nan))
    found, fit = correlate(picture, np.full((5, 2), np.nan), (0.3, 0.2, 0.1), correlative.Window(0.2, 0.1, STEP))
    assert fit == 0.0
    np.testing.assert_array_equal(found, [0.3, 0.2, 0.1])


def successes(count, trials, both):
    """Share of trials within 0.05 m: a scan of the office against itself, off by up to 0.2 m and 45 degrees."""
    world, rng = am.load("demo").map, np.random.default_rng(7)
    work, result = icp.work(181), icp.result()
    window = correlative.Window(0.3, math.radians(46.0), STEP)
    search = icp.Search(0.01, 0.3 if both else 2.0, 100, 1e-5)
    good = done = 0
    while done < count * trials:
        pose = rng.uniform((0.5, 0.5, -math.pi), (23.5, 15.5, math.pi))
        ranges, found = scan(world, pose)
        if world.occupied(pose[None, :2])[0] or ranges.min() < 0.25 or not world_around(world, pose):
            continue
        picture = drawn(found.points)
        for _ in range(trials):
            start = rng.uniform((-0.2, -0.2, -math.pi / 4), (0.2, 0.2, math.pi / 4))
            if both:
                start, _ = correlate(picture, found.points, start, window)
            icp.align(reference_of(found), found, start, priors.no_prior(), search, work, result)
            good += off(result.pose, np.zeros(3))[0] <= 0.05
            done += 1
    return good / done


def world_around(world, pose):
    """Whether a robot could be there: nothing within 0.3 m."""
    around = world.cast_rays(pose[None], np.arange(36) / 36.0 * 2.0 * math.pi, 8.0)
    return around.min() > 0.3


@pytest.mark.long
def test_points_on_lines_alone_come_home_from_far_off():
    assert successes(100, 10, both=False) >= 0.75


@pytest.mark.long
def test_both_stages_come_home_from_far_off():
    assert successes(100, 10, both=True) >= 0.995


@pytest.mark.long
def test_both_stages_come_home_from_far_off_in_some_places():
    assert successes(10, 3, both=True) == 1.0


def test_a_point_where_another_scan_saw_through_counts_against_a_pose():
    picture = correlative.picture(8.0, 0.04, 0.06)
    wall = np.stack((np.full(61, 3.0), np.linspace(-1.5, 1.5, 61)), axis=1)
    correlative.draw(wall, picture)
    correlative.clear(wall, 0.0, 0.0, picture)
    at = np.zeros(3)
    assert correlative.weigh(picture, wall, at) > 0.9
    before = correlative.weigh(picture, wall[15:46], np.array([-1.0, 0.0, 0.0]))
    assert before == pytest.approx(-0.4, abs=0.05)
    assert correlative.weigh(picture, wall, np.array([1.0, 0.0, 0.0])) == 0.0  # behind it nothing is known
    assert correlative.weigh(picture, np.full((5, 2), np.nan), at) == 0.0
