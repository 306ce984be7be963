"""Gaps between bodies, against shapely and on coordinates where every operation is exact."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from shapely.affinity import affine_transform

from amorsim.core.shapes import Shape, pack
from amorsim.kernels.collision.footprints import body_gaps
from tests.examples import settings

BAND = 1e-12  # [m] rounding of the oracle's and the kernel's coordinates together stays far below this
SHAPES = [
    Shape.circle(0.25),
    Shape.circle(0.1, x=0.3, y=-0.2),
    Shape.rectangle(0.5, 0.4),
    Shape.rectangle(2.0, 0.01, x=0.5),
    Shape.polygon([(0, 0), (0.25, 0.2), (-0.2, 0), (0.25, -0.2)]),
    Shape.polygon([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0.9), (0.9, 0.9), (0.9, 0.1), (0, 0.1)]),
    Shape.polygon([(0, 0), (0.5, 0), (0.25, 0.5)], rounding=0.125),
    Shape(vertices=(((-0.5, 0.0), (0.5, 0.0)),), radius=0.2, border=((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))),
]
BODIES = pack(SHAPES)

places = st.floats(-1.5, 1.5)
poses = st.tuples(places, places, st.floats(-4, 4))
indices = st.integers(0, len(SHAPES) - 1)


def gaps(a, poses_a, b, poses_b, cap=math.inf, bodies=BODIES):
    a = np.atleast_1d(np.asarray(a, dtype=np.int64))
    out = np.full(len(a), np.nan)
    body_gaps(
        bodies,
        a,
        np.array(poses_a, dtype=float).reshape(-1, 3),
        np.atleast_1d(np.asarray(b, dtype=np.int64)),
        np.array(poses_b, dtype=float).reshape(-1, 3),
        np.broadcast_to(np.asarray(cap, dtype=float), a.shape).copy(),
        out,
    )
    return out


def gap(a, pose_a, b, pose_b, cap=math.inf):
    return float(gaps(a, pose_a, b, pose_b, cap)[0])


def core(shape, pose):
    """The shape before rounding, placed, as shapely has it."""
    parts = [{1: shapely.Point, 2: shapely.LineString}.get(len(p), shapely.Polygon)(p) for p in shape.parts]
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return [affine_transform(part, [c, -s, s, c, pose[0], pose[1]]) for part in parts]


def expected_gap(shape_a, pose_a, shape_b, pose_b):
    """Distance less both radii; if the cores overlap, negative by an amount that says how clearly."""
    radius = shape_a.radius + shape_b.radius
    pairs = [(p, q) for p in core(shape_a, pose_a) for q in core(shape_b, pose_b)]
    distance = min(p.distance(q) for p, q in pairs)
    if distance > 0.0 or radius > 0.0:
        return distance - radius
    return -max(p.intersection(q).area for p, q in pairs)


def check_pair(a, pose_a, b, pose_b):
    expected = expected_gap(SHAPES[a], pose_a, SHAPES[b], pose_b)
    found = gap(a, pose_a, b, pose_b)
    if expected >= 0.0:
        assert -BAND < found <= expected + BAND
        assert found >= expected - BAND
        if expected > BAND:
            assert found > 0.0
    elif expected < -BAND:
        assert found < 0.0


@settings(deadline=None)
@given(indices, poses, indices, poses)
def test_the_gap_is_the_distance_and_its_sign_is_overlap(a, pose_a, b, pose_b):
    check_pair(a, pose_a, b, pose_b)


def random_queries(count, seed, spread):
    rng = np.random.default_rng(seed)
    a, b = rng.integers(0, len(SHAPES), (2, count))
    return a, rng.uniform(-spread, spread, (count, 3)), b, rng.uniform(-spread, spread, (count, 3))


@pytest.mark.long
def test_six_thousand_random_pairs_agree_with_shapely():
    for a, pose_a, b, pose_b in zip(*random_queries(6000, 1, 1.2), strict=True):
        check_pair(a, pose_a, b, pose_b)


@pytest.mark.nightly
def test_a_hundred_thousand_random_pairs_agree_with_shapely():
    for a, pose_a, b, pose_b in zip(*random_queries(100_000, 2, 1.2), strict=True):
        check_pair(a, pose_a, b, pose_b)


def test_the_gap_is_symmetric_to_the_bit():
    a, poses_a, b, poses_b = random_queries(20_000, 3, 2.0)
    there = gaps(a, poses_a, b, poses_b)
    back = gaps(b, poses_b, a, poses_a)
    np.testing.assert_array_equal(there.view(np.int64), back.view(np.int64))
    assert (there < 0.0).any()
    assert (there > 0.0).any()


@pytest.mark.parametrize("cap", [0.0, 0.01, 0.5])
def test_a_cap_only_caps(cap):
    a, poses_a, b, poses_b = random_queries(20_000, 4, 1.5)
    free = gaps(a, poses_a, b, poses_b)
    capped = gaps(a, poses_a, b, poses_b, cap)
    np.testing.assert_array_equal(capped < 0.0, free < 0.0)
    np.testing.assert_array_equal(capped[free >= 0.0], np.minimum(free, cap)[free >= 0.0])


def test_a_query_does_not_depend_on_the_others():
    a, poses_a, b, poses_b = random_queries(200, 5, 1.2)
    together = gaps(a, poses_a, b, poses_b, 0.5)
    alone = [gap(a[q], poses_a[q], b[q], poses_b[q], 0.5) for q in range(200)]
    np.testing.assert_array_equal(together, alone)


@settings(deadline=None)
@given(indices, poses, indices, poses, st.floats(-4, 4), st.floats(0, 1))
def test_moving_by_no_more_than_the_gap_never_overlaps(a, pose_a, b, pose_b, direction, fraction):
    free = gap(a, pose_a, b, pose_b)
    if free > 0.0:
        step = fraction * free
        moved = (pose_a[0] + step * math.cos(direction), pose_a[1] + step * math.sin(direction), pose_a[2])
        assert gap(a, moved, b, pose_b) >= 0.0


def test_the_whole_gap_straight_towards_a_circle_touches_without_overlap():
    """The worst case of the property above, at coordinates of every size."""
    rng = np.random.default_rng(6)
    for scale in (0.3, 3.0, 300.0, 30_000.0):
        for _ in range(300):
            pose_a = (*rng.uniform(-scale, scale, 2), 0.0)
            pose_b = (*rng.uniform(-scale, scale, 2), 0.0)
            free = gap(0, pose_a, 0, pose_b)
            if free <= 0.0:
                continue
            dx, dy = pose_b[0] - pose_a[0], pose_b[1] - pose_a[1]
            step = free / math.hypot(dx, dy)
            left = gap(0, (pose_a[0] + step * dx, pose_a[1] + step * dy, 0.0), 0, pose_b)
            assert 0.0 <= left < 1e-14 * scale + 1e-14


SQUARE, DIAMOND, DISC, MOUTH = range(4)
EXACT = pack(
    [
        Shape.rectangle(1.0, 1.0),
        Shape.polygon([(0.5, 0), (0, 0.5), (-0.5, 0), (0, -0.5)]),
        Shape.circle(1.25),
        Shape.polygon([(0, 0), (3, 0), (3, 3), (0, 3), (0, 2), (2, 2), (2, 1), (0, 1)]),
    ]
)
TINY = 2.0**-40


@pytest.mark.parametrize(
    ("a", "at_a", "b", "at_b"),
    [
        (SQUARE, (0, 0), SQUARE, (1, 0)),
        (SQUARE, (7, 3), SQUARE, (7, 4)),
        (SQUARE, (0, 0), SQUARE, (1, 0.5)),
        (SQUARE, (0, 0), SQUARE, (1, 1)),
        (SQUARE, (0, 0), DIAMOND, (1, 0)),
        (SQUARE, (0, 0), DIAMOND, (0.75, 0.75)),
        (DIAMOND, (0, 0), DIAMOND, (0.5, 0.5)),
        (DISC, (0, 0), DISC, (1.5, 2.0)),
        (DISC, (0, 0), DISC, (2.5, 0)),
        (SQUARE, (0, 0), DISC, (1.75, 0.25)),
        (SQUARE, (0, 0), DISC, (0.5 + 0.75, 0.5 + 1.0)),
        (MOUTH, (0, 0), SQUARE, (1.5, 1.5)),  # in the mouth, touching three of its sides
    ],
)
def test_touching_is_free_and_the_least_step_further_overlaps(a, at_a, b, at_b):
    pose_a, pose_b = (*at_a, 0), (*at_b, 0)
    assert gaps(a, pose_a, b, pose_b, bodies=EXACT)[0] == 0.0
    inward = np.array([at_a[0] - at_b[0], at_a[1] - at_b[1]])
    if a == MOUTH:
        inward = np.array([1.0, 0.0])
    shifted = np.array([*(at_b + TINY * np.sign(inward)), 0.0])
    assert gaps(a, pose_a, b, shifted, bodies=EXACT)[0] < 0.0
    away = np.array([*(at_b - TINY * np.sign(inward)), 0.0])
    if a != MOUTH:
        assert gaps(a, pose_a, b, away, bodies=EXACT)[0] > 0.0


def test_one_body_in_the_middle_of_another_overlaps():
    assert gaps(SQUARE, (0, 0, 0), SQUARE, (0, 0, 0), bodies=EXACT)[0] < 0.0
    assert gaps(DISC, (0, 0, 0), DISC, (0, 0, 0), bodies=EXACT)[0] < 0.0
    assert gaps(SQUARE, (0, 0, 0), DISC, (0, 0, 0), bodies=EXACT)[0] < 0.0
    assert gap(5, (0, 0, 0), 2, (5, 0, 0)) > 0.0


@settings(deadline=None)
@given(st.data())
def test_integer_polygons_overlap_exactly_where_shapely_says(data):
    """On small integers both predicates are exact, so the sign must agree always, touching included."""
    corners = st.lists(st.tuples(st.integers(-3, 3), st.integers(-3, 3)), min_size=3, max_size=5)
    shapes, placed = [], []
    for _ in range(2):
        try:
            shapes.append(Shape.polygon(data.draw(corners)))
        except ValueError:
            return
        x, y = data.draw(st.tuples(st.integers(-4, 4), st.integers(-4, 4)))
        placed.append((x, y, 0))
    polygons = [shapely.Polygon(shape.outline + pose[:2]) for shape, pose in zip(shapes, placed, strict=True)]
    found = gaps(0, placed[0], 1, placed[1], bodies=pack(shapes))[0]
    assert (found < 0.0) == polygons[0].relate_pattern(polygons[1], "T********")
