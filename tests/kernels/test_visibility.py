"""Marks within reach and discs that rays meet, against slow and obvious twins."""

import math

import numpy as np
import pytest

from amorsim.kernels.raycast.visibility import look_at_discs, marks_near


def near(poses, range_max, half_angle, replica, own, places, carrier, room=None):
    """Pairs (row, mark, distance, bearing) as the kernel has them, with room for some or for all."""
    rows = len(poses)
    size = rows * places.shape[1] if room is None else room
    first = np.empty(rows + 1, dtype=np.int64)
    mark, distance, bearing = np.empty(size, dtype=np.int64), np.empty(size), np.empty(size)
    count = marks_near(poses, range_max, half_angle, replica, own, places, carrier, first, mark, distance, bearing)
    return count, first, mark, distance, bearing


def naive(poses, range_max, half_angle, replica, own, places, carrier):
    found = []
    for i, (x, y, heading) in enumerate(poses.tolist()):
        row = []
        for f in range(places.shape[1]):
            px, py = places[replica[i], f].tolist()
            away = math.hypot(px - x, py - y)
            bearing = math.remainder(math.atan2(py - y, px - x) - heading, 2 * math.pi) if away else 0.0
            if carrier[replica[i], f] != own[i] and away <= range_max[i] and abs(bearing) <= half_angle[i]:
                row.append((away, f, bearing))
        found.append(sorted(row, key=lambda one: one[0]))  # stable: of equally near ones the first
    return found


@pytest.mark.parametrize("marks", [9, 150])
@pytest.mark.parametrize("seed", range(10))
def test_marks_are_those_within_reach_nearest_first(seed, marks):
    random = np.random.default_rng(seed)
    rows, replicas = 12, 3
    poses = np.c_[random.uniform(-3, 3, (rows, 2)), random.uniform(-7, 7, rows)]
    replica = random.integers(0, replicas, rows)
    own = np.arange(rows, dtype=np.int64)
    places = random.uniform(-3, 3, (replicas, marks, 2))
    places[:, 4] = places[:, 2]  # equally far from everybody
    carrier = random.integers(-1, rows, (replicas, marks))
    range_max, half_angle = random.uniform(0.5, 5, rows), random.uniform(0.1, math.pi, rows)
    arguments = (poses, range_max, half_angle, replica, own, places, carrier)
    count, first, mark, distance, bearing = near(*arguments)
    expected = naive(*arguments)
    assert count == first[-1] == sum(map(len, expected))
    for i, row in enumerate(expected):
        mine = slice(first[i], first[i + 1])
        assert mark[mine].tolist() == [f for _, f, _ in row]
        np.testing.assert_allclose(distance[mine], [d for d, _, _ in row], rtol=1e-15)
        np.testing.assert_allclose(bearing[mine], [b for _, _, b in row], atol=2e-15)
    assert near(*arguments, room=3)[0] == count  # it counts what there is no room for


def test_a_mark_at_ones_own_place_is_straight_ahead():
    one = np.array([[1.0, 2.0, 3.0]])
    zero, places = np.zeros(1, dtype=np.int64), np.array([[[1.0, 2.0]]])
    count, _, _, distance, bearing = near(one, np.ones(1), np.array([0.1]), zero, zero, places, np.array([[-1]]))
    assert (count, distance[0], bearing[0]) == (1, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_rays_meet_the_nearest_disc(seed):
    random = np.random.default_rng(seed)
    rows, beams, discs = 6, 40, 7
    poses = np.c_[random.uniform(-2, 2, (rows, 2)), random.uniform(-7, 7, rows)]
    bearings = random.uniform(-4, 4, (rows, beams))
    places, radius = random.uniform(-3, 3, (discs, 2)), np.maximum(random.uniform(-0.2, 0.8, discs), 0.0)
    limit = random.uniform(1, 5, rows)
    ranges = np.where(random.uniform(size=(rows, beams)) < 0.5, np.inf, random.uniform(0, 3, (rows, beams)))
    before, things = ranges.copy(), np.full((rows, beams), -1, dtype=np.int64)
    look_at_discs(poses, np.cos(bearings), np.sin(bearings), limit, places, radius, 10, ranges, things)
    for i in range(rows):
        for j in range(beams):
            angle = poses[i, 2] + bearings[i, j]
            best, thing = before[i, j], -1
            for f in range(discs):
                # The roots of |p + t u - c| = r
                cx, cy = places[f] - poses[i, :2]
                along = cx * math.cos(angle) + cy * math.sin(angle)
                rest = along**2 - (cx**2 + cy**2 - radius[f] ** 2)
                if radius[f] == 0.0 or rest < 0.0 or along + math.sqrt(rest) < 0.0:
                    continue
                distance = max(0.0, along - math.sqrt(rest))
                if distance < best and distance <= limit[i]:
                    best, thing = distance, 10 + f
            assert things[i, j] == thing
            assert ranges[i, j] == pytest.approx(best, abs=1e-9)
