"""What every planner keeps: a budget of nothing, Ctrl-C, the same plan for the same question, maps that change."""

from __future__ import annotations

import contextlib
import signal
import sys
import time

import numpy as np
import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry

REGISTRY = make_registry(entry_points=[])
NAMES = REGISTRY.names("planner")

START, GOAL = (1.05, 1.05, 0.0), (5.05, 3.05, 1.0)


def hall() -> am.Map:
    """Two rooms, 6 m x 4 m, with a door 1 m wide between them."""
    cells = np.zeros((40, 60), np.uint8)
    cells[:, 30] = 1
    cells[15:25, 30] = 0
    return am.Map.from_array(cells, resolution=0.1)


@pytest.mark.parametrize("name", NAMES)
def test_a_budget_of_nothing_is_used_up_at_once(name):
    plan = REGISTRY.get("planner", name)(budget=0).plan(hall(), START, GOAL)
    assert (plan.status, plan.expanded, len(plan.poses)) == ("budget", 0, 0)
    assert "the budget of 0" in plan.message


@pytest.mark.parametrize("name", NAMES)
def test_a_planner_keeps_nothing_of_the_last_map(name):
    """A map that changed is another map: what was found on the first does not matter, and the first stays as it was."""
    planner = REGISTRY.get("planner", name)()
    disc = am.Shape.circle(0.2)
    first = planner.plan(hall(), START, GOAL, footprint=disc)
    cells = hall().to_array()
    cells[15:25, 30] = 1
    shut = am.Map.from_array(cells, resolution=0.1)
    assert planner.plan(shut, START, GOAL, footprint=disc).status == "unreachable"
    again = planner.plan(hall(), START, GOAL, footprint=disc)
    assert again.poses.tobytes() == first.poses.tobytes()
    assert again.links.tobytes() == first.links.tobytes()


@pytest.mark.parametrize("name", NAMES)
def test_an_array_that_is_written_to_does_not_change_the_map_planned_on(name):
    cells = np.zeros((40, 60), np.uint8)
    world = am.Map.from_array(cells, resolution=0.1)
    cells[:, 30] = 1
    assert REGISTRY.get("planner", name)().plan(world, START, GOAL).status == "found"


# What takes long enough to be interrupted: a hall of a million cells whose goal is walled in from sight, or samples
# without end.
LONG = {
    "dijkstra": {},
    "wavefront": {},
    "d_star_lite": {},
    "theta_star": {},
    "voronoi": {},
    "rrt_star": {"budget": 1_000_000},
    "hybrid_a_star": {"budget": 1_000_000, "radius": 8.0},
}


@pytest.mark.skipif(sys.platform == "win32", reason="there is no timer of signals")
@pytest.mark.parametrize("name", LONG)
def test_ctrl_c_is_noticed(name):
    cls = REGISTRY.get("planner", name)
    cls().plan(hall(), START, GOAL)  # whatever has to be compiled is compiled
    planner = cls(**LONG[name])
    cells = np.zeros((1000, 1000), np.uint8)
    cells[100:900, 500] = 1
    world = am.Map.from_array(cells, resolution=0.1)
    with contextlib.suppress(am.PlanError):
        planner.plan(world, (2.0, 2.0), (2.0, -1.0))  # whatever is kept of the map is kept
    previous = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
        began = time.monotonic()
        signal.setitimer(signal.ITIMER_REAL, 0.02)
        with pytest.raises(KeyboardInterrupt):
            planner.plan(world, (5.0, 50.0, 0.0), (95.0, 50.0, 0.5))
        assert time.monotonic() - began < 2.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGINT, previous)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
