"""What `wander` makes of ranges, against slow twins."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from amorsim.controllers.beams import with_directions
from amorsim.kernels.behaviours.free_space import (
    choose_direction,
    directions_within,
    find_opening,
    free_way,
    nearest_distance,
    nearest_side,
    see_points,
)
from tests.examples import settings

EMPTY_TRAIL = np.zeros((8, 2))
HALF_CIRCLE = np.radians([-90.0, 90.0])
WEIGHTS = np.empty(directions_within(HALF_CIRCLE))


def scan(beams, ranges, half_angle=0.0, samples=1):
    points = np.empty((3, len(ranges) * samples))
    placed = with_directions(np.array(beams, dtype=float)[None])[0]
    see_points(np.array(ranges, dtype=float), placed, half_angle, points)
    return points


def as_seen(points):
    """Points (p, 2) as `see_points` leaves them."""
    return np.concatenate((np.transpose(points), np.empty((1, len(points)))))


def box_scan(ahead, left, right, behind):
    """What a scanner of 181 beams sees in a box, as points."""
    bearings = np.radians(np.arange(-90.0, 91.0))
    c, s = np.cos(bearings), np.sin(bearings)
    with np.errstate(divide="ignore"):
        along = np.where(c > 1e-9, ahead / np.maximum(c, 1e-9), np.inf)
        across = np.where(s > 0, left / np.maximum(s, 1e-9), right / np.maximum(-s, 1e-9))
    beams = np.stack((np.zeros(181), np.zeros(181), bearings), axis=1)
    return scan(beams, np.minimum(along, across))


def walk(points, bearing, half_width, step=1e-3, most=4.0):
    """The slow twin of `free_way`: step by step until the disc holds a point that it is not leaving."""
    direction = np.array([math.cos(bearing), math.sin(bearing)])
    points = points[np.isfinite(points[:, 0])]
    relevant = points[points[:, 0] * direction[0] + points[:, 1] * direction[1] > 0.0]
    for n in range(int(most / step)):
        gap = np.hypot(*(relevant - direction * n * step).T)
        if (gap < half_width).any():
            return n * step
    return math.inf


@pytest.mark.long
@settings(max_examples=60, deadline=None)  # the first call may compile
@given(seed=st.integers(0, 2**32 - 1), bearing=st.floats(-3.2, 3.2), half_width=st.floats(0.05, 0.6))
def test_the_free_way_is_as_far_as_a_disc_can_be_walked(seed, bearing, half_width):
    points = np.random.default_rng(seed).uniform(-3.0, 3.0, size=(12, 2))
    points = points[np.hypot(*points.T) > half_width]  # it stands free
    points = np.concatenate((points, [[math.inf, math.inf]]))
    walked = min(4.0, walk(points, bearing, half_width))
    # Steps may miss a point that the disc only grazes, so a hair wider and a hair narrower bound it.
    wider, narrower = (free_way(as_seen(points), bearing, half_width + hair, 0.0) for hair in (1e-4, -1e-4))
    assert min(4.0, wider) - 2e-3 <= walked <= narrower + 2e-3


def test_points_far_ahead_count_as_nearer_to_a_way_that_may_spread():
    points = as_seen([[2.0, 0.5]])
    assert free_way(points, 0.0, 0.4, 0.0) == math.inf
    assert free_way(points, 0.0, 0.4, 0.06) == pytest.approx(2.0 - math.sqrt(0.4**2 - 0.38**2))


def test_beams_are_points_and_no_return_is_none():
    points = scan([[0.1, 0.0, 0.0], [0.1, 0.2, math.pi / 2], [0.0, 0.0, 1.0]], [1.0, 0.5, math.inf])
    np.testing.assert_allclose(points[:2, :2], [[1.1, 0.1], [0.0, 0.7]], atol=1e-15)
    assert np.isinf(points[:2, 2]).all()
    assert nearest_distance(points) == pytest.approx(math.hypot(0.1, 0.7))
    assert nearest_side(points) == 1.0


def test_what_is_too_near_to_measure_counts_as_at_the_sensor():
    points = scan([(0.2, 0.1, 0.0), (0.2, 0.1, 0.5)], [-math.inf, math.inf])
    assert points[:2, 0].tolist() == [0.2, 0.1]
    assert np.isinf(points[:2, 1]).all()


def test_a_return_may_come_from_anywhere_on_its_arc():
    points = scan([[0.0, 0.0, 0.5]], [2.0], half_angle=0.2, samples=5)
    np.testing.assert_allclose(np.hypot(*points[:2]), 2.0)
    np.testing.assert_allclose(np.arctan2(points[1], points[0]), [0.3, 0.4, 0.5, 0.6, 0.7])


def test_another_cone_that_sees_past_it_rules_a_part_of_the_arc_out():
    points = scan([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3]], [2.0, 4.0], half_angle=0.2, samples=5)
    bearings = np.arctan2(points[1, :5], points[0, :5])
    assert np.isfinite(points[0]).tolist() == [True, True, True, False, False, True, True, True, True, True]
    np.testing.assert_allclose(bearings[:3], [-0.2, -0.1, 0.0], atol=1e-15)


def test_a_direction_with_room_is_chosen_and_none_without():
    points = box_scan(ahead=0.6, left=3.0, right=0.6, behind=1.0)
    for draw in np.linspace(0.01, 0.99, 25):
        bearing = choose_direction(points, WEIGHTS, HALF_CIRCLE, 0.37, np.zeros(3), EMPTY_TRAIL, 0, draw, 0.0)
        assert free_way(points, bearing, 0.37, 0.0) > 0.4
        assert bearing > 0.0
    shut = box_scan(ahead=0.6, left=0.6, right=0.6, behind=0.6)
    assert math.isnan(choose_direction(shut, WEIGHTS, HALF_CIRCLE, 0.37, np.zeros(3), EMPTY_TRAIL, 0, 0.5, 0.0))


def test_places_on_the_trail_count_little():
    points = box_scan(ahead=0.5, left=4.0, right=4.0, behind=1.0)
    trail = np.array([[0.0, 0.5 * i] for i in range(9)])  # all that lies to the left is known
    draws = (np.arange(400) + 0.5) / 400
    turned = [choose_direction(points, WEIGHTS, HALF_CIRCLE, 0.37, np.zeros(3), trail, 9, d, 0.0) for d in draws]
    assert np.mean(np.array(turned) < 0.0) > 0.95


def test_with_a_bar_only_what_promises_more_than_straight_ahead_is_taken():
    points = box_scan(ahead=4.0, left=4.0, right=4.0, behind=1.0)
    chosen = choose_direction(points, WEIGHTS, HALF_CIRCLE, 0.37, np.zeros(3), EMPTY_TRAIL, 0, 0.5, 2.0)
    assert math.isnan(chosen)
    trail = np.array([[0.5 * i, 0.0] for i in range(9)])
    chosen = choose_direction(points, WEIGHTS, HALF_CIRCLE, 0.37, np.zeros(3), trail, 9, 0.5, 2.0)
    assert not math.isnan(chosen)
    assert abs(chosen) > math.radians(5.0)


def test_an_opening_abeam_is_found_on_its_side():
    points = box_scan(ahead=5.0, left=1.0, right=1.0, behind=1.0)
    door = (np.abs(points[0]) < 0.55) & (points[1] > 0.9)
    points[:2, door] *= 4.0
    room, bearing = find_opening(points, HALF_CIRCLE, 0.37, 1.0)
    assert room > 2.2
    assert math.radians(70.0) < bearing <= math.radians(90.0)
    assert find_opening(points, HALF_CIRCLE, 0.37, -1.0)[0] < 1.2
