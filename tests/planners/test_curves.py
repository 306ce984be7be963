"""Dubins and Reeds-Shepp: lengths as known, symmetric and scaling, ends met, no wall touched."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import amorsim as am
from amorsim.algorithms.curves import all_curves, dubins, reeds_shepp
from amorsim.kernels.search.curves import dubins_words, reeds_shepp_words
from tests.examples import settings

# From (0, 0, 0) with radius 1, by OMPL 2.0.1: goal, Dubins, Reeds-Shepp.
KNOWN = [
    ((4, 4, math.pi / 2), 5.813437, 5.813437),
    ((0, 0, math.pi), 7.330383, 3.141593),
    ((4, 0, 0), 4, 4),
    ((0, 1, 0), 7.283185, 2.636232),
    ((-4, 0, 0), 10.283185, 4),
    ((1, 1, math.pi), 5.777825, 3.141593),
    ((0, 0.5, 0), 6.783185, 1.916384),
    ((2, 0, math.pi), 6.283185, 3.141593),
    ((0, 2, math.pi), 3.141593, 3.141593),
    ((-1, -1, -math.pi / 2), 6.712389, 2.617994),
    ((10, -3, 2.0), 12.139297, 11.493956),
    ((0.3, 0.2, -2.5), 6.661856, 2.5),
]
ORIGIN = (0.0, 0.0, 0.0)
POSES = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-4, 4))


@pytest.mark.parametrize(("goal", "forwards", "both"), KNOWN)
def test_lengths_as_known(goal, forwards, both):
    assert dubins(ORIGIN, goal, 1.0).length == pytest.approx(forwards, abs=6e-7)
    assert reeds_shepp(ORIGIN, goal, 1.0).length == pytest.approx(both, abs=6e-7)
    # Planners on an empty map find the same.
    world = am.Map.from_array(np.zeros((60, 60)), resolution=1.0, origin=(-30.0, -30.0, 0.0))
    for planner, length in ((am.planners.Dubins(), forwards), (am.planners.ReedsShepp(), both)):
        plan = planner.plan(world, ORIGIN, goal)
        assert plan.length == pytest.approx(length, abs=6e-7)
        assert plan.poses[-1].tolist() == list(goal)


def naive_end(start, word, radius):
    """The end of a word, a thousand short straight steps a piece, corrected by halving the step."""
    x, y, heading = start
    for bend, length in word:
        turn = bend * length
        # An arc about its centre, which is a radius to the side.
        if bend:
            centre = (x - bend * radius * math.sin(heading), y + bend * radius * math.cos(heading))
            c, s = math.cos(turn), math.sin(turn)
            dx, dy = x - centre[0], y - centre[1]
            x, y = centre[0] + c * dx - s * dy, centre[1] + s * dx + c * dy
            heading += turn
        else:
            x, y = x + length * radius * math.cos(heading), y + length * radius * math.sin(heading)
    return x, y, heading


@settings(max_examples=200, deadline=None)
@example(start=ORIGIN, goal=(0.0, 0.0, 1e-8), radius=2.0)  # three turns, of which the outer two are about one place
@example(start=ORIGIN, goal=(1e-9, -1e-8, 1e-8), radius=5.0)
@given(start=POSES, goal=POSES, radius=st.floats(0.1, 5.0))
def test_every_word_ends_at_the_goal(start, goal, radius):
    for words in (dubins_words, reeds_shepp_words):
        curves = all_curves(words, start, goal, radius)
        assert curves
        assert [curve.length for curve in curves] == sorted(curve.length for curve in curves)
        for curve in curves:
            for end in (naive_end(start, curve.word.tolist(), radius), curve.poses(0.3)[-1]):
                assert math.dist(end[:2], goal[:2]) < 1e-8
                assert abs(math.remainder(end[2] - goal[2], 2.0 * math.pi)) < 1e-8
    assert (all_curves(dubins_words, start, goal, radius)[0].word[:, 1] >= 0.0).all()


@settings(max_examples=200, deadline=None)
@example(start=(0.0, 1e-8, 0.0), goal=(1e-8, 1e-8, 0.0), factor=1.0)
@given(start=POSES, goal=POSES, factor=st.floats(0.1, 5.0))
def test_lengths_are_symmetric_and_scale(start, goal, factor):
    there = reeds_shepp(start, goal, 1.0).length
    assert there <= dubins(start, goal, 1.0).length + 1e-9
    assert reeds_shepp(goal, start, 1.0).length == pytest.approx(there, abs=1e-7)
    # Driven backwards, a curve from goal to start with both headings turned about is one from start to goal.
    turned = [(x, y, heading + math.pi) for x, y, heading in (goal, start)]
    assert dubins(*turned, 1.0).length == pytest.approx(dubins(start, goal, 1.0).length, abs=1e-7)
    larger = [(factor * x, factor * y, heading) for x, y, heading in (start, goal)]
    for shortest in (dubins, reeds_shepp):
        assert shortest(*larger, factor).length == pytest.approx(factor * shortest(start, goal, 1.0).length, rel=1e-7)


@settings(max_examples=100, deadline=None)
@given(goal=POSES)
def test_poses_turn_no_sharper_than_the_radius(goal):
    curve = reeds_shepp(ORIGIN, goal, 1.0)
    poses = curve.poses(0.05)
    chords = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    turns = np.abs(np.diff(poses[:, 2]))
    assert chords.max(initial=0.0) <= 0.05 + 1e-12
    assert (2.0 * np.sin(turns / 2.0) <= chords + 1e-12).all()


def test_what_is_no_pose_or_radius_is_refused():
    with pytest.raises(am.PlanError, match=r"goal is \(1, 2\); expected \(x, y, heading\)"):
        dubins(ORIGIN, (1, 2), 1.0)
    wrong = "1.0"
    with pytest.raises(am.PlanError, match=r"radius is '1\.0'; expected a positive number of metres"):
        dubins(ORIGIN, ORIGIN, wrong)
    with pytest.raises(am.PlanError, match="radius is 0"):
        reeds_shepp(ORIGIN, ORIGIN, 0.0)
    with pytest.raises(am.PlanError, match="spacing is 0"):
        dubins(ORIGIN, (1, 2, 3), 1.0).poses(0.0)


def wall_ahead() -> am.Map:
    """10 m x 10 m, with a wall between start (2, 5) and goal (8, 5)."""
    cells = np.zeros((100, 100))
    cells[45:55, 50] = 1
    return am.Map.from_array(cells, resolution=0.1)


def test_a_longer_curve_is_taken_where_the_shortest_meets_a_wall():
    ends = (2.0, 5.0, 0.0), (8.0, 5.0, 0.0)
    plan = am.planners.Dubins(radius=1.5).plan(wall_ahead(), *ends, footprint=am.Shape.rectangle(0.6, 0.4))
    assert plan.status == "found"
    assert plan.expanded > 1
    assert plan.length > 6.5
    assert len(plan.links) > 0  # the curves that met the wall
    gaps = am.planners.Dubins().query(wall_ahead(), *ends, am.Shape.rectangle(0.6, 0.4))[0].gaps(plan.poses)
    assert gaps.min() >= 0.01


def test_no_free_curve_is_reported_and_a_budget_ends_the_tries():
    ends = (2.0, 5.0, 0.0), (8.0, 5.0, 0.0)
    plan = am.planners.Dubins(radius=0.1).plan(wall_ahead(), *ends, footprint=am.Shape.circle(0.3))
    assert plan.status == "unreachable"
    assert "Dubins curves of radius 0.1 m keeps the footprint 0.02 m from the walls" in plan.message
    plan = am.planners.ReedsShepp(budget=1).plan(wall_ahead(), *ends, footprint=am.Shape.circle(0.3))
    assert (plan.status, plan.expanded) == ("budget", 1)
    assert "the budget of 1 curves was used up" in plan.message


def test_a_footprint_that_fits_only_in_its_heading_is_free():
    """A slot 1 m wide, for a car 2 m long: along it there is room, across it there is none."""
    cells = np.ones((20, 60))
    cells[5:15] = 0
    world = am.Map.from_array(cells, resolution=0.1)
    car = am.Shape.rectangle(2.0, 0.8)
    planner = am.planners.ReedsShepp(radius=2.0)
    assert planner.plan(world, (1.5, 1.0, 0.0), (4.5, 1.0, 0.0), footprint=car).status == "found"
    plan = planner.plan(world, (1.5, 1.0, 0.0), (4.5, 1.0, 1.57), footprint=car)
    assert plan.status == "goal_blocked"
    assert "90 degrees) the footprint overlaps a wall" in plan.message
    assert planner.plan(world, (1.5, 1.0), (4.5, 1.0), footprint=car).status == "found"  # along the line between them
    plan = planner.plan(world, (1.5, 1.09, 0.0), (4.5, 1.0, 0.0), footprint=car)
    assert plan.status == "start_blocked"
    assert "the footprint is 0.01 m from a wall; expected the clearance of 0.02 m" in plan.message
