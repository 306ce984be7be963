"""The kernel of social forces against the slow gradient of the potentials that they come from."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.behaviours.social_force import Passers, Walls, range_of, social_forces

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
            seen = wanted[n, :2] @ -force >= np.linalg.norm(force) * NUMBERS[5]
            out[n] += force * (1.0 if seen else NUMBERS[6])
        count = walls.shape[1]
        for k in range(count):
            d = walls[n, k]
            if np.isfinite(d) and d <= walls[n, k - 1] and d < walls[n, (k + 1) % count]:
                out[n] -= NUMBERS[3] / NUMBERS[4] * math.exp(-d / NUMBERS[4]) * bearings[k]
    return out


def call(poses, twists, reach, heeded, own, wanted, walls, bearings, relative=False, ahead=0.0, behind=NUMBERS[6]):
    out = np.empty((len(poses), 2))
    rows, bodies = poses.shape[:2]
    numbers = np.tile((*NUMBERS[:6], behind, float(relative), ahead, 1.0), (rows, 1))
    velocity = np.array([over_ground(poses[n, own[n]], twists[n, own[n]]) for n in range(rows)])
    # Each row's bodies are those of a world of its own.
    passers = Passers(
        poses.reshape(-1, 3), twists.reshape(-1, 3), np.tile(reach, rows), np.zeros(rows * bodies, dtype=bool)
    )
    looked_at = heeded & (np.arange(bodies) != own[:, None])
    first = np.concatenate(([0], np.cumsum(looked_at.sum(axis=1))))
    body = np.flatnonzero(looked_at)
    mine = np.arange(rows) * bodies + own
    social_forces(passers, mine, first, body, velocity, wanted, Walls(walls, bearings), numbers, 0, len(out), out)
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
    wanted = np.column_stack((np.cos(angle), np.sin(angle)) * 2)
    walls = np.where(random.uniform(size=(rows, rays)) < 0.6, random.uniform(0.1, 2.0, (rows, rays)), np.inf)
    around = np.arange(rays) * 2.0 * np.pi / rays
    bearings = np.column_stack((np.cos(around), np.sin(around)))
    # Who stands in another is not a case; nor, for differences, who is nearly on the other's way.
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
    rest = np.array([0.2, 0.2, 0.3]), np.ones((rows, 3), dtype=bool), own, np.array([[1.0, 0.0] * 2] * rows)
    np.testing.assert_allclose(
        call(poses, twists, *rest, walls, bearings, True, ahead, behind=1.0),
        call(later, twists, *rest, then, bearings, True, behind=1.0),
    )


@pytest.mark.parametrize("relative", [False, True])
def test_who_leaves_the_sight_within_a_step_counts_by_the_time_in_sight(relative: bool) -> None:
    """The pedestrian passes others while the wanted direction turns; the slow twin looks at 200 instants."""
    random = np.random.default_rng(5)
    rows, dt = 1500, 0.02
    poses, twists = np.zeros((rows, 2, 3)), np.zeros((rows, 2, 3))
    poses[:, 1, :2] = np.column_stack((random.uniform(-0.6, 3.0, rows), random.uniform(0.6, 1.0, rows)))
    twists[:, 0, 0] = 1.5
    twists[:, 1] = random.uniform(-0.3, 0.3, (rows, 3))
    turn = random.uniform(-0.02, 0.02, rows)
    zero, one = np.zeros(rows), np.ones(rows)
    wanted = np.column_stack((one, zero, np.cos(turn), np.sin(turn)))
    walls, bearings = np.full((rows, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    rest = np.array([0.2, 0.2]), np.ones((rows, 2), dtype=bool), np.zeros(rows, dtype=np.int64)
    found = call(poses, twists, *rest, wanted, walls, bearings, relative, 0.5 * dt)
    whole, half = (
        call(poses, twists, *rest, wanted, walls, bearings, relative, 0.5 * dt, behind=behind) for behind in (1.0, 0.0)
    )
    seen = half[:, 1] / whole[:, 1]
    np.testing.assert_allclose(found, (seen + (1.0 - seen) * NUMBERS[6])[:, None] * whole, rtol=1e-12)
    off = []
    for n in np.flatnonzero((seen > 0.0) & (seen < 1.0)):
        in_sight = []
        for time in (np.arange(200) + 0.5) / 200.0 * dt:
            r = -poses[n, 1, :2] + time * (twists[n, 0, :2] - over_ground(poses[n, 1], twists[n, 1]))
            r = r * (1.0 - 0.2 / np.linalg.norm(r))
            step = (over_ground(poses[n, 1], twists[n, 1]) - relative * twists[n, 0, :2]) * NUMBERS[2]
            push = r / np.linalg.norm(r) + (r - step) / np.linalg.norm(r - step)
            towards = wanted[n, :2] + time / dt * (wanted[n, 2:] - wanted[n, :2])
            in_sight.append(-push @ towards >= np.linalg.norm(push) * NUMBERS[5])
        off.append(abs(seen[n] - np.mean(in_sight)))
    assert len(off) > 5
    # The kernel finds the instant on a straight line through the step; the instants above are 0.005 of it apart.
    assert max(off) < 0.1
    assert np.median(off) < 0.01


@pytest.mark.parametrize("relative", [False, True])
def test_no_force_is_left_out_that_is_not_negligible(relative: bool) -> None:
    """Along the line of a fast one who comes, far away; each force alone against the one that is worked out."""
    random = np.random.default_rng(3)
    largest, none = 0.0, 0
    for distance in np.arange(5.0, 14.0, 0.25):
        angle = random.uniform(-np.pi, np.pi)
        poses = np.array([[[0.0, 0.0, 0.0], [distance * math.cos(angle), distance * math.sin(angle), angle + np.pi]]])
        twists = np.array([[[1.5 * math.cos(angle), 1.5 * math.sin(angle), 0.0], [1.8, 0.02, 0.0]]])
        rest = (
            np.array([0.2, 0.2]),
            np.ones((1, 2), dtype=bool),
            np.zeros(1, dtype=np.int64),
            np.array([[1.0, 0.0] * 2]),
        )
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
    out = call(*case, np.array([[1.0, 0.0] * 2] * 2), walls, bearings)
    assert out[0] == pytest.approx([0.0, 0.0])
    assert np.isfinite(out).all()


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("ahead", [0.0, 0.05, 0.5])
def test_who_is_out_of_range_is_left_out_anyway(relative: bool, ahead: float) -> None:
    """With others just beyond `range_of`, on the way that brings them nearest, he feels exactly nothing."""
    random = np.random.default_rng(4)
    felt = 0
    for _ in range(200):
        angle, speed, its_speed = random.uniform(-np.pi, np.pi), *random.uniform(0.0, 3.0, 2)
        column = [np.array([[value]]) for value in (*NUMBERS[:3], float(relative), ahead, speed)]
        limit = float(range_of(*column)[0, 0]) + 0.2 + its_speed * (NUMBERS[2] + ahead)
        for share in (1.0 + 1e-12, 0.5):
            there = share * limit * np.array([math.cos(angle), math.sin(angle)])
            poses = np.array([[[0.0, 0.0, angle], [*there, angle + np.pi]]])
            twists = np.array([[[speed, 0.0, 0.0], [its_speed, 0.0, 0.0]]])
            rest = (
                np.array([0.2, 0.2]),
                np.ones((1, 2), dtype=bool),
                np.zeros(1, dtype=np.int64),
                np.array([[1.0, 0.0] * 2]),
            )
            walls, bearings = np.full((1, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
            found = call(poses, twists, *rest, walls, bearings, relative, ahead)
            if share == 0.5:
                felt += found.any()
            else:
                assert not found.any()
    assert felt > 100


def test_robots_count_if_they_are_heeded() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [1.0, 0.2, 0.0]])
    walls, bearings = np.full((1, 4), np.inf), np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    first, body, own = np.array([0, 1]), np.array([1]), np.zeros(1, dtype=np.int64)
    forces = {}
    for heeded in (0.0, 1.0):
        for robot in (False, True):
            passers = Passers(poses, np.zeros((2, 3)), np.array([0.2, 0.2]), np.array([False, robot]))
            out = np.empty((1, 2))
            numbers = np.array([[*NUMBERS, 0.0, 0.0, heeded]])
            social_forces(
                passers, own, first, body, np.zeros((1, 2)), np.eye(4)[:1], Walls(walls, bearings), numbers, 0, 1, out
            )
            forces[heeded, robot] = out
    assert not forces[0.0, True].any()
    assert forces[1.0, True].any()
    np.testing.assert_array_equal(forces[0.0, False], forces[1.0, True])
