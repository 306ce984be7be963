"""RRT, RRT-Connect, RRT* and PRM: free lines, equal plans for equal seeds, and paths that get shorter."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from tests.examples import settings

ALL = (am.planners.Rrt, am.planners.RrtConnect, am.planners.RrtStar, am.planners.Prm)
GRIDS = hnp.arrays(np.uint8, st.tuples(st.integers(1, 10), st.integers(1, 10)), elements=st.sampled_from([0, 0, 0, 1]))


def touches(taken, first, last) -> bool:
    """Whether a line touches an occupied cell, by shapely; cells have a side of 1."""
    import shapely

    line = shapely.LineString([first, last])
    rows, cols = np.nonzero(taken)
    return bool(shapely.intersects(shapely.box(cols, rows, cols + 1, rows + 1), line).any())


@pytest.mark.parametrize("planner", ALL)
@settings(max_examples=40, deadline=None)
@given(taken=GRIDS, seed=st.integers(0, 2**40), data=st.data())
def test_paths_are_free_lines_between_the_ends(planner, taken, seed, data):
    free = np.argwhere(taken == 0)
    if not len(free):
        return
    world = am.Map.from_array(taken, resolution=1.0)
    start, goal = (
        free[data.draw(st.integers(0, len(free) - 1))][::-1] + data.draw(st.sampled_from([0.5, 0.25, 0.9]))
        for _ in range(2)
    )
    plan = planner(seed=seed, budget=2000).plan(world, start, goal)
    octile = am.planners.AStar().plan(world, start, goal)
    assert (plan.status == "unreachable") == (octile.status == "unreachable")
    if plan.status != "found":
        assert plan.status in ("unreachable", "budget")
        return
    assert plan.points[[0, -1]].tolist() == [start.tolist(), goal.tolist()]
    for first, last in itertools.pairwise(plan.points):
        assert not touches(taken, first, last)
    for x0, y0, x1, y1 in plan.links[:50]:
        assert not touches(taken, (x0, y0), (x1, y1))
    assert plan.length >= math.dist(start, goal) - 1e-9


def office() -> am.Map:
    return am.worlds.office(0)


ENDS = (2.0, 2.0), (20.0, 10.0)


@pytest.mark.parametrize("planner", ALL)
def test_a_seed_gives_its_plan_and_another_another(planner):
    plans = [planner(seed=seed).plan(office(), *ENDS, footprint=am.Shape.circle(0.2)) for seed in (1, 1, 2)]
    assert plans[0].status == "found"
    assert plans[0].poses.tobytes() == plans[1].poses.tobytes()
    assert plans[0].links.tobytes() == plans[1].links.tobytes()
    assert plans[0].poses.tobytes() != plans[2].poses.tobytes()
    short = planner(seed=1, shorten=True).plan(office(), *ENDS, footprint=am.Shape.circle(0.2))
    assert short.length <= plans[0].length + 1e-9
    assert len(short.poses) <= len(plans[0].poses)


@pytest.mark.parametrize("planner", ALL)
def test_no_path_is_proved_and_a_budget_is_reported(planner):
    cells = np.zeros((40, 60))
    cells[:, 30] = 1
    shut = am.Map.from_array(cells, resolution=0.1)
    plan = planner().plan(shut, (1.0, 1.0), (5.0, 3.0), footprint=am.Shape.circle(0.2))
    assert (plan.status, plan.expanded) == ("unreachable", 0)
    assert "not even for a point" in plan.message
    cells[15:19, 30] = 0
    door = am.Map.from_array(cells, resolution=0.1)
    plan = planner().plan(door, (1.0, 1.0), (5.0, 3.0), footprint=am.Shape.circle(0.3))
    assert "one that reaches 0.1 m would pass" in plan.message
    plan = planner(budget=0).plan(door, (1.0, 1.0), (5.0, 3.0))
    assert plan.status == "budget"
    assert "the budget of 0 samples was used up; free cells do lead from start to goal" in plan.message


@pytest.mark.parametrize("informed", [False, True])
def test_the_best_path_of_rrt_star_never_gets_longer(informed):
    lengths = []
    for budget in (400, 800, 1200, 1600, 2400, 3200):
        plan = am.planners.RrtStar(budget=budget, seed=3, informed=informed).plan(disc_world(), *DISC_ENDS)
        lengths.append(plan.length)
    assert math.isfinite(lengths[-1])
    assert (np.diff([length for length in lengths if math.isfinite(length)]) <= 1e-12).all()
    assert lengths[-1] < lengths[1]


@functools.cache
def disc_world() -> am.Map:
    """A disc of 1 m in the middle of 6 m x 6 m; start and goal lie 2 m to either side of its middle."""
    rows, cols = np.indices((300, 300))
    near = np.hypot(np.maximum(np.abs(rows + 0.5 - 150) - 0.5, 0), np.maximum(np.abs(cols + 0.5 - 150) - 0.5, 0))
    return am.Map.from_array(near * 0.02 < 1.0, resolution=0.02)


DISC_ENDS = (1.0, 3.0), (5.0, 3.0)
# Two tangents of sqrt(2^2 - 1), and the arc between them: pi less twice the angle whose cosine is 1 / 2.
SHORTEST = 2.0 * math.sqrt(3.0) + (math.pi - 2.0 * math.acos(0.5))


def check_disc(seeds) -> int:
    near = 0
    for seed in seeds:
        plan = am.planners.RrtStar(budget=10_000, seed=seed).plan(disc_world(), *DISC_ENDS)
        assert plan.length >= SHORTEST - 1e-9  # every cell that the disc touches is occupied
        near += plan.length <= 1.02 * SHORTEST
    return near


def test_rrt_star_comes_near_the_shortest_path_around_a_disc():
    assert check_disc((0, 1)) == 2


@pytest.mark.long
def test_rrt_star_comes_near_the_shortest_path_around_a_disc_for_most_seeds():
    assert check_disc(range(20)) >= 18


def test_a_roadmap_with_more_samples_has_shorter_paths():
    lengths = [
        am.planners.Prm(samples=samples, budget=5000).plan(disc_world(), *DISC_ENDS).length for samples in (50, 3000)
    ]
    assert SHORTEST <= lengths[1] < lengths[0]
    assert lengths[1] < 1.05 * SHORTEST
