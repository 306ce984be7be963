"""The hash of bodies: everyone is in it, and it finds the pairs that looking at all of them finds."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.kernels.collision.body_hash import BodyHash, hash_bodies, pairs_within, run_of_bodies, window
from tests.examples import settings


def table_of(poses, reach, first, buckets, side):
    rows, cols = buckets
    count = len(poses)
    table = BodyHash(
        side=side,
        rows=rows,
        cols=cols,
        first=np.empty((len(first) - 1) * rows * cols + 1, dtype=np.int64),
        body=np.full(count, -1, dtype=np.int64),
        owner=np.full(count, -1, dtype=np.int64),
        disc=np.empty((count, 3)),
    )
    hash_bodies(poses, reach, np.arange(count), first, table)
    return table


def replicas_of(first):
    return np.repeat(np.arange(len(first) - 1), np.diff(first))


def pairs_of(table, first, poses, radius, looks=None, room=10_000):
    out = np.empty(room, dtype=np.int64)
    looks = np.ones(len(poses), dtype=bool) if looks is None else looks
    count = pairs_within(table, replicas_of(first), looks, poses, radius, out)
    assert count <= room
    found = sorted(divmod(key, len(poses)) for key in out[:count].tolist())
    assert len(set(found)) == len(found)
    return found


def expected_pairs(first, poses, radius):
    """All against all."""
    found = []
    for begin, end in zip(first[:-1].tolist(), first[1:].tolist(), strict=True):
        for a in range(begin, end):
            for b in range(a + 1, end):
                x, y, _ = poses[a] - poses[b]
                if x * x + y * y <= (radius[a] + radius[b]) ** 2:
                    found.append((a, b))
    return found


def crowd(rng, count, spread, centre=0.0):
    poses = np.c_[centre + rng.uniform(-spread, spread, (count, 2)), rng.uniform(-4, 4, count)]
    return poses, rng.uniform(0.1, 0.5, count)


@settings(deadline=None, max_examples=150)
@given(
    seed=st.integers(0, 10**6),
    count=st.integers(0, 40),
    spread=st.sampled_from([0.0, 0.5, 5.0, 300.0]),
    centre=st.sampled_from([0.0, -1e3, 1e7]),
    buckets=st.sampled_from([(1, 1), (1, 2), (4, 4), (8, 16)]),
    margin=st.sampled_from([0.0, 0.4, 100.0, 1e9]),
)
def test_pairs_are_those_of_looking_at_all(seed, count, spread, centre, buckets, margin):
    """Also where far bodies share a bucket, and where one moves so far that it might meet everybody."""
    rng = np.random.default_rng(seed)
    poses, reach = crowd(rng, count, spread, centre)
    first = np.array([0, count // 3, count // 3, count], dtype=np.int64)
    radius = reach + margin * rng.uniform(0, 1, count) ** 8
    table = table_of(poses, reach, first, buckets, side=1.0)
    expected = expected_pairs(first, poses, radius)
    assert pairs_of(table, first, poses, radius) == expected
    looks = rng.random(count) < 0.5
    assert pairs_of(table, first, poses, radius, looks) == [(a, b) for a, b in expected if looks[a] or looks[b]]


def test_bodies_on_the_borders_of_cells_are_found():
    """Circles that just touch, their centres on grid lines, on both sides of the origin."""
    poses = np.array([[x, y, 0.0] for x in range(-3, 4) for y in range(-3, 4)], dtype=float)
    radius = np.full(len(poses), 0.5)
    first = np.array([0, len(poses)], dtype=np.int64)
    expected = expected_pairs(first, poses, radius)
    assert len(expected) == 2 * 6 * 7
    assert pairs_of(table_of(poses, radius, first, (4, 8), 1.0), first, poses, radius) == expected


def test_everyone_is_in_the_hash_once_and_in_order_within_a_bucket():
    rng = np.random.default_rng(1)
    poses, reach = crowd(rng, 500, 20.0)
    first = np.array([0, 200, 500], dtype=np.int64)
    table = table_of(poses, reach, first, (8, 16), 1.0)
    assert sorted(table.body.tolist()) == list(range(500))
    assert (table.first[0], table.first[8 * 16], table.first[-1]) == (0, 200, 500)
    for begin, end in zip(table.first[:-1], table.first[1:], strict=True):
        assert (np.diff(table.body[begin:end]) > 0).all()
    np.testing.assert_array_equal(table.disc, np.c_[poses[table.body, :2], reach[table.body]])


def test_pairs_beyond_the_room_for_them_are_counted_and_not_written():
    poses = np.zeros((10, 3))
    radius = np.ones(10)
    first = np.array([0, 10], dtype=np.int64)
    table = table_of(poses, radius, first, (2, 2), 1.0)
    out = np.full(20, -1, dtype=np.int64)
    assert pairs_within(table, replicas_of(first), np.ones(10, dtype=bool), poses, radius, out[:7]) == 45
    assert (out[:7] >= 0).all()
    assert (out[7:] == -1).all()


@pytest.mark.parametrize("half", [0.0, 0.3, 2.0, 1e3, np.inf])
def test_a_window_holds_all_within_it_and_no_bucket_twice(half):
    rng = np.random.default_rng(2)
    poses, reach = crowd(rng, 300, 12.0)
    first = np.array([0, 300], dtype=np.int64)
    table = table_of(poses, reach, first, (16, 8), 1.0)
    for x, y in rng.uniform(-14, 14, (50, 2)):
        row0, rows = window(y, half, table.side, table.rows)
        col0, cols = window(x, half, table.side, table.cols)
        runs = [run_of_bodies(table, 0, row0, rows, col0, cols, run) for run in range(2 * rows)]
        seen = [int(body) for begin, end in runs for body in table.body[begin:end]]
        assert len(set(seen)) == len(seen)
        inside = np.flatnonzero((np.abs(poses[:, :2] - (x, y)) <= half).all(axis=1))
        assert set(inside.tolist()) <= set(seen)
        if half == 0.3:
            assert len(seen) < 60


@pytest.mark.parametrize("place", [np.nan, np.inf, -np.inf, 1e300, -1e300])
def test_places_that_are_out_of_this_world_are_no_trouble(place):
    poses = np.array([[place, 0.0, 0.0], [0.0, place, 0.0], [0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    reach = np.full(4, 0.3)
    first = np.array([0, 4], dtype=np.int64)
    assert pairs_of(table_of(poses, reach, first, (4, 4), 1.0), first, poses, reach) == [(2, 3)]
