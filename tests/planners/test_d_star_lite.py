"""D* Lite: after each change of the map and of the start, what A* finds from scratch."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am

A_STAR = am.planners.AStar()


def world_of(taken):
    return am.Map.from_array(taken, resolution=1.0)


def check_changes(seed: int, changes: int) -> None:
    """Cells that open and close, one or a wall at a time, while the robot moves along its plan or stays."""
    random = np.random.default_rng(seed)
    shape = tuple(random.integers(2, 20, 2).tolist())
    taken = (random.random(shape) < random.choice([0.1, 0.3, 0.45])).astype(np.uint8)
    start, goal = ((random.integers(shape) + 0.5)[::-1].tolist() for _ in range(2))
    replanner = am.planners.DStarLite().replanner(goal)
    for change in range(changes):
        plan = replanner.plan(world_of(taken), start)
        fresh = A_STAR.plan(world_of(taken), start, goal)
        assert plan.status == fresh.status, (seed, change)
        assert plan.length == fresh.length, (seed, change)
        if plan.status == "found":
            # Of neighbours, as A* gives them: no corner is cut.
            assert np.abs(np.diff(plan.points, axis=0)).max(initial=0.0) <= 1.0
            if random.random() < 0.6:
                start = plan.points[min(int(random.integers(4)), len(plan.points) - 1)].tolist()
        taken = taken.copy()
        row, col = random.integers(shape).tolist()
        kind = random.integers(4)
        if kind == 0:
            taken[row, : col + 1] ^= 1
        elif kind == 1:
            taken[max(0, row - 1) : row + 2, max(0, col - 1) : col + 2] = random.integers(2)
        else:
            taken[row, col] ^= 1


@pytest.mark.parametrize("seed", range(20))
def test_equals_a_star_after_each_change(seed: int) -> None:
    check_changes(seed, 50)


@pytest.mark.parametrize(
    "seeds", [pytest.param(30, marks=pytest.mark.long), pytest.param(200, marks=pytest.mark.nightly)]
)
def test_equals_a_star_after_each_change_of_many_maps(seeds: int) -> None:
    for seed in range(seeds):
        check_changes(1000 + seed, 50)


def test_a_change_of_one_cell_costs_less_than_a_new_search() -> None:
    taken = np.zeros((60, 60), np.uint8)
    taken[10:50, 30] = 1
    start, goal = (2.5, 30.5), (57.5, 30.5)
    replanner = am.planners.DStarLite().replanner(goal)
    first = replanner.plan(world_of(taken), start)
    again = replanner.plan(world_of(taken), start)
    taken[5, 5] = 1
    changed = replanner.plan(world_of(taken), start)
    assert first.length == again.length == changed.length
    assert again.expanded == 0
    assert changed.expanded < 0.1 * first.expanded


def test_another_map_needs_another_replanner() -> None:
    replanner = am.planners.DStarLite().replanner((1.5, 1.5))
    assert replanner.plan(world_of(np.zeros((4, 5))), (3.5, 3.5)).status == "found"
    with pytest.raises(am.PlanError, match="the map has 5 x 4 cells; expected as many as in the first call, 4 x 5"):
        replanner.plan(world_of(np.zeros((5, 4))), (3.5, 3.5))


def test_a_replan_out_of_budget_goes_on_in_the_next_call() -> None:
    replanner = am.planners.DStarLite(budget=40).replanner((18.5, 18.5))
    world = world_of(np.zeros((20, 20)))
    plans = [replanner.plan(world, (1.5, 2.5)) for _ in range(20)]
    statuses = [plan.status for plan in plans]
    assert statuses[-1] == "found"
    assert plans[-1].length == A_STAR.plan(world, (1.5, 2.5), (18.5, 18.5)).length
