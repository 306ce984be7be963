"""The table of what robots send is, to the bit, the one that sorting all of them gives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amorsim.kernels.sensing.heard import Senders, hear_nearest


def twin(near: Senders, mounts: np.ndarray, range_max: np.ndarray, slots: int) -> np.ndarray:
    out = np.full((len(near.own), slots, 6), (math.inf, math.inf, math.inf, 0.0, 0.0, 0.0))
    for n, own in enumerate(near.own.tolist()):
        found = []
        for body in near.body[near.first[n] : near.first[n + 1]].tolist():
            dx, dy = (near.poses[body, :2] - near.poses[own, :2]).tolist()
            if near.sends[body] and dx * dx + dy * dy <= range_max[n, 0] ** 2:
                found.append((dx * dx + dy * dy, body))
        own_c, own_s = math.cos(mounts[n, 2]), math.sin(mounts[n, 2])
        for place, (_, body) in enumerate(sorted(found)[:slots]):
            dx, dy = (near.poses[body, :2] - mounts[n, :2]).tolist()
            c, s = math.cos(near.poses[body, 2]), math.sin(near.poses[body, 2])
            forward, left, _ = near.twists[body].tolist()
            vx, vy = c * forward - s * left, s * forward + c * left
            place_ = own_c * dx + own_s * dy, own_c * dy - own_s * dx
            velocity = own_c * vx + own_s * vy, own_c * vy - own_s * vx
            out[n, place] = (math.sqrt(dx * dx + dy * dy), *place_, *velocity, near.reach[body])
    return out


@pytest.mark.parametrize("slots", [1, 4, 30])
def test_tables_are_those_of_sorting_all_senders(slots: int) -> None:
    random = np.random.default_rng(slots)
    bodies, rows = 40, 25
    poses = random.uniform(-4.0, 4.0, (bodies, 3))
    poses[:9, :2] = [(a, b) for a in (-1.0, 0.0, 1.0) for b in (-1.0, 0.0, 1.0)]  # four and four at the same distance
    poses[9, 0] = math.nan
    own = random.permutation(bodies)[:rows]
    own[0] = 4  # in their middle
    lists = [[b for b in range(bodies) if b != o and (n == 0 or random.random() < 0.7)] for n, o in enumerate(own)]
    lists[3] = []
    first = np.cumsum([0, *map(len, lists)])
    near = Senders(
        own,
        first,
        np.array([b for one in lists for b in one]),
        poses,
        random.normal(size=(bodies, 3)),
        random.uniform(0.1, 0.5, bodies),
        random.random(bodies) < 0.8,
    )
    mounts = poses[own] + random.normal(size=(rows, 3)) * 0.1
    range_max = random.uniform(1.0, 6.0, (rows, 1))
    range_max[1], range_max[2] = math.inf, 1e-3
    out = np.full((rows, slots, 6), 7.0)
    hear_nearest(near, mounts, range_max, out)
    np.testing.assert_array_equal(out, twin(near, mounts, range_max, slots))
