"""Alignment, association and errors of trajectories."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.algorithms.trajectories import (
    Transform,
    absolute_errors,
    associate,
    first_pose_transform,
    interpolated,
    pairs_by_distance,
    pairs_by_steps,
    relative_errors,
    umeyama,
)

NUMBERS = st.floats(-100.0, 100.0)


def walk(count, seed=0):
    random = np.random.default_rng(seed)
    return np.column_stack((random.normal(size=(count, 2)).cumsum(axis=0), random.uniform(-3.0, 3.0, count)))


@given(NUMBERS, NUMBERS, st.floats(-3.1, 3.1), st.integers(2, 30), st.integers(0, 5))
def test_a_transform_is_found_again(x: float, y: float, angle: float, count: int, seed: int) -> None:
    true = Transform(x, y, angle)
    poses = walk(count, seed)
    found = umeyama(poses[:, :2], true.apply(poses)[:, :2])
    assert math.remainder(found.angle - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)
    assert np.abs(found.apply(poses) - true.apply(poses))[:, :2].max() < 1e-12 * (100.0 + abs(x) + abs(y))


def test_a_scale_is_found_again() -> None:
    true = Transform(3.0, -2.0, 1.2, 2.5)
    poses = walk(20)
    found = umeyama(poses[:, :2], true.apply(poses)[:, :2], with_scale=True)
    assert found == pytest.approx(true, abs=1e-12)


@pytest.mark.parametrize("points", [[(0.0, 0.0), (1.0, 2.0)], [(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (5.0, 5.0)]])
def test_two_points_and_collinear_ones_are_enough(points: list[tuple[float, float]]) -> None:
    true = Transform(1.0, 2.0, 2.9)
    poses = np.column_stack((points, np.zeros(len(points))))
    assert umeyama(poses[:, :2], true.apply(poses)[:, :2]) == pytest.approx(true, abs=1e-12)


@pytest.mark.long
@given(st.integers(0, 30), st.integers(2, 10))
def test_mirrored_points_are_turned_and_not_mirrored(seed: int, count: int) -> None:
    points = walk(count, seed)[:, :2]
    found = umeyama(points, points * [1.0, -1.0], with_scale=True)
    turned = found.apply(np.column_stack((points, np.zeros(count))))[:, :2]
    a, b = points[1:] - points[:-1], turned[1:] - turned[:-1]
    if count > 2:
        before, after = (d[0, 0] * d[1, 1] - d[0, 1] * d[1, 0] for d in (a, b))
        assert np.sign(before) == np.sign(after)
    assert found.scale > 0.0
    brute = min(
        np.sum((rotated(points, angle) - centred(points * [1.0, -1.0])) ** 2) for angle in np.linspace(0, 7, 999)
    )
    rigid = umeyama(points, points * [1.0, -1.0])
    ours = np.sum((rigid.apply(np.column_stack((points, np.zeros(count))))[:, :2] - points * [1.0, -1.0]) ** 2)
    assert ours <= brute + 1e-9


def centred(points):
    return points - points.mean(axis=0)


def rotated(points, angle):
    cos, sin = math.cos(angle), math.sin(angle)
    return centred(points) @ np.array([[cos, sin], [-sin, cos]])


@pytest.mark.parametrize("points", [[(1.0, 2.0)], [(1.0, 2.0)] * 4, [(1e6, 1e6)] * 3])
def test_poses_in_one_place_are_refused(points: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="can be turned in any way"):
        umeyama(np.array(points), np.array(points) + 1.0)


def test_the_first_pose_goes_upon_the_first() -> None:
    poses, others = walk(5), walk(5, 1)
    moved = first_pose_transform(poses, others).apply(poses)
    assert moved[0, :2] == pytest.approx(others[0, :2], abs=1e-12)
    assert math.remainder(moved[0, 2] - others[0, 2], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


def naive_associate(times, others, most):
    pairs = []
    for i, time in enumerate(times):
        nearest = min(range(len(others)), key=lambda j: (abs(others[j] - time), j))
        if abs(others[nearest] - time) <= most:
            pairs.append((i, nearest))
    return pairs


@given(st.lists(st.integers(0, 50), unique=True, max_size=12), st.lists(st.integers(0, 50), unique=True, min_size=1))
def test_association_takes_the_nearest(times: list[int], others: list[int]) -> None:
    first, second = np.array(sorted(times), float), np.array(sorted(others), float)
    a, b = associate(first, second, 2.0)
    if len(first) <= len(second):
        assert list(zip(a, b, strict=True)) == naive_associate(first, second, 2.0)
    else:
        assert list(zip(b, a, strict=True)) == naive_associate(second, first, 2.0)


def test_relative_errors_do_not_depend_on_the_frame() -> None:
    true, believed = walk(40), walk(40, 3)
    pairs = pairs_by_steps(40, 3)
    first = relative_errors(true, believed, pairs)
    moved = relative_errors(Transform(1.0, 2.0, 0.4).apply(true), Transform(-3.0, 1.0, 2.0).apply(believed), pairs)
    assert np.abs(np.array(first) - np.array(moved)).max() < 1e-12


def test_errors_of_a_trajectory_with_itself_are_none() -> None:
    poses = walk(30)
    assert not np.any(absolute_errors(poses, poses))
    assert not np.any(relative_errors(poses, poses, pairs_by_steps(30, 4)))


def test_pairs_are_as_far_apart_as_asked() -> None:
    poses = np.zeros((101, 3))
    poses[:, 0] = 0.1 * np.arange(101)
    first, last = pairs_by_distance(poses, 1.0)
    assert (last - first)[:91].tolist() == [10] * 91
    assert len(first) == 91 + 1  # the last one is 0.9 m from the end, which is near enough
    first, last = pairs_by_distance(poses, 1.0, every=False)
    assert np.abs(poses[last, 0] - poses[first, 0]).min() >= 1.0 - 1e-9
    assert [len(part) for part in pairs_by_steps(10, 3, every=False)] == [3, 3]


def test_interpolation_turns_the_short_way() -> None:
    poses = np.array([[0.0, 0.0, 3.1], [1.0, 2.0, -3.1]])
    (middle,) = interpolated(np.array([0.0, 1.0]), poses, np.array([0.5]))
    assert middle == pytest.approx([0.5, 1.0, math.pi], abs=1e-12)
