"""Voronoi: the widest narrowest place, and the middle between walls."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from tests.examples import settings

VORONOI = am.planners.Voronoi()


def naive_gaps(taken):
    """Squared gaps between squares, measured one by one; outside everything is occupied."""
    occupied = np.argwhere(np.pad(taken, 1, constant_values=1)) - 1
    gaps = np.full(taken.shape, -1)
    for row, col in np.argwhere(taken == 0):
        apart = np.maximum(np.abs(occupied - (row, col)) - 1, 0)
        gaps[row, col] = (apart**2).sum(axis=1).min()
    return gaps


@settings(max_examples=60, deadline=None)
@given(
    taken=hnp.arrays(
        np.uint8, st.tuples(st.integers(2, 12), st.integers(2, 12)), elements=st.sampled_from([0, 0, 0, 1])
    )
)
def test_no_path_has_a_wider_narrowest_place(taken):
    free = np.argwhere(taken == 0)
    if len(free) < 2:
        return
    gaps = naive_gaps(taken)
    start, goal = free[0], free[-1]
    world = am.Map.from_array(taken, resolution=1.0)
    plan = VORONOI.plan(world, start[::-1] + 0.5, goal[::-1] + 0.5)
    a_star = am.planners.AStar().plan(world, start[::-1] + 0.5, goal[::-1] + 0.5)
    assert plan.status == a_star.status
    if plan.status != "found":
        return
    cells = np.floor(plan.points).astype(int)[:, ::-1]
    narrowest = gaps[cells[:, 0], cells[:, 1]].min()
    # With all cells occupied that are no wider than that, there is no path any more.
    closed = am.Map.from_array(gaps <= narrowest, resolution=1.0)
    assert am.planners.AStar().plan(closed, start[::-1] + 0.5, goal[::-1] + 0.5).status != "found"
    assert plan.length >= a_star.length - 1e-9


def test_the_path_runs_in_the_middle_of_a_corridor_and_through_the_wider_door():
    cells = np.zeros((41, 100))
    cells[:, 50] = 1
    cells[3:9, 50] = 0  # near the straight line, 6 cells wide
    cells[25:37, 50] = 0  # 12 cells wide
    world = am.Map.from_array(cells, resolution=0.1)
    start, goal = (1.05, 0.85), (8.95, 0.85)
    plan = VORONOI.plan(world, start, goal)
    crossing = plan.points[np.argmin(np.abs(plan.points[:, 0] - 5.05)), 1]
    assert 2.5 < crossing < 3.7
    straight = am.planners.AStar().plan(world, start, goal)
    assert 0.3 < straight.points[np.argmin(np.abs(straight.points[:, 0] - 5.05)), 1] < 0.9
    corridor = am.Map.from_array(np.zeros((21, 200)), resolution=0.1)
    plan = VORONOI.plan(corridor, (0.55, 0.55), (19.45, 1.45))
    middle = plan.points[(plan.points[:, 0] > 3.0) & (plan.points[:, 0] < 17.0)]
    assert len(middle) > 100
    assert np.abs(middle[:, 1] - 1.05).max() < 1e-9


def test_steps_cut_no_corner():
    world = am.worlds.cave(2)
    plan = VORONOI.plan(world, *_free_ends(world), footprint=am.Shape.circle(0.15))
    assert plan.status == "found"
    taken = world.to_array()
    cells = np.floor(plan.points / world.resolution).astype(int)[:, ::-1]
    for (row, col), (up, across) in zip(cells[:-1], np.diff(cells, axis=0), strict=True):
        assert max(abs(up), abs(across)) <= 1
        assert not taken[[row + up, row], [col, col + across]].any()


def _free_ends(world):
    from amorsim.core.maps.free_places import roomy_places

    places = roomy_places(world, 400)
    return next(pair for pair in itertools.combinations(places, 2) if _are_far(*pair))


def _are_far(one, other) -> bool:
    return abs(one[0] - other[0]) + abs(one[1] - other[1]) > 4.0


@pytest.mark.parametrize("planner", [am.planners.Voronoi(), am.planners.PotentialField()])
def test_prices_and_potentials_do_not_depend_on_other_maps(planner):
    world = am.Map.from_array(np.zeros((30, 30)), resolution=0.1)
    first = planner.plan(world, (0.55, 0.55), (2.45, 2.45))
    planner.plan(am.Map.from_array(np.zeros((10, 50)), resolution=0.1), (0.55, 0.55), (4.45, 0.45))
    assert planner.plan(world, (0.55, 0.55), (2.45, 2.45)).poses.tobytes() == first.poses.tobytes()
