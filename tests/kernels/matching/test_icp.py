"""How a scan is laid onto another one, and what it tells."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.kernels.matching import icp, priors
from amorsim.kernels.matching.symmetric import eigen, invert, solve
from tests.kernels.matching.scenes import HALF, WHOLE, circle, corridor, off, outline_of, reference_of, room, scan

SEARCH = icp.Search(0.01, 0.6, 60, 1e-6)


def align(reference, moved, start=(0.0, 0.0, 0.0), prior=None, search=SEARCH):
    out = icp.result()
    work = icp.work(len(moved.points))
    icp.align(
        reference_of(reference), moved, np.array(start, dtype=float), prior or priors.no_prior(), search, work, out
    )
    return out


@pytest.mark.parametrize("seed", range(20))
def test_eigenvalues_are_those_of_numpy(seed):
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(3, 3)) * rng.uniform(0.01, 100.0, 3)
    matrix = half @ half.T
    values, vectors = np.empty(3), np.empty((3, 3))
    eigen(matrix.copy(), values, vectors)
    np.testing.assert_allclose(values, np.linalg.eigvalsh(matrix), atol=1e-12 * values[2])
    np.testing.assert_allclose(vectors @ np.diag(values) @ vectors.T, matrix, atol=1e-12 * values[2])
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(3), atol=1e-13)
    found, right = np.empty(3), rng.normal(size=3)
    solve(values, vectors, right, 1e-14, found)
    np.testing.assert_allclose(matrix @ found, right, rtol=1e-6)
    inverse = np.empty((3, 3))
    assert invert(matrix, inverse)
    np.testing.assert_allclose(inverse @ matrix, np.eye(3), atol=1e-7)


def test_a_singular_matrix_has_no_inverse():
    assert not invert(np.diag((1.0, 0.0, 2.0)), np.empty((3, 3)))


def test_lines_lie_on_the_walls():
    _, found = scan(room(), (1.5, 1.2, 0.4))
    known = np.isfinite(found.lines[:, 0])
    assert known.mean() > 0.8
    pose = np.array([[1.5, 1.2, 0.4]] * known.sum())
    there = am.compose(pose, np.concatenate((found.lines[known, :2], np.zeros((known.sum(), 1))), axis=1))
    on_wall = np.abs(there[:, 1]) < 1e-3
    assert on_wall.any()
    normals = found.lines[known, 2:][on_wall]
    angle = np.arctan2(normals[:, 1], normals[:, 0]) + 0.4
    np.testing.assert_allclose(am.wrap_angle(angle), math.pi / 2.0, atol=0.02)  # towards the laser


def test_at_a_corner_a_line_is_that_of_one_wall():
    """All walls of an L-shaped room are along the axes, and so are the lines, however near a corner their point is."""
    walls = [(0, 0, 5, 0), (5, 0, 5, 2), (5, 2, 2, 2), (2, 2, 2, 5), (2, 5, 0, 5), (0, 5, 0, 0)]
    world = am.Map.from_segments(np.array(walls, float), resolution=0.001)
    for heading in np.linspace(0.0, 2.0 * math.pi, 7):
        pose = (1.1, 0.9, heading)
        normals = scan(world, pose)[1].lines[:, 2:]
        normals = normals[np.isfinite(normals[:, 0])]
        angles = np.arctan2(normals[:, 1], normals[:, 0]) + heading
        off_axis = np.abs(np.remainder(angles + math.pi / 4.0, math.pi / 2.0) - math.pi / 4.0)
        assert len(angles) > 140
        # Where a corner lies between two beams, one point of three may be beyond it.
        assert (off_axis > 1e-6).sum() <= 4


def test_what_was_not_seen_has_no_point():
    found = outline_of(np.full(181, np.inf))
    assert np.isnan(found.points).all()
    assert np.isnan(found.lines).all()
    result = align(outline_of(np.full(181, 2.0)), found)
    assert result.quality[0] == 0.0


def test_a_scan_is_laid_where_it_was_taken():
    world, here, there = room(), np.array([[1.5, 1.2, 0.4]]), np.array([[1.62, 1.25, 0.5]])
    result = align(scan(world, here[0])[1], scan(world, there[0])[1])
    distance, angle = off(result.pose, am.relative(here, there)[0])
    assert distance < 0.01
    assert angle < math.radians(0.5)
    assert result.quality[0] > 0.7


def test_its_error_is_about_what_its_information_says():
    # 200 pairs of scans; the squared error in units of the covariance, whose factor 2 is the key scan's own noise.
    world, rng = room(), np.random.default_rng(1)
    here, there = np.array([[1.5, 1.2, 0.4]]), np.array([[1.62, 1.25, 0.5]])
    true = am.relative(here, there)[0]
    squares = []
    for _ in range(200):
        key = scan(world, here[0], WHOLE, 0.01, rng)[1]
        result = align(key, scan(world, there[0], WHOLE, 0.01, rng)[1])
        error = result.pose - true
        squares.append(error @ result.information @ error)
    assert 1.0 < np.mean(squares) < 12.0


def test_along_a_corridor_it_stays_where_it_started():
    world = corridor()
    key, moved = scan(world, (30.0, 1.0, 0.0), WHOLE)[1], scan(world, (30.2, 1.03, 0.02), WHOLE)[1]
    result = align(key, moved, start=(0.5, 0.0, 0.0))
    assert result.pose[0] == pytest.approx(0.5, abs=0.02)
    assert result.pose[1] == pytest.approx(0.03, abs=0.003)
    assert result.values[0] < 1e-3 * result.values[2]
    assert abs(result.vectors[0, 0]) > 0.999


def test_a_prior_counts_where_the_scan_tells_nothing():
    world = corridor()
    key, moved = scan(world, (30.0, 1.0, 0.0), WHOLE)[1], scan(world, (30.2, 1.03, 0.02), WHOLE)[1]
    for freedom in (math.inf, 3.0):
        prior = priors.Prior(np.array([0.2, 0.0, 0.0]), np.diag((1e4, 1e2, 1e2)), freedom)
        result = align(key, moved, start=(0.5, 0.0, 0.0), prior=prior)
        np.testing.assert_allclose(result.pose, [0.2, 0.03, 0.02], atol=0.01)
        np.testing.assert_array_equal(result.kept, prior.information)


def test_a_prior_that_the_scan_contradicts_counts_little_if_its_tails_are_long():
    """Wheels that slipped: they are sure of a place to 1 mm, and 0.1 m beside the scan's."""
    key, moved = scan(room(), (2.0, 2.0, 0.0), WHOLE)[1], scan(room(), (2.1, 2.0, 0.0), WHOLE)[1]
    information = np.diag((1e6, 1e6, 1e6))
    normal = align(key, moved, start=(0.1, 0.0, 0.0), prior=priors.Prior(np.zeros(3), information, math.inf))
    student = align(key, moved, start=(0.1, 0.0, 0.0), prior=priors.Prior(np.zeros(3), information, 3.0))
    np.testing.assert_array_equal(normal.kept, information)
    assert abs(normal.pose[0] - 0.1) > 0.01
    np.testing.assert_allclose(student.pose, [0.1, 0.0, 0.0], atol=0.003)
    # Of the difference between both poses, by the sum of their covariances, it leaves what Student's t does.
    off = align(key, moved, start=(0.1, 0.0, 0.0)).pose
    own = np.linalg.inv(student.information)
    before = off @ np.linalg.solve(np.linalg.inv(information) + own, off)
    after = off @ np.linalg.solve(np.linalg.inv(student.kept) + own, off)
    assert after == pytest.approx(before * 6.0 / (3.0 + before), rel=0.1)
    # Across that way it is as sure as before.
    assert student.kept[1, 1] > 0.9e6


