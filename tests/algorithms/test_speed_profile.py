"""Speed profiles: times as closed forms have them, and limits kept everywhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.algorithms.speed_profile import pieces_of
from tests.examples import settings

profile = am.algorithms.speed_profile


def test_a_straight_line_as_computed_by_hand():
    """2 s and 1 m to speed up, 2 s and 1 m to brake, 8 m at 1 m/s."""
    assert profile([(0, 0), (10, 0)], speed=1.0, acceleration=0.5).duration == 12.0
    many = np.column_stack([np.linspace(0, 10, 101), np.zeros(101)])
    assert profile(many, speed=1.0, acceleration=0.5).duration == pytest.approx(12.0, abs=1e-9)


def test_a_short_line_never_reaches_its_speed():
    """Half the way speeding up: t = 2 sqrt(s / a); with other braking the peak is where both meet."""
    assert profile([(0, 0), (0, 1)], speed=5.0, acceleration=1.0).duration == pytest.approx(2.0, rel=1e-12)
    peak = math.sqrt(2.0 * 2.0 * 1.0 / (1.0 + 2.0))
    times = profile([(0, 0), (0, 1)], speed=5.0, acceleration=1.0, deceleration=2.0)
    assert times.duration == pytest.approx(peak / 1.0 + peak / 2.0, rel=1e-12)


def test_a_corner_is_turned_in_place():
    times = profile([(0, 0), (10, 0), (10, 10)], speed=1.0, acceleration=0.5, turn_rate=0.5)
    assert times.duration == pytest.approx(24.0 + math.pi, rel=1e-12)
    assert times.speed[1] == 0.0
    assert times.leave[1] - times.arrive[1] == pytest.approx(math.pi, rel=1e-12)


def test_an_arc_is_no_faster_than_the_turn_allows():
    """A half circle of 2 m at 0.5 m/s, as 0.25 rad/s allow: 1 s each to speed up and brake, of 0.25 m."""
    curve = am.algorithms.dubins((0, 0, 0), (0, 4, math.pi), 2.0)
    times = profile(curve.poses(0.01), speed=3.0, acceleration=0.5, turn_rate=0.25)
    length = 2.0 * math.pi
    assert times.duration == pytest.approx(2.0 + (length - 0.5) / 0.5, rel=1e-6)
    assert times.speed.max() == pytest.approx(0.5, rel=1e-9)


def test_a_change_of_direction_is_a_stop():
    poses = [(0, 0, 0), (10, 0, 0), (0, 0, 0)]
    assert pieces_of(poses).lengths.tolist() == [10.0, -10.0]
    assert profile(poses, speed=1.0, acceleration=0.5, turn_rate=0.1).duration == 24.0


def test_the_heading_asked_for_at_the_goal_is_turned_to():
    plan = am.planners.AStar().plan(am.Map.from_array(np.zeros((20, 20)), resolution=1.0), (1.5, 1.5), (11.5, 1.5, 1.0))
    assert profile(plan.poses, speed=1.0, acceleration=0.5, turn_rate=0.5).duration == pytest.approx(12.0 + 2.0)
    assert profile([(1, 2, 3)], speed=1.0, acceleration=1.0).duration == 0.0


@settings(max_examples=100, deadline=None)
@given(
    goal=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)),
    limits=st.tuples(st.floats(0.2, 3), st.floats(0.2, 3), st.floats(0.2, 3)),
)
def test_limits_are_kept_and_reached(goal, limits):
    speed, acceleration, turn_rate = limits
    curve = am.algorithms.reeds_shepp((0, 0, 0), goal, 1.0)
    poses = curve.poses(0.02)
    pieces = pieces_of(poses)
    assert np.abs(pieces.lengths).sum() == pytest.approx(curve.length, abs=1e-6)
    times = profile(poses, speed=speed, acceleration=acceleration, turn_rate=turn_rate)
    assert times.duration >= np.abs(pieces.lengths).sum() / speed - 1e-9
    took = np.diff(times.arrive)
    assert (np.abs(pieces.turns) <= turn_rate * took + 1e-9).all()
    assert (times.speed <= speed + 1e-9).all()
    assert (np.abs(np.diff(times.speed)) <= acceleration * took + 1e-9).all()
    slower = profile(poses, speed=0.5 * speed, acceleration=acceleration, turn_rate=turn_rate)
    assert slower.duration >= times.duration - 1e-9


@pytest.mark.parametrize(
    ("path", "limits", "message"),
    [
        ([(0, 0), (1, math.nan)], {}, "the path has shape"),
        ([1, 2, 3], {}, "the path has shape"),
        ([(0, 0), (1, 0)], {"speed": 0.0}, "speed is 0"),
        ([(0, 0), (1, 0)], {"acceleration": math.inf}, "acceleration is inf"),
        ([(0, 0), (1, 0)], {"turn_rate": math.nan}, "turn_rate is nan"),
        ([(0, 0), (1, 0)], {"speed": "1.0"}, r"speed is '1\.0'; expected a finite number above 0"),
        ([(0, 0), (1, 0)], {"speed": np.complex128(1.0)}, "speed is .*; expected a finite number above 0"),
        ([(0, 0), (1, 0)], {"turn_rate": None}, "turn_rate is None; expected a number above 0"),
    ],
)
def test_what_cannot_be_meant_is_refused(path, limits, message):
    with pytest.raises(am.PlanError, match=message):
        profile(path, **({"speed": 1.0, "acceleration": 1.0} | limits))
