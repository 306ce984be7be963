"""Theta*: lines that touch free cells only, and paths no longer than those along eight directions."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.kernels.search.any_angle import is_clear_line, is_open_line
from amorsim.maps.movingai import read_problems
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "movingai"
A_STAR = am.planners.AStar()
BOTH = (am.planners.ThetaStar(), am.planners.ThetaStar(lazy=True))
IDS = ("basic", "lazy")


def touched(start, goal, shape):
    """The cells that touch the closed line between the centres of two cells, in whole numbers.

    In halves of cells, a square touches a line if its corners are not all strictly on one side of it, and the boxes
    around both overlap.
    """
    (r0, c0), (r1, c1) = ((2 * np.array(place) + 1).tolist() for place in (start, goal))
    rows, cols = np.indices(shape) * 2
    sides = [(c1 - c0) * (rows + up - r0) - (r1 - r0) * (cols + across - c0) for up in (0, 2) for across in (0, 2)]
    crossed = (np.min(sides, axis=0) <= 0) & (np.max(sides, axis=0) >= 0)
    near = (rows <= max(r0, r1)) & (rows + 2 >= min(r0, r1)) & (cols <= max(c0, c1)) & (cols + 2 >= min(c0, c1))
    return crossed & near


def check_lines(plan, taken, side=1.0):
    cells = np.floor(plan.points / side).astype(int)[:, ::-1]
    for first, last in itertools.pairwise(cells):
        assert not taken[touched(first, last, taken.shape)].any()


GRIDS = hnp.arrays(np.uint8, st.tuples(st.integers(1, 12), st.integers(1, 12)), elements=st.sampled_from([0, 0, 0, 1]))


@settings(max_examples=200, deadline=None)
@given(taken=GRIDS, data=st.data())
def test_a_line_of_sight_touches_free_cells_only(taken, data):
    free = np.argwhere(taken == 0)
    if not len(free):
        return
    flat = np.pad(taken == 0, 1).astype(np.uint8).reshape(-1)
    width = taken.shape[1] + 2
    for _ in range(5):
        start, goal = (free[data.draw(st.integers(0, len(free) - 1))] for _ in range(2))
        ends = [int((row + 1) * width + col + 1) for row, col in (start, goal)]
        sees = not taken[touched(start, goal, taken.shape)].any()
        assert is_clear_line(flat, width, *ends) == sees
        assert is_clear_line(flat, width, *ends[::-1]) == sees
        # Between centres, a line of numbers that are not whole touches what the exact one does.
        assert is_open_line(flat, width, start[1] + 0.5, start[0] + 0.5, goal[1] + 0.5, goal[0] + 0.5) == sees


@pytest.mark.parametrize("planner", BOTH, ids=IDS)
@settings(max_examples=100, deadline=None)
@given(taken=GRIDS)
def test_finds_what_a_star_finds(planner, taken):
    world = am.Map.from_array(taken, resolution=1.0)
    free = np.argwhere(taken == 0) + 0.5
    if not len(free):
        return
    for goal in free[:: max(1, len(free) // 4)]:
        octile, plan = (each.plan(world, free[0, ::-1], goal[::-1]) for each in (A_STAR, planner))
        assert plan.status == octile.status
        if plan.status == "found":
            check_lines(plan, taken)
            # A line that touches free cells only can be followed in eight directions, at most sqrt(2) times as long.
            assert octile.length <= math.sqrt(2.0) * plan.length + 1e-9
            assert plan.length >= np.hypot(*(plan.points[-1] - plan.points[0])) - 1e-9


@pytest.mark.parametrize("planner", BOTH, ids=IDS)
def test_an_empty_map_gets_a_straight_line(planner):
    world = am.Map.from_array(np.zeros((30, 40)), resolution=0.1)
    for start, goal in (((0.05, 0.05), (3.95, 2.95)), ((0.5, 0.5), (3.5, 1.0)), ((0.01, 2.97), (3.83, 0.14))):
        plan = planner.plan(world, start, goal)
        assert plan.points.tolist() == [list(start), list(goal)]
        assert plan.length == pytest.approx(math.dist(start, goal), rel=1e-12)


def check_ratio(planner, name: str, mean: float, every: int, tolerance: float) -> None:
    """Published maps: no path longer than the octile one, none that touches a wall, and the mean as known."""
    path = MAPS / f"{name}.map"
    if not path.is_file():
        pytest.skip(f"no {path}")
    world = am.load_map(path, resolution=1.0)
    taken = world.to_array()
    ratios = []
    for problem in read_problems(MAPS / f"{name}.map.scen")[::every]:
        if problem.start == problem.goal:
            continue
        ends = [(col + 0.5, row + 0.5) for row, col in (problem.start, problem.goal)]
        octile, plan = (each.plan(world, *ends) for each in (A_STAR, planner))
        check_lines(plan, taken)
        ratios.append(plan.length / octile.length)
    assert max(ratios) <= 1.0 + 1e-9
    assert min(ratios) >= 1.0 / 1.0823923 - 1e-6
    assert np.mean(ratios) == pytest.approx(mean, abs=tolerance)


# Means of basic Theta* over evenly spread rows of each file, computed apart. Ratios spread by 0.02, so the mean over n
# rows is within 4 x 0.02 / sqrt(n) of it.
@pytest.mark.parametrize(("name", "mean", "every"), [("arena", 0.95725, 4), ("maze-32-32-4", 0.96117, 5)])
def test_as_short_as_known(name: str, mean: float, every: int) -> None:
    check_ratio(BOTH[0], name, mean, every, 4.0 * 0.02 / math.sqrt(40))


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "mean"), [("arena", 0.95725), ("den000d", 0.95726), ("maze-32-32-4", 0.96117), ("16room_000", 0.95250)]
)
def test_as_short_as_known_everywhere(name: str, mean: float) -> None:
    every = 5 if name in ("16room_000", "den000d") else 1
    check_ratio(BOTH[0], name, mean, every, 4.0 * 0.02 / math.sqrt(160))