def test_a_wall_that_beams_graze_has_lines_far_away():
    """In a corridor the points of a wall are half a metre apart at 6 m, and tell most of the heading."""
    found = scan(corridor(width=2.0), (30.0, 1.0, 0.0), WHOLE)[1]
    far = np.abs(found.points[:, 0]) > 4.0
    assert far.sum() >= 20
    is_line = np.isfinite(found.lines[:, 2])
    assert (is_line & far).sum() >= 0.8 * far.sum()
    np.testing.assert_allclose(np.abs(found.lines[is_line & far][:, 3]), 1.0, atol=1e-6)


def test_in_a_round_room_the_heading_stays_what_it_was():
    world = circle()
    result = align(scan(world, (0, 0, 0), WHOLE)[1], scan(world, (0, 0, 0.3), WHOLE)[1], start=(0.02, -0.01, 0.1))
    assert off(result.pose, np.array([0.0, 0.0, 0.1]))[0] < 0.01
    assert result.values[0] < 1e-2 * result.values[2]
    assert abs(result.vectors[2, 0]) > 0.99


def information(ranges, normal_angles, bearings, std=1.0):
    out = np.empty((3, 3))
    normals = np.stack((np.cos(normal_angles), np.sin(normal_angles)), axis=1)
    rays = np.stack((np.cos(bearings), np.sin(bearings)), axis=1)
    icp.fisher(np.asarray(ranges, float), normals, rays, std, out)
    return out


