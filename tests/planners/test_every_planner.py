"""What every planner keeps: a budget of nothing, Ctrl-C, the same plan for the same question, maps that change."""

from __future__ import annotations

import contextlib
import re
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
def test_places_outside_the_map_are_blocked_and_it_is_said(name):
    planner = REGISTRY.get("planner", name)()
    for outside in ((9.0, 1.0, 0.0), (1.0, -0.5), (1e300, 1.0, 0.0)):
        x, y = outside[:2]
        plan = planner.plan(hall(), START, outside)
        assert (plan.status, plan.message) == ("goal_blocked", f"the goal ({x:g}, {y:g}) is outside the map")
        plan = planner.plan(hall(), outside, GOAL)
        assert (plan.status, plan.message) == ("start_blocked", f"the start ({x:g}, {y:g}) is outside the map")


@pytest.mark.parametrize("name", NAMES)
def test_places_in_walls_are_blocked(name):
    planner = REGISTRY.get("planner", name)()
    wall = (3.05, 0.55, 0.0)
    assert planner.plan(hall(), START, wall).status == "goal_blocked"
    assert planner.plan(hall(), wall, GOAL).status == "start_blocked"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("given", [(np.nan, 1.0), (np.inf, 1.0), (1.0, 1.0, np.nan), (1.0,), (1, 2, 3, 4), "ab", None])
def test_places_that_are_no_numbers_are_errors(name, given):
    planner = REGISTRY.get("planner", name)()
    with pytest.raises(am.PlanError, match=r"goal is .*; expected \(x, y\) or \(x, y, heading\), finite numbers"):
        planner.plan(hall(), START, given)
    with pytest.raises(am.PlanError, match=r"start is .*; expected \(x, y\) or \(x, y, heading\), finite numbers"):
        planner.plan(hall(), given, GOAL)


@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_map_or_no_footprint_is_an_error(name):
    planner = REGISTRY.get("planner", name)()
    with pytest.raises(am.PlanError, match="world is a ndarray; expected a Map"):
        planner.plan(hall().to_array(), START, GOAL)
    with pytest.raises(am.PlanError, match=r"footprint is 0\.25; expected a Shape"):
        planner.plan(hall(), START, GOAL, footprint=0.25)


@pytest.mark.parametrize("name", NAMES)
def test_of_a_footprint_wider_than_the_door_it_is_said_which_one_would_pass(name):
    """The door is 1 m wide; a cell keeps 0.4 m and more from both sides."""
    cls = REGISTRY.get("planner", name)
    planner = cls(radius=0.5, cell=0.3, headings=16) if name == "hybrid_a_star" else cls()
    plan = planner.plan(hall(), START, (5.05, 2.05, 0.0), footprint=am.Shape.circle(0.55))
    assert plan.status == "unreachable"
    # For planners with headings it is of the largest disc within the footprint's outline, which has corners.
    assert re.search(r"for a footprint that reaches 0\.5(5|49) m; one that reaches 0\.4 m would pass$", plan.message)


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
    "a_star": {},
    "dijkstra": {},
    "wavefront": {},
    "d_star_lite": {},
    "theta_star": {},
    "voronoi": {},
    "potential_field": {},
    "jump_point": {},
    "prm": {"samples": 300_000, "budget": 1_000_000},
    "rrt": {"budget": 1_000_000, "step": 0.02},
    "rrt_connect": {"budget": 1_000_000, "step": 0.02},
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
    if name == "jump_point":  # in an open hall it is done at once
        cells[::3, ::3] = 1
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
