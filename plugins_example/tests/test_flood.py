"""Breadth-first search takes the fewest steps, in a rotated map too, and keeps to its budget."""

import math

import amorsim_example as example
import numpy as np
import pytest

import amorsim as am


def hall(origin: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> am.Map:
    cells = np.zeros((20, 30), dtype=np.uint8)
    cells[:15, 15] = 1
    return am.Map.from_array(cells, resolution=0.1, origin=origin)


def test_the_path_has_the_fewest_steps() -> None:
    plan = example.Flood().plan(hall(), (0.55, 0.55), (2.45, 0.55, 1.0))
    # 19 columns to the right, and 10 rows up to the gap and down again.
    assert plan.length == pytest.approx(0.1 * (19 + 2 * 10))
    assert plan.poses[-1].tolist() == [2.45, 0.55, 1.0]


def test_a_map_may_be_turned() -> None:
    origin = (2.0, -1.0, math.radians(30.0))
    start, goal = (am.compose(np.array([origin]), np.array([[x, 0.55, 0.0]]))[0] for x in (0.55, 2.45))
    plan = example.Flood().plan(hall(origin), start.tolist(), goal.tolist())
    assert plan.status == "found"
    assert plan.length == pytest.approx(0.1 * (19 + 2 * 10))
    assert not hall(origin).occupied(plan.points).any()


def test_a_budget_that_is_used_up_is_said() -> None:
    plan = example.Flood(budget=50).plan(hall(), (0.55, 0.55), (2.45, 0.55))
    assert (plan.status, plan.expanded, len(plan.searched)) == ("budget", 50, 50)