def middles(count, low, high):
    return low + (np.arange(count) + 0.5) * (high - low) / count


def test_fishers_information_in_a_square_room_is_the_closed_form():
    # From the middle of a room of side L, with rho beams a radian: 4 rho along each axis, 2/3 rho L^2 of the heading.
    count, side = 4000, 5.0
    bearings = middles(count, -math.pi / 4.0, 7.0 * math.pi / 4.0)
    walls = np.repeat(np.arange(4) * math.pi / 2.0, count // 4)
    ranges = 0.5 * side / np.cos(bearings - walls)
    found = information(ranges, walls, bearings, std=0.1) * 0.01
    rho = count / (2.0 * math.pi)
    np.testing.assert_allclose(found, np.diag((4.0 * rho, 4.0 * rho, 2.0 / 3.0 * rho * side**2)), atol=1e-3 * rho)


def test_between_parallel_walls_fishers_information_has_rank_two():
    turn, half = 0.3, 1.2
    bearings = middles(200, -1.4, 1.4)
    ranges = half / np.cos(bearings)
    walls = np.concatenate((np.zeros(200), np.full(200, math.pi)))
    both = np.concatenate((bearings, bearings + math.pi))
    found = information(np.tile(ranges, 2), walls + turn, both + turn)
    values, vectors = np.linalg.eigh(found)
    assert abs(values[0]) < 1e-9 * values[2]
    assert values[1] > 1e-3 * values[2]
    along = np.array([-math.sin(turn), math.cos(turn), 0.0])
    assert abs(vectors[:, 0] @ along) == pytest.approx(1.0, abs=1e-9)


def test_in_the_middle_of_a_circle_fishers_information_says_nothing_of_the_heading():
    bearings = middles(360, -math.pi, math.pi)
    found = information(np.full(360, 3.0), bearings, bearings)
    np.testing.assert_allclose(found[2], 0.0, atol=1e-9)
    np.testing.assert_allclose(found[:2, :2], 180.0 * np.eye(2), atol=1e-9)


def test_fishers_information_is_that_of_slopes_taken_numerically():
    world, pose = room(), np.array([1.5, 1.2, 0.4])
    ranges, _ = scan(world, pose)
    slopes = np.empty((181, 3))
    for j in range(3):
        ends = [world.cast_rays(np.array([pose + sign * 1e-2 * np.eye(3)[j]]), HALF, 8.0)[0] for sign in (1, -1)]
        slopes[:, j] = (ends[0] - ends[1]) / 2e-2
    bottom = np.abs(pose[1] + ranges * np.sin(HALF + pose[2])) < 2e-3  # beams that end on the lower wall
    bottom &= (np.abs(slopes) < 50.0).all(axis=1)
    bottom[np.flatnonzero(bottom)[[0, -1]]] = False
    assert bottom.sum() > 20
    found = information(ranges[bottom], np.full(bottom.sum(), math.pi / 2.0), HALF[bottom] + pose[2])
    np.testing.assert_allclose(slopes[bottom].T @ slopes[bottom], found, rtol=0.05, atol=2.0)


def nearest(lines, point, ray, farthest):
    """The naive twin of the search in order of x."""
    apart = np.hypot(lines[:, 0] - point[0], lines[:, 1] - point[1])
    apart[~(lines[:, 2] * ray[0] + lines[:, 3] * ray[1] < 0.0)] = np.inf
    best = int(np.argmin(np.where(np.isnan(apart), np.inf, apart)))
    return best if apart[best] < farthest else -1


@pytest.mark.parametrize("seed", range(5))
def test_a_point_is_paired_with_the_nearest_line_that_faces_its_beam(seed):
    rng = np.random.default_rng(seed)
    lines = np.concatenate((rng.uniform(-2.0, 2.0, (200, 2)), rng.normal(size=(200, 2))), axis=1)
    lines[rng.random(200) < 0.2] = np.nan
    reference = reference_of(icp.Outline(lines[:, :2].copy(), lines, rng.normal(size=(200, 2))))
    for _ in range(500):
        point, ray, farthest = rng.uniform(-2.5, 2.5, 2), rng.normal(size=2), rng.uniform(0.05, 1.0)
        found, square = icp._nearest(reference, *point, *ray, farthest)
        assert found == nearest(lines, point, ray, farthest)
        if found >= 0:
            assert square == pytest.approx(np.sum((lines[found, :2] - point) ** 2))


def test_a_thin_wall_is_not_matched_from_behind():
    wall = np.array([[-3, 1.0, 3, 1.0], [3, 1.02, -3, 1.02], [-3, -2, -3, 4], [3, 4, 3, -2]], dtype=float)
    world = am.Map.from_segments(wall, resolution=0.001)
    before, behind = scan(world, (0.0, 0.0, math.pi / 2.0))[1], scan(world, (0.0, 2.0, -math.pi / 2.0))[1]
    result = align(before, behind, start=(2.0, 0.0, math.pi))  # the frame of the first looks along +y
    sides = np.abs(behind.points[:, 0] - 0.98) > 0.01
    assert result.quality[0] < 0.05 + sides.mean()


def corridor_with(jambs):
    """The scan of a corridor's two walls and some jambs, and a key in which the jambs' lines are off by 0.03 m."""
    along = np.linspace(-3.0, 3.0, 61)
    points = np.concatenate((
        np.column_stack((along, np.full(61, 1.0))),
        np.column_stack((along, np.full(61, -1.0))),
        (2.0, 0.8) - 0.1 * np.arange(jambs)[:, None] * (0.8, 0.6),
    ))  # fmt: skip
    normals = np.repeat([(0.0, -1.0), (0.0, 1.0), (-0.6, 0.8)], (61, 61, jambs), axis=0)
    rays = points / np.hypot(*points.T)[:, None]
    rng = np.random.default_rng(1)
    seen = points.copy()
    seen[:122, 0] += 0.03  # other beams, with noise
    seen[:122, 1] += 0.004 * rng.normal(size=122)
    lines, off = (np.concatenate((of, normals), axis=1) for of in (seen, points))
    off[122:, 0] += 0.03
    return icp.Outline(points, off, rays), icp.Outline(seen, lines, rays)


@pytest.mark.parametrize(("jambs", "moved"), [(1, (-0.002, 0.002)), (4, (0.025, 0.035))])
def test_what_one_point_alone_tells_hardly_counts(jambs, moved):
    """At a corner a line may be wrong: one point moves nothing by 0.03 m, four that agree do."""
    key, seen = corridor_with(jambs)
    prior = priors.Prior(np.zeros(3), np.diag((2e4, 1e5, 1e4)), 3.0)
    result = align(key, seen, prior=prior, search=icp.Search(0.005, 0.3, 60, 1e-6))
    assert moved[0] < result.pose[0] < moved[1]
    assert (result.information[0, 0] > 1e5) == (jambs > 1)


@pytest.mark.long
def test_pairs_that_are_far_apart_do_not_lead_it_astray():
    """In a doorway one of these 3,000 scans ends 0.26 m away, unless it begins a second time."""
    world, rng = am.load("map-the-office").map, np.random.default_rng(3)
    search, sure = icp.Search(0.005, 0.3, 60, 1e-6), np.diag((4e4, 4e4, 1.0 / 0.015**2))
    for _ in range(3000):
        here = np.array([[12.8 + 0.04 * rng.normal(), 5.35 + 0.2 * rng.normal(), -1.2 - 0.2 * rng.random()]])
        there = np.array([[12.78 + 0.02 * rng.normal(), 4.76 + 0.1 * rng.normal(), -1.66]])
        key, seen = (scan(world, pose[0], HALF, 0.005, rng)[1] for pose in (here, there))
        true = am.relative(here, there)[0]
        result = align(key, seen, start=true, prior=priors.Prior(true, sure, 3.0), search=search)
        assert off(result.pose, true)[0] < 0.1
