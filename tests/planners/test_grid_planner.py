"""What all planners on cells share: statuses, clearance, cell sizes, places between centres, budgets."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.algorithms.cells import free_cells, usual_side
from amorsim.kernels.search.octile import GOING_ON
from amorsim.planners.grid_planner import GridPlanner, run_search
from amorsim.plugins.manager import make_registry
from tests.examples import settings

REGISTRY = make_registry(entry_points=[])
# That of potential fields may end in a trap; it has tests of its own.
NAMES = [
    name
    for name in REGISTRY.names("planner")
    if issubclass(REGISTRY.get("planner", name), GridPlanner) and name != "potential_field"
]
SHORT = [name for name in NAMES if name != "voronoi"]


def rooms(door: int = 4) -> am.Map:
    """Two rooms of 20 x 19 cells of 0.1 m with a door of some cells between them."""
    cells = np.zeros((20, 39), np.uint8)
    cells[:, 19] = 1
    cells[8 : 8 + door, 19] = 0
    return am.Map.from_array(cells, resolution=0.1, origin=(2.0, -1.0, 0.0))


LEFT, RIGHT = (2.55, -0.55), (5.35, 0.55)


@pytest.mark.parametrize("name", NAMES)
def test_a_door_lets_through_what_fits(name):
    planner = REGISTRY.get("planner", name)()
    # The middle of a door of four cells keeps 1 cell to either side over its whole cells.
    fits = planner.plan(rooms(), LEFT, RIGHT, footprint=am.Shape.circle(0.1))
    assert fits.status == "found"
    wide = planner.plan(rooms(), LEFT, RIGHT, footprint=am.Shape.circle(0.15))
    assert wide.status == "unreachable"
    assert "one that reaches 0.1 m would pass" in wide.message
    assert wide.expanded == len(wide.searched) > 0
    shut = planner.plan(rooms(door=0), LEFT, RIGHT, footprint=am.Shape.circle(0.15))
    assert "not even for a point" in shut.message


@pytest.mark.parametrize("name", NAMES)
def test_blocked_places_say_why(name):
    planner = REGISTRY.get("planner", name)()
    near = (2.05, -0.55)
    plan = planner.plan(rooms(), near, RIGHT, footprint=am.Shape.circle(0.15))
    assert plan.status == "start_blocked"
    assert "in a cell 0 m from an occupied one, and the footprint reaches 0.15 m" in plan.message
    plan = planner.plan(rooms(), LEFT, (3.95, -0.95))
    assert plan.status == "goal_blocked"
    assert "is in an occupied cell" in plan.message
    plan = planner.plan(rooms(), LEFT, (0.0, 0.0))
    assert plan.status == "goal_blocked"
    assert "outside the map" in plan.message
    assert planner.plan(rooms(), LEFT, RIGHT).status == "found"


@pytest.mark.parametrize("name", NAMES)
def test_a_budget_ends_the_search(name):
    cls = REGISTRY.get("planner", name)
    plan = cls(budget=0).plan(rooms(), LEFT, RIGHT)
    assert (plan.status, plan.expanded) == ("budget", 0)
    assert "budget of 0 cells" in plan.message
    whole = cls().plan(rooms(), LEFT, RIGHT)
    assert cls(budget=whole.expanded).plan(rooms(), LEFT, RIGHT).status == "found"
    plan = cls(budget=whole.expanded - 1).plan(rooms(), LEFT, RIGHT)
    assert (plan.status, plan.expanded) == ("budget", whole.expanded - 1)
    nowhere = cls().plan(rooms(door=0), LEFT, RIGHT)
    assert cls(budget=nowhere.expanded).plan(rooms(door=0), LEFT, RIGHT).status == "unreachable"


@pytest.mark.parametrize("name", NAMES)
def test_start_and_goal_are_met_wherever_they_are_in_their_cells(name):
    start, goal = (2.51, -0.57, 0.3), (2.96, 0.09, -2.0)
    plan = REGISTRY.get("planner", name)().plan(rooms(), start, goal)
    assert plan.points[0].tolist() == list(start[:2])
    assert plan.poses[-1].tolist() == list(goal)
    assert plan.length == pytest.approx(np.hypot(*np.diff(plan.points, axis=0).T).sum(), rel=1e-12)
    assert (plan.points[1:] != plan.points[:-1]).any(axis=1).all()


@pytest.mark.parametrize("name", SHORT)
def test_a_turned_map_turns_its_plans(name):
    cells = rooms().to_array()
    planner = REGISTRY.get("planner", name)()
    c, s = math.cos(0.5), math.sin(0.5)

    def turned(x, y):
        dx, dy = x - 2.0, y + 1.0
        return (7.0 + c * dx - s * dy, 3.0 + s * dx + c * dy)

    straight = planner.plan(rooms(), LEFT, RIGHT)
    plan = planner.plan(am.Map.from_array(cells, resolution=0.1, origin=(7.0, 3.0, 0.5)), turned(*LEFT), turned(*RIGHT))
    assert plan.length == pytest.approx(straight.length, rel=1e-9)
    assert plan.points == pytest.approx(np.array([turned(x, y) for x, y in straight.points]), abs=1e-9)


@pytest.mark.parametrize("name", SHORT)
def test_cells_of_another_size(name):
    cls = REGISTRY.get("planner", name)
    plan = cls(cell=0.2).plan(rooms(), (2.1, -0.9), (3.7, -0.9))
    assert plan.length == pytest.approx(1.6, abs=1e-9)
    with pytest.raises(am.PlanError, match=r"expected 50000000 at most: set the planner's cell to 0\.0004 m or more"):
        cls(cell=0.0001).plan(rooms(), LEFT, RIGHT)


@pytest.mark.parametrize(
    ("resolution", "size", "side"),
    [
        (0.1, (2000.0, 2000.0), 0.1),  # however many
        (0.03, (70.0, 50.0), 0.03),
        (0.001, (2.0, 2.0), 0.001),  # four million
        (0.001, (2.002, 2.0), 0.002),
        (0.001, (24.0, 16.0), 0.01),
        (0.001, (100.0, 100.0), 0.05),
        (0.02, (500.0, 500.0), 0.05),  # as coarse as it gets
    ],
)
def test_maps_finer_than_a_planner_needs_get_coarser_cells(resolution, size, side):
    world = am.Map.from_segments(np.empty((0, 4)), resolution=resolution, extent=(0.0, 0.0, *size))
    assert usual_side(world) == side


def test_a_plan_on_the_map_of_the_demo_needs_no_settings():
    demo = am.load("demo")
    plan = am.planners.AStar().plan(demo.map, (1.4, 8.2), (20.5, 6.0), footprint=demo.robots[0].shape)
    assert plan.status == "found"
    assert 19.2 < plan.length < 21.0  # the straight line is 19.2 m long


def test_a_search_pauses_for_the_keyboard_and_stops_at_its_budget():
    cells = am.planners.AStar().cells_of(rooms(), None)
    asked = []

    def expand(_, most):
        asked.append(most)
        return GOING_ON

    status, _ = run_search(cells, 50, 45_000, expand)
    assert (status, asked) == ("budget", [20_000, 20_000, 5_000])


@pytest.mark.parametrize("name", NAMES)
def test_what_is_no_footprint_is_refused(name):
    with pytest.raises(am.PlanError, match=r"footprint is 0\.3; expected a Shape, such as am\.Shape\.circle"):
        REGISTRY.get("planner", name)().plan(rooms(), LEFT, RIGHT, footprint=0.3)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("bad", [(math.nan, 0.0), (0.0, 0.0, math.inf), (1.0,), (1.0, 2.0, 3.0, 4.0), "here", None])
def test_what_is_no_place_is_refused(name, bad):
    planner = REGISTRY.get("planner", name)()
    with pytest.raises(am.PlanError, match=r"start is .*; expected"):
        planner.plan(rooms(), bad, RIGHT)
    with pytest.raises(am.PlanError, match=r"goal is .*; expected"):
        planner.plan(rooms(), LEFT, bad)


def test_a_field_needs_a_goal_and_a_budget():
    field = am.planners.Wavefront().field(rooms(), RIGHT)
    assert field.to_go.shape == (20, 39)
    plan = am.planners.AStar().plan(rooms(), LEFT, RIGHT)
    assert field.to_go[4, 5] == pytest.approx(plan.length, rel=1e-12)
    with pytest.raises(am.PlanError, match="not in a free cell"):
        am.planners.Wavefront().field(rooms(), (3.95, -0.95))
    with pytest.raises(am.PlanError, match="budget of 7 cells"):
        am.planners.Wavefront(budget=7).field(rooms(), RIGHT)


@settings(max_examples=60, deadline=None)
@given(
    taken=hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.sampled_from([0, 0, 0, 1])),
    reach=st.sampled_from([0.1, 0.2, 0.25, 0.3, 0.5]),
)
def test_a_free_cell_keeps_the_reach_in_every_point(taken, reach):
    """Gaps between squares, measured one by one; outside the array everything is occupied."""
    cells = free_cells(am.Map.from_array(taken, resolution=0.1), reach)
    free = cells.free.reshape(-1, cells.width)[1:-1, 1:-1]
    around = 7
    occupied = np.argwhere(np.pad(taken, around, constant_values=1)) - around
    for row, col in np.ndindex(taken.shape):
        gaps = np.maximum(np.abs(occupied - (row, col)) - 1, 0)
        nearest = int((gaps**2).sum(axis=1).min())
        # In hundredths of a square metre, so that touching is distinguished from overlapping exactly.
        keeps = nearest * 100 >= round(reach * 100) ** 2
        assert free[row, col] == (keeps and not taken[row, col])


def test_unknown_cells_are_passed_or_avoided():
    unknown = np.zeros((5, 5), np.uint8)
    unknown[:, 2] = 1
    world = am.Map.from_array(np.zeros((5, 5)), resolution=1.0, unknown=unknown)
    assert am.planners.AStar().plan(world, (0.5, 0.5), (4.5, 0.5)).status == "found"
    assert am.planners.AStar(avoid_unknown=True).plan(world, (0.5, 0.5), (4.5, 0.5)).status == "unreachable"


def test_the_cells_of_a_map_are_forgotten_with_it():
    import gc

    from amorsim.algorithms import cells

    world = rooms()
    am.planners.AStar().plan(world, LEFT, RIGHT)
    assert world in cells._cells_of
    before = len(cells._cells_of)
    del world
    gc.collect()
    assert len(cells._cells_of) == before - 1
