"""Slopes of walls against the expressions that say what they are, and cones against rays through circles."""

import math

import numpy as np
import pytest

from amorsim.kernels import elementary
from amorsim.kernels.sensing import slopes

EVEN, PATCH = 3.0, 0.05


def former(ranges, turn, probes):
    """What `incidences` gives, array by array."""

    def end(reach, angle):
        known = np.isfinite(reach)
        reach = np.where(known, reach, 0.0)
        x, y = reach * np.cos(angle), reach * np.sin(angle)
        return x, y, np.where(known, np.sqrt((x - ahead) ** 2 + y**2), np.inf)

    ahead = np.where(np.isfinite(ranges), ranges, 1.0)
    left_x, left_y, left_gap = end(probes[:, : ranges.shape[1]], turn)
    right_x, right_y, right_gap = end(probes[:, ranges.shape[1] :], -turn)
    both = np.maximum(left_gap, right_gap) <= EVEN * np.minimum(left_gap, right_gap)
    nearer_left = left_gap <= right_gap
    along = np.where(both, left_x - right_x, np.where(nearer_left, left_x, right_x) - ahead)
    across = np.where(both, left_y - right_y, np.where(nearer_left, left_y, right_y))
    found = np.isfinite(ranges) & np.isfinite(np.minimum(left_gap, right_gap))
    return elementary.arctan2(np.abs(np.where(found, along, 0.0)), np.abs(np.where(found, across, 1.0)))


@pytest.mark.parametrize("seed", range(3))
def test_the_angle_of_a_wall_is_that_of_the_line_where_probes_end(seed):
    rng = np.random.default_rng(seed)
    ranges = np.where(rng.random((500, 3)) < 0.1, np.inf, rng.uniform(0.01, 8.0, (500, 3)))
    turn = elementary.arctan2(PATCH, np.where(np.isfinite(ranges), ranges, 1.0))
    far = np.tile(np.where(np.isfinite(ranges), ranges, 1.0), 2) * rng.choice((1.0, 1.0, 1.02, 2.0), (500, 6))
    probes = np.where(rng.random((500, 6)) < 0.1, np.inf, far * rng.uniform(0.99, 1.01, (500, 6)))
    found = np.empty(ranges.shape)
    slopes.incidences(ranges, probes, PATCH, EVEN, found)
    assert found.tobytes() == former(ranges, turn, probes).tobytes()


@pytest.mark.parametrize("rows", [1, 200])
def test_probes_are_beside_their_beams_on_both_sides(rows):
    rng = np.random.default_rng(rows)
    ranges = np.where(rng.random((200, 3)) < 0.1, np.inf, rng.uniform(0.01, 8.0, (200, 3)))
    bearings = rng.uniform(-4.0, 4.0, (rows, 3))
    cos, sin = np.empty((200, 6)), np.empty((200, 6))
    slopes.probe(bearings, ranges, PATCH, cos, sin)
    turn = elementary.arctan2(PATCH, np.where(np.isfinite(ranges), ranges, 1.0))
    angles = np.concatenate((bearings + turn, bearings - turn), axis=1)
    assert cos.tobytes() == np.cos(angles).tobytes()
    assert sin.tobytes() == np.sin(angles).tobytes()


@pytest.mark.parametrize("own", [True, False])
def test_the_nearest_of_rays_is_the_first_of_the_least(own):
    rng = np.random.default_rng(4)
    ranges = rng.integers(0, 4, (300, 5)).astype(float)
    ranges[rng.random(ranges.shape) < 0.3] = np.inf
    bearings = rng.normal(size=(300 if own else 1, 5))
    bearing, nearest = np.empty((300, 1)), np.empty((300, 1))
    slopes.nearest_rays(bearings, ranges, bearing, nearest)
    which = np.argmin(ranges, axis=1)
    assert (nearest[:, 0] == ranges.min(axis=1)).all()
    assert (bearing[:, 0] == bearings[np.arange(300) if own else 0, which]).all()


@pytest.mark.long
def test_no_body_that_a_ray_meets_is_left_out_of_a_cone():
    rng = np.random.default_rng(5)
    rows, k, count = 200, 3, 4
    origins = rng.uniform((-2, -2, -3), (2, 2, 3), (rows * k, 3))
    half = rng.uniform(0.05, 1.5, (rows, 1))
    nearest = np.where(rng.random((rows * k, 1)) < 0.2, np.inf, rng.uniform(0.1, 4.0, (rows * k, 1)))
    range_max = rng.uniform(1.0, 5.0, (rows, 1))
    poses, reach = rng.uniform((-3, -3, -3), (3, 3, 3), (rows, count, 3)), rng.uniform(0.05, 0.3, count)
    owner, own = np.array([0, 1, 2, 1]), rng.integers(0, 3, rows)
    out = np.empty(rows * k, dtype=np.bool_)
    slopes.bodies_in_cones(origins, half, nearest, range_max, poses, reach, owner, own, out)
    met = np.zeros(rows * k, dtype=bool)
    for m, (x, y, heading) in enumerate(origins):
        n = m // k
        limit = min(nearest[m, 0], range_max[n, 0])
        for b in range(count):
            if own[n] in (b, owner[b]):
                continue
            to_x, to_y = poses[n, b, 0] - x, poses[n, b, 1] - y
            for angle in heading + half[n, 0] * np.linspace(-1.0, 1.0, 101):
                along = to_x * math.cos(angle) + to_y * math.sin(angle)
                across = to_x * math.sin(angle) - to_y * math.cos(angle)
                chord = reach[b] ** 2 - across**2
                if chord >= 0.0 and along + math.sqrt(chord) >= 0.0 and along - math.sqrt(chord) <= limit:
                    met[m] = True
    assert not (met & ~out).any()
    # Few are taken in besides: circles behind the tip of a cone, or before it beyond its corners.
    assert met.sum() > 20
    assert (out & ~met).sum() < 0.25 * len(out)
