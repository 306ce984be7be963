"""Potential field: downhill to the goal where nothing is in the way, and traps that are reported and shown."""

from __future__ import annotations

import numpy as np
import pytest

import amorsim as am

FIELD = am.planners.PotentialField()


def hall(wall=None) -> am.Map:
    cells = np.zeros((40, 60))
    if wall is not None:
        cells[wall] = 1
    return am.Map.from_array(cells, resolution=0.1)


START, GOAL = (1.05, 2.05), (5.05, 2.05)


def test_nothing_in_the_way_is_a_straight_path():
    plan = FIELD.plan(hall(), START, GOAL, footprint=am.Shape.circle(0.2))
    assert plan.status == "found"
    assert plan.length == pytest.approx(4.0, abs=1e-9)


def test_a_wall_across_the_way_is_a_trap_that_is_reported_and_shown():
    world = hall((slice(12, 29), 30))
    plan = FIELD.plan(world, START, GOAL, footprint=am.Shape.circle(0.2))
    assert plan.status == "unreachable"
    assert "it rests in a trap of the potential at (2." in plan.message
    assert "there is a path" in plan.message
    potential = FIELD.potential(world, GOAL, footprint=am.Shape.circle(0.2))
    # It rests in one of the traps, and the way there goes downhill.
    assert plan.searched[-1].tolist() in potential.traps.tolist()
    heights = [potential.values[int(y / 0.1), int(x / 0.1)] for x, y in plan.searched]
    assert (np.diff(heights) < 0.0).all()


def test_no_path_at_all_is_reported_as_by_others():
    plan = FIELD.plan(hall((slice(None), 30)), START, GOAL)
    assert plan.status == "unreachable"
    assert "no free cells lead from start to goal" in plan.message


def test_traps_are_cells_with_no_lower_neighbour():
    """Measured cell by cell; the goal is none."""
    world = am.worlds.maze(3, size=(4.0, 4.0))
    start = np.argwhere(world.to_array() == 0)[50][::-1] * world.resolution + 0.5 * world.resolution
    potential = FIELD.potential(world, start)
    values = np.pad(potential.values, 1, constant_values=np.inf)
    free = np.isfinite(values)
    traps = []
    for row, col in np.argwhere(free):
        around = [
            values[row + up, col + across]
            for up in (-1, 0, 1)
            for across in (-1, 0, 1)
            if (up or across) and free[row + up, col] and free[row, col + across]
        ]
        place = ((col - 0.5) * world.resolution, (row - 0.5) * world.resolution)
        if min(around, default=np.inf) >= values[row, col] and not np.allclose(place, start):
            traps.append(place)
    assert sorted(traps) == pytest.approx(np.array(sorted(potential.traps.tolist())))
    assert traps


def test_a_budget_ends_the_descent():
    plan = am.planners.PotentialField(budget=10).plan(hall(), START, GOAL)
    assert (plan.status, plan.expanded) == ("budget", 10)
    with pytest.raises(am.PlanError, match="not in a free cell"):
        FIELD.potential(hall((20, 50)), GOAL)
