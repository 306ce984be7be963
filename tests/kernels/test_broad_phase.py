"""Who has something near as bodies set out, against looking at all walls and all others."""

from __future__ import annotations

import numpy as np
import pytest

from amorsim.core.shapes import Shape, pack
from amorsim.core.workers import Workers
from amorsim.kernels.collision.body_hash import BodyHash, hash_bodies
from amorsim.kernels.collision.broad_phase import NEAR_BODY, NEAR_WALL, look_out
from amorsim.kernels.collision.clearance import map_gaps
from amorsim.kernels.collision.paths import ARC, LINE, OTHER, SLACK, STANDS, Paths, Scene, set_out
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


def expected(scene, replica, owner):
    """Slow and plain: ends, and who is near to what, one by one."""
    paths, bodies = scene.paths, scene.bodies
    end = np.empty_like(paths.start)
    set_out(paths, bodies.reach, end)
    everyone = np.arange(len(end))
    gaps, where = np.empty(len(end)), np.empty((len(end), 2))
    cap = paths.bound + SLACK
    map_gaps(scene.grid, 0.0, 0.0, 0.0, bodies, everyone, paths.start, cap, gaps, where)
    near = np.where((gaps < cap) & (paths.bound > 0.0), NEAR_WALL, 0)
    radius = bodies.reach + cap
    for i in everyone.tolist():
        for j in everyone.tolist():
            if replica[i] == replica[j] and owner[i] != owner[j] and radius[j] <= radius[i]:
                x, y, _ = paths.start[i] - paths.start[j]
                if x * x + y * y <= (radius[i] + radius[j]) ** 2:
                    near[i] |= NEAR_BODY
    return end, near


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("threads", [1, 2])
def test_it_tells_whom_looking_at_all_tells(seed, threads):
    scene, replica, owner, table = scene_of(seed)
    end, near = expected(scene, replica, owner)
    assert {0, NEAR_WALL, NEAR_BODY, NEAR_WALL | NEAR_BODY} == set(near.tolist())
    found_end, found_near = np.empty_like(end), np.empty(len(end), dtype=np.uint8)
    bound, stop = scene.paths.bound.copy(), scene.paths.stop.copy()
    other = scene.paths.form == OTHER
    scene.paths.bound[~other] = np.nan  # they have not set out
    scene.paths.stop[:] = np.nan
    Workers(threads, processors=threads).share(
        len(end), 1000, lambda first, last: look_out(first, last, scene, replica, owner, table, found_end, found_near)
    )
    np.testing.assert_array_equal(found_end, end)
    np.testing.assert_array_equal(found_near, near)
    np.testing.assert_array_equal(scene.paths.bound, bound)
    np.testing.assert_array_equal(scene.paths.stop, stop)
