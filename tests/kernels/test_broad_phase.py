"""Which bodies have something near as they set out, and the clearance they keep, against all walls and bodies."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.core.execution.workers import Workers
from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision.body_hash import BodyHash, hash_bodies
from amorsim.kernels.collision.broad_phase import NEAR_BODY, NEAR_WALL, Clearance, look_around, set_out
from amorsim.kernels.collision.clearance import map_gaps
from amorsim.kernels.collision.paths import ARC, LINE, OTHER, SLACK, STANDS, Paths, Scene, poses_at
from amorsim.kernels.grid.draft import grid_from_array

SHAPES = [Shape.circle(0.3), Shape.rectangle(0.8, 0.4), Shape.circle(0.05), Shape.rectangle(0.3, 0.3)]


def scene_of(seed, count=60, replicas=2, size=12.0):
    """Bodies anywhere in a room with some cells of 0.1 m in it, some at rest, some faster than others; and their hash.

    Every fifth is a part of the one before.
    """
    rng = np.random.default_rng(seed)
    cells = rng.random((int(size * 10), int(size * 10))) < 0.004
    total = count * replicas
    poses = np.c_[rng.uniform(0.0, size, (total, 2)), rng.uniform(-4.0, 4.0, total)]
    shapes = [SHAPES[n] for n in rng.integers(0, len(SHAPES), total)]
    bodies = pack(shapes)
    form = rng.choice(np.array([STANDS, ARC, LINE, OTHER], dtype=np.uint8), total)
    motion = np.where((form == STANDS)[:, None], 0.0, rng.normal(0.0, 0.15, (total, 3)) * rng.uniform(0, 2, (total, 1)))
    bound = np.where(form == OTHER, rng.uniform(0.0, 0.5, total), np.nan)
    owner = np.arange(total)
    owner[4::5] -= 1
    first = np.arange(replicas + 1, dtype=np.int64) * count
    table = BodyHash(
        2.0, 4, 8, *(np.empty(n, dtype=np.int64) for n in (replicas * 32 + 1, total, total)), np.empty((total, 3))
    )
    hash_bodies(poses, bodies.reach, owner, first, table)
    paths = Paths(poses, motion, form, bound, np.full(total, np.nan))
    scene = Scene(grid_from_array(cells, 0.1), 0.0, 0.0, 0.0, bodies, 4, paths)
    return scene, np.repeat(np.arange(replicas), count), owner, table


def set_out_all(scene, first, record):
    """Ends, the fastest of each replica, and who has to look around."""
    count = len(scene.paths.start)
    end, fastest, looking = np.full((count, 3), np.nan), np.full(len(first) - 1, np.nan), np.full(count, -1)
    # Of paths of form `OTHER`, of which the scene holds the bound.
    travel = np.stack((scene.paths.bound / (1.0 + 1e-9), np.zeros(count)), axis=1)
    start, motion, form, bound, stop = scene.paths
    lookers = set_out(
        *(start, motion, form, travel, bound, stop, scene.bodies.reach, first, *record, end, fastest, looking)
    )
    return end, fastest, looking[:lookers]


def nothing_known(scene):
    count = len(scene.paths.start)
    return Clearance(np.full((count, 3), np.nan), np.full(count, np.nan), np.full(count, np.nan))


def least_gaps(scene, replica, owner):
    """Slow and plain, at the start: of each body to the walls, and of its circle to those of others."""
    start, bodies = scene.paths.start, scene.bodies
    everyone = np.arange(len(start))
    walls, where = np.empty(len(start)), np.empty((len(start), 2))
    map_gaps(scene.grid, 0.0, 0.0, 0.0, bodies, everyone, start, np.full(len(start), 100.0), walls, where)
    others = np.full(len(start), np.inf)
    for i in everyone.tolist():
        for j in everyone.tolist():
            if replica[i] == replica[j] and owner[i] != owner[j]:
                gap = np.hypot(*(start[i] - start[j])[:2]) - bodies.reach[i] - bodies.reach[j]
                others[i] = min(others[i], gap)
    return walls, others


@pytest.mark.parametrize("seed", range(8))
def test_bodies_set_out_along_their_paths(seed):
    scene, replica, _, _ = scene_of(seed)
    paths = scene.paths
    given = paths.bound.copy()
    end, fastest, looking = set_out_all(scene, np.array([0, 60, 120]), nothing_known(scene))
    assert (paths.stop == 1.0).all()
    standing, other = paths.form == STANDS, paths.form == OTHER
    np.testing.assert_array_equal(end[standing], paths.start[standing])
    np.testing.assert_allclose(paths.bound[other], given[other], rtol=1e-15)
    assert (paths.bound[standing] == 0.0).all()
    expected = np.empty_like(end)
    poses_at(paths, np.arange(120), np.ones(120), expected)
    np.testing.assert_array_equal(end[~other], expected[~other])
    # No point of a body comes farther than its bound.
    turned = np.abs(np.where((paths.form == ARC) | (paths.form == LINE), paths.motion[:, 2], 0.0))
    moved = np.hypot(*(end - paths.start)[:, :2].T) + 2.0 * np.sin(np.minimum(turned, np.pi) / 2.0) * 0.05
    assert (moved <= paths.bound + 1e-12)[~other].all()
    for number in (0, 1):
        assert fastest[number] == paths.bound[replica == number].max()
    np.testing.assert_array_equal(looking, np.flatnonzero(paths.bound > 0.0))  # nothing is known


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_motion_that_is_not_finite_is_refused(value):
    scene, _, _, _ = scene_of(1)
    scene.paths.motion[70, 1] = value
    count = len(scene.paths.start)
    outputs = np.empty((count, 3)), np.empty(2), np.empty(count, dtype=np.int64)
    given = *scene.paths[:3], np.zeros((count, 2)), *scene.paths[3:], scene.bodies.reach
    assert set_out(*given, np.array([0, 60, 120]), *nothing_known(scene), *outputs) == -1


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("threads", [1, 2])
def test_looking_around_tells_what_looking_at_all_tells(seed, threads):
    scene, replica, owner, table = scene_of(seed)
    record = nothing_known(scene)
    _, fastest, looking = set_out_all(scene, np.array([0, 60, 120]), record)
    near = np.empty(len(looking), dtype=np.uint8)
    given = looking, scene, replica, owner, table, fastest, 1.0, record, near
    Workers(threads, processors=threads).share(len(near), 1000, lambda first, last: look_around(first, last, *given))
    walls, others = least_gaps(scene, replica, owner)
    walls, others = walls[looking], others[looking]
    own = scene.paths.bound[looking] + SLACK
    both = own + fastest[replica[looking]] + SLACK
    expected = np.where(walls < own, NEAR_WALL, 0) | np.where(others < both, NEAR_BODY, 0)
    assert {0, NEAR_WALL, NEAR_BODY, NEAR_WALL | NEAR_BODY} == set(expected.tolist())
    np.testing.assert_array_equal(near, expected)
    # What is left is no more than the gap less what the step may take, and enough for another such step if there is.
    for left, gap, taken in ((record.walls[looking], walls, own), (record.others[looking], others, both)):
        assert (left <= np.maximum(gap, 0.0) - taken + 1e-12).all()
        assert (left >= np.minimum(gap, 2.0 * taken) - taken - 1e-12)[gap >= 0.0].all()


def record_of(scene, walls, others):
    count = len(scene.paths.start)
    return Clearance(scene.paths.start.copy(), np.full(count, walls), np.full(count, others))


def test_who_has_room_does_not_look_and_uses_it_up():
    scene, replica, _, _ = scene_of(1)
    record = record_of(scene, 50.0, 60.0)
    _, fastest, looking = set_out_all(scene, np.array([0, 60, 120]), record)
    assert not len(looking)
    bound = scene.paths.bound
    own = np.where(bound > 0.0, bound + SLACK, 0.0)
    np.testing.assert_allclose(record.walls, 50.0 - own, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(record.others, 60.0 - own - fastest[replica] - SLACK, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("coordinate", range(3))
def test_if_one_is_elsewhere_all_of_its_replica_look(coordinate):
    scene, replica, _, _ = scene_of(1)
    record = record_of(scene, 50.0, 60.0)
    record.at[70, coordinate] = np.nextafter(record.at[70, coordinate], 100.0)
    _, _, looking = set_out_all(scene, np.array([0, 60, 120]), record)
    np.testing.assert_array_equal(looking, np.flatnonzero((scene.paths.bound > 0.0) & (replica == 1)))


@pytest.mark.parametrize(("walls", "others"), [(0.01, 60.0), (50.0, 0.02), (np.nan, 60.0), (50.0, np.nan)])
def test_who_has_not_room_enough_for_the_step_looks(walls, others):
    scene, replica, _, _ = scene_of(1)
    record = record_of(scene, walls, others)
    _, fastest, looking = set_out_all(scene, np.array([0, 60, 120]), record)
    own = scene.paths.bound + SLACK
    lacks = ~(own < walls) | ~(own + fastest[replica] + SLACK < others)
    assert lacks.any()
    np.testing.assert_array_equal(looking, np.flatnonzero(lacks & (scene.paths.bound > 0.0)))
