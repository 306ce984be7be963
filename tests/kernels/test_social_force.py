"""The kernel of social forces against the slow gradient of the potentials that they come from."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.behaviours.social_force import social_forces

NUMBERS = (2.1, 0.3, 2.0, 10.0, 0.2, math.cos(math.radians(100.0)), 0.5)


def potential(r: np.ndarray, step: np.ndarray) -> float:
    """V0 exp(-b / sigma), b the semi-minor axis of the ellipse with foci at the other and where his step leads."""
    b = 0.5 * math.sqrt((np.linalg.norm(r) + np.linalg.norm(r - step)) ** 2 - step @ step)
    return NUMBERS[0] * math.exp(-b / NUMBERS[1])


def over_ground(pose: np.ndarray, twist: np.ndarray) -> np.ndarray:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return np.array([[c, -s], [s, c]]) @ twist[:2]


def twin(poses, twists, reach, heeded, own, wanted, walls, bearings, relative):
    out = np.zeros((len(poses), 2))
    for n in range(len(poses)):
        for b in range(poses.shape[1]):
            if b == own[n] or not heeded[n, b]:
                continue
            r = poses[n, own[n], :2] - poses[n, b, :2]
            r = r * (1.0 - reach[b] / np.linalg.norm(r))
            step = over_ground(poses[n, b], twists[n, b]) * NUMBERS[2]
            if relative:
                step = step - over_ground(poses[n, own[n]], twists[n, own[n]]) * NUMBERS[2]
            e = 1e-6
            force = np.array([-(potential(r + d, step) - potential(r - d, step)) / (2 * e) for d in np.eye(2) * e])
            seen = wanted[n] @ -force >= np.linalg.norm(force) * NUMBERS[5]
            out[n] += force * (1.0 if seen else NUMBERS[6])
        count = walls.shape[1]
        for k in range(count):
            d = walls[n, k]
            if np.isfinite(d) and d <= walls[n, k - 1] and d < walls[n, (k + 1) % count]:
                out[n] -= NUMBERS[3] / NUMBERS[4] * math.exp(-d / NUMBERS[4]) * bearings[k]
    return out


def call(poses, twists, reach, heeded, own, wanted, walls, bearings, relative=False, ahead=0.0):
    out = np.empty((len(poses), 2))
    numbers = np.tile((*NUMBERS, float(relative), ahead), (len(poses), 1))
    velocity = np.array([over_ground(poses[n, own[n]], twists[n, own[n]]) for n in range(len(poses))])
    social_forces(poses, twists, reach, heeded, own, velocity, wanted, walls, bearings, numbers, out)
    return out


@pytest.mark.parametrize("relative", [False, True])
def test_forces_are_the_gradients_of_their_potentials(relative: bool) -> None:
    random = np.random.default_rng(1)
    rows, bodies, rays = 200, 4, 12
    poses = random.uniform(-3.0, 3.0, (rows, bodies, 3))
    twists = random.uniform(-1.0, 1.0, (rows, bodies, 3))
    reach = np.array([0.2, 0.3, 0.1, 0.25])
    heeded = random.uniform(size=(rows, bodies)) < 0.8
    own = random.integers(0, bodies, rows)
    angle = random.uniform(-np.pi, np.pi, rows)
    wanted = np.column_stack((np.cos(angle), np.sin(angle)))
    walls = np.where(random.uniform(size=(rows, rays)) < 0.6, random.uniform(0.1, 2.0, (rows, rays)), np.inf)
    around = np.arange(rays) * 2.0 * np.pi / rays
    bearings = np.column_stack((np.cos(around), np.sin(around)))
    # Who stands in another is no case; nor, for differences, who is nearly on the other's way.
    gaps = np.linalg.norm(poses[:, :, None, :2] - poses[:, None, :, :2], axis=3) + 10.0 * np.eye(bodies)
    clear = gaps.min(axis=(1, 2)) > 0.6
    case = (
        poses[clear],
        twists[clear],
        reach,
        heeded[clear],
        own[clear],
        wanted[clear],
        walls[clear],
        bearings,
        relative,
    )
    assert clear.sum() > 50
    np.testing.assert_allclose(call(*case), twin(*case), rtol=2e-5, atol=6e-7)


def test_forces_ahead_are_those_of_where_all_are_then() -> None:
    random = np.random.default_rng(2)
    rows, ahead = 50, 0.25
    poses = random.uniform(-3.0, 3.0, (rows, 3, 3))
    twists = random.uniform(-1.0, 1.0, (rows, 3, 3))
    own = np.zeros(rows, dtype=np.int64)
    later = poses.copy()
    for n in range(rows):
        for b in range(3):
            later[n, b, :2] += ahead * over_ground(poses[n, b], twists[n, b])
    walls, bearings = np.full((rows, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    walls[:, 0] = 2.0
    then = walls.copy()
    then[:, 0] -= later[:, 0, 0] - poses[:, 0, 0]
    rest = np.array([0.2, 0.2, 0.3]), np.ones((rows, 3), dtype=bool), own, np.array([[1.0, 0.0]] * rows)
    np.testing.assert_allclose(
        call(poses, twists, *rest, walls, bearings, True, ahead), call(later, twists, *rest, then, bearings, True)
    )


@pytest.mark.parametrize("relative", [False, True])
def test_no_force_is_left_out_that_is_not_negligible(relative: bool) -> None:
    """Along the line of a fast one who comes, far away; each force alone against the one that is worked out."""
    random = np.random.default_rng(3)
    largest, none = 0.0, 0
    for distance in np.arange(5.0, 14.0, 0.25):
        angle = random.uniform(-np.pi, np.pi)
        poses = np.array([[[0.0, 0.0, 0.0], [distance * math.cos(angle), distance * math.sin(angle), angle + np.pi]]])
        twists = np.array([[[1.5 * math.cos(angle), 1.5 * math.sin(angle), 0.0], [1.8, 0.02, 0.0]]])
        rest = np.array([0.2, 0.2]), np.ones((1, 2), dtype=bool), np.zeros(1, dtype=np.int64), np.array([[1.0, 0.0]])
        walls, bearings = np.full((1, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
        found = call(poses, twists, *rest, walls, bearings, relative)
        if not found.any():
            none += 1
            force = twin(poses, twists, *rest, walls, bearings, relative)
            largest = max(largest, float(np.abs(force).max()))
    assert none > 10
    assert largest < 2e-7


def test_a_lone_one_feels_nothing_and_numbers_stay_finite_where_it_is_singular() -> None:
    poses = np.zeros((2, 2, 3))
    poses[1, 1] = (0.5, 0.0, np.pi)  # right on the other's way to him
    twists = np.zeros((2, 2, 3))
    twists[:, :, 0] = 1.0
    case = (poses, twists, np.array([0.2, 0.2]), np.array([[True, False], [True, True]]), np.zeros(2, dtype=np.int64))
    walls, bearings = np.full((2, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    out = call(*case, np.array([[1.0, 0.0]] * 2), walls, bearings)
    assert out[0] == pytest.approx([0.0, 0.0])
    assert np.isfinite(out).all()
