"""How long a body may keep a twist: against walking along the arc."""

import math

import numpy as np
import pytest

from amorsim.kernels.avoidance.arcs import Box, distance_to_box, free_time, keep_room

ENOUGH = 3.0


def walk(point, room, v, w, box, step=1e-3):
    """The first time at which the rounded box holds the point, by small steps; inf if it does not in `ENOUGH`."""
    times = np.arange(0.0, ENOUGH, step)
    turn = w * times
    x, y = v * times, np.zeros_like(times)
    if w != 0.0:
        x, y = v / w * np.sin(turn), v / w * (1.0 - np.cos(turn))
    c, s = np.cos(turn), np.sin(turn)
    dx, dy = point[0] - x, point[1] - y
    px, py = c * dx + s * dy, c * dy - s * dx
    ox = np.maximum(np.maximum(box.rear - px, px - box.front), 0.0)
    oy = np.maximum(np.maximum(box.right - py, py - box.left), 0.0)
    is_in = np.hypot(ox, oy) < room if room > 0.0 else (ox == 0.0) & (oy == 0.0)
    hits = np.flatnonzero(is_in & (np.hypot(px, py) < box.reach + room))
    return times[hits[0]] if len(hits) else math.inf


BODIES = [
    (Box(-0.25, 0.25, -0.2, 0.2, math.inf), 0.05),
    (Box(-0.4, 0.1, -0.15, 0.25, math.inf), 0.0),
    (Box(0.0, 0.0, 0.0, 0.0, math.inf), 0.3),
    (Box(0.1, 0.1, -0.05, -0.05, math.inf), 0.2),
    (Box(-0.3, 0.21, -0.21, 0.21, 0.33), 0.05),
    (Box(-0.3, 0.21, -0.21, 0.21, 0.33), 0.0),
]


@pytest.mark.parametrize(("box", "room"), BODIES)
def test_a_twist_ends_where_a_walk_along_its_arc_ends(box, room):
    random = np.random.default_rng(1)
    met = 0
    for trial in range(400):
        v, w = random.uniform(-1.0, 1.0), random.uniform(-2.0, 2.0)
        if trial % 5 == 0:
            w = 0.0
        if trial % 7 == 0:
            v = 0.0
        point = random.uniform(-0.9, 0.9, 2)
        if distance_to_box(*point, box) <= room + 2e-4:
            continue
        points = np.array([[point[0]], [point[1]], [room]])
        found = free_time(points, 1, v, w, box, ENOUGH, 0.0)
        walked = walk(point, room, v, w, box)
        met += walked < ENOUGH
        if not math.isclose(found, min(walked, ENOUGH), abs_tol=2e-3):
            # A graze so short that the walk steps over it.
            assert found < walked
            after = walk(point, room + 1e-5 + 1e-3 * (abs(v) + abs(w)), v, w, box)
            assert after <= found + 2e-3
    assert met > 30


def test_the_first_of_many_points_counts():
    box = Box(-0.2, 0.2, -0.2, 0.2, math.inf)
    points = np.array([[2.0, 1.0, 3.0], [0.0, 0.1, 0.0], [0.05, 0.05, 0.05]])
    assert free_time(points, 3, 0.5, 0.0, box, 10.0, 0.0) == pytest.approx((1.0 - 0.25) / 0.5)
    assert free_time(points, 3, 0.5, 0.0, box, 1.0, 0.0) == 1.0
    assert free_time(points, 0, 0.5, 0.3, box, 10.0, 0.0) == 10.0
    assert free_time(points, 3, 0.0, 0.0, box, 10.0, 0.0) == 10.0


def test_a_body_may_leave_what_is_within_its_margin_but_not_go_nearer():
    box = Box(-0.2, 0.2, -0.2, 0.2, math.inf)
    kept = np.empty((3, 3))
    seen = np.array([[0.23, math.inf, 5.0], [0.0, math.inf, 5.0]])
    assert keep_room(seen, box, 0.05, 1.0, kept) == 1
    assert kept[2, 0] == pytest.approx(0.03, abs=2e-4)
    assert free_time(kept, 1, 0.5, 0.0, box, 10.0, 0.0) < 1e-3
    assert free_time(kept, 1, -0.5, 0.0, box, 10.0, 0.0) == 10.0
