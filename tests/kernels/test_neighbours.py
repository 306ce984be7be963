"""Neighbours by the hash: those of looking at all pairs, in order of body."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from amorsim.kernels.behaviours.neighbours import Crowd, Looking, find_neighbours
from amorsim.kernels.collision.body_hash import BodyHash, hash_bodies


def table_of(crowd: Crowd, first: np.ndarray, side: float, rows: int, cols: int) -> BodyHash:
    count = len(crowd.reach)
    made = BodyHash(
        side=side,
        rows=rows,
        cols=cols,
        first=np.empty((len(first) - 1) * rows * cols + 1, dtype=np.int64),
        body=np.empty(count, dtype=np.int64),
        owner=np.empty(count, dtype=np.int64),
        disc=np.empty((count, 3)),
    )
    hash_bodies(crowd.poses, crowd.reach, crowd.owner, first, made)
    return made


def twin(crowd: Crowd, first: np.ndarray, rows: Looking) -> list[list[int]]:
    found: list[list[int]] = []
    for own, replica, limit, ahead in zip(*rows, strict=True):
        near = []
        for b in range(first[replica], first[replica + 1]):
            dx, dy = crowd.poses[b, :2] - crowd.poses[own, :2]
            speed = np.sqrt(crowd.twists[b, 0] * crowd.twists[b, 0] + crowd.twists[b, 1] * crowd.twists[b, 1])
            most = limit + crowd.reach[b] + speed * ahead
            if dx * dx + dy * dy <= most * most and crowd.owner[b] != crowd.owner[own]:
                near.append(b)
        found.append(near)
    return found


@pytest.mark.parametrize(("rows", "cols"), [(1, 1), (4, 8), (32, 32)])
@pytest.mark.parametrize("ahead", [0.0, 1.5])
def test_neighbours_are_those_of_all_pairs(rows: int, cols: int, ahead: float) -> None:
    random = np.random.default_rng(rows + cols)
    count, replicas = 60, 3
    poses = random.uniform(-10.0, 10.0, (count * replicas, 3))
    poses[7] = (1e17, -1e17, 0.0)  # out of every world
    owner = np.arange(count * replicas)
    owner[count - 2 : count] = 3  # two parts of a body of the first replica
    crowd = Crowd(poses, random.normal(size=poses.shape), random.uniform(0.1, 0.6, len(poses)), owner)
    first = np.arange(replicas + 1) * count
    body = np.sort(random.choice(count * replicas, 90, replace=False))
    body[0] = 3
    limits = random.uniform(0.0, 8.0, 90)
    limits[5], limits[6] = np.inf, 0.0
    looking = Looking(body, body // count, limits, np.full(90, ahead))
    expected = twin(crowd, first, looking)
    total = sum(map(len, expected))
    table = table_of(crowd, first, 1.2, rows, cols)
    starts, near = np.empty(91, dtype=np.int64), np.empty(total + 5, dtype=np.int64)
    assert find_neighbours(table, crowd, first, looking, starts, near) == total
    assert [near[a:b].tolist() for a, b in itertools.pairwise(starts)] == expected
    assert 0 < total < 90 * count


def test_without_room_it_says_how_much_is_needed() -> None:
    crowd = Crowd(np.zeros((4, 3)), np.zeros((4, 3)), np.full(4, 0.1), np.arange(4))
    first, own = np.array([0, 4]), np.arange(4)
    looking = Looking(own, np.zeros(4, dtype=np.int64), np.ones(4), np.zeros(4))
    starts, near = np.empty(5, dtype=np.int64), np.full(5, -1)
    assert find_neighbours(table_of(crowd, first, 1.0, 2, 2), crowd, first, looking, starts, near) == 12
    assert (near == -1).all()
