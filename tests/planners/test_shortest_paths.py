"""Planners of shortest paths: lengths as published, as a naive search has them, and as each other's."""

from __future__ import annotations

import heapq
import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import amorsim as am
from amorsim.maps.movingai import Problem, read_problems
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "movingai"
NAMES = ("16room_000", "arena", "den000d", "maze-32-32-4")
PLANNERS = ("a_star", "dijkstra", "wavefront", "jump_point", "d_star_lite")


def planner(name):
    from amorsim.plugins.manager import make_registry

    return make_registry(entry_points=[]).get("planner", name)()


SHORTEST = {name: planner(name) for name in PLANNERS}


def middle(cell, side=1.0):
    return ((cell[1] + 0.5) * side, (cell[0] + 0.5) * side)


def last_digit(row: str) -> float:
    """One unit of the last digit of a printed number."""
    digits = row.strip().partition(".")[2]
    return 10.0 ** -len(digits)


def check_problems(name: str, every: int) -> None:
    path = MAPS / f"{name}.map"
    if not path.is_file():
        pytest.skip(f"no {path}")
    side = 0.5
    world = am.load_map(path, resolution=side)
    printed = [line.split()[-1] for line in (MAPS / f"{name}.map.scen").read_text().splitlines()[1:] if line.strip()]
    problems: tuple[Problem, ...] = read_problems(MAPS / f"{name}.map.scen")
    assert len(printed) == len(problems)
    for problem, digits in list(zip(problems, printed, strict=True))[::every]:
        lengths = []
        for each in SHORTEST.values():
            plan = each.plan(world, middle(problem.start, side), middle(problem.goal, side))
            assert plan.status == "found"
            lengths.append(plan.length / side)
        assert abs(lengths[0] - problem.optimal) <= 0.5 * last_digit(digits) + 1e-5
        assert max(lengths) - min(lengths) <= 1e-9


@pytest.mark.parametrize(("name", "every"), [("16room_000", 300), ("arena", 8), ("den000d", 120), ("maze-32-32-4", 5)])
def test_published_lengths(name: str, every: int) -> None:
    check_problems(name, every)


@pytest.mark.nightly
@pytest.mark.parametrize("name", NAMES)
def test_all_published_lengths(name: str) -> None:
    check_problems(name, 1)


def naive(free, start, goal):
    """The length of the shortest path, by a search that can be read at a glance; inf without one."""
    best = {start: 0.0}
    queue = [(0.0, start)]
    while queue:
        cost, (row, col) = heapq.heappop(queue)
        if (row, col) == goal:
            return cost
        for up in (-1, 0, 1):
            for across in (-1, 0, 1):
                to = (row + up, col + across)
                if not (0 <= to[0] < free.shape[0] and 0 <= to[1] < free.shape[1] and free[to]):
                    continue
                if not (free[row + up, col] and free[row, col + across]):
                    continue
                longer = cost + math.hypot(up, across)
                if longer < best.get(to, math.inf):
                    best[to] = longer
                    heapq.heappush(queue, (longer, to))
    return math.inf


def check_steps(plan, world):
    """A path of straight and diagonal lines whose steps cut no corner."""
    corners = np.floor(plan.points).astype(int)[:, ::-1]
    cells = [corners[:1]]
    for first, last in itertools.pairwise(corners):
        count = np.abs(last - first).max()
        step, rest = np.divmod(last - first, count)
        assert not rest.any()
        cells.append(first + step * np.arange(1, count + 1)[:, None])
    cells = np.concatenate(cells)
    taken = world.to_array()
    for (row, col), (up, across) in zip(cells[:-1], np.diff(cells, axis=0), strict=True):
        assert max(abs(up), abs(across)) == 1
        assert not taken[[row + up, row, row + up], [col, col + across, col + across]].any()


@pytest.mark.parametrize("name", PLANNERS)
@settings(max_examples=150, deadline=None)
@given(taken=hnp.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9)), elements=st.integers(0, 1)))
def test_equals_a_naive_search(name, taken):
    world = am.Map.from_array(taken, resolution=1.0)
    free = np.argwhere(taken == 0)
    if not len(free):
        return
    for goal in free[:: max(1, len(free) // 4)]:
        start = free[0]
        plan = SHORTEST[name].plan(world, middle(start), middle(goal))
        length = naive(taken == 0, tuple(start.tolist()), tuple(goal.tolist()))
        assert plan.status == ("unreachable" if math.isinf(length) else "found")
        assert plan.length == pytest.approx(length, abs=1e-9)
        if plan.status == "found":
            check_steps(plan, world)


def test_a_star_expands_less_than_dijkstra():
    world = am.Map.from_array(np.zeros((50, 50)), resolution=1.0)
    plans = {name: SHORTEST[name].plan(world, (5.5, 25.5), (30.5, 25.5)) for name in PLANNERS}
    assert plans["a_star"].expanded == 26
    assert plans["jump_point"].expanded == 2
    assert plans["dijkstra"].expanded > 500
    assert plans["wavefront"].expanded == 2500


@settings(max_examples=60, deadline=None)
@given(taken=hnp.arrays(np.uint8, st.tuples(st.integers(2, 9), st.integers(2, 9)), elements=st.sampled_from([0, 0, 1])))
def test_a_field_keeps_bellmans_equation_in_every_cell(taken):
    goals = np.argwhere(taken == 0)
    if not len(goals):
        return
    goal = goals[len(goals) // 2]
    field = am.planners.Wavefront().field(am.Map.from_array(taken, resolution=1.0), middle(goal))
    assert field.to_go[tuple(goal)] == 0.0
    free = np.pad(taken == 0, 1)
    to_go = np.pad(field.to_go, 1, constant_values=math.inf)
    for row, col in np.argwhere(free):
        around = [
            to_go[row + up, col + across] + (math.sqrt(2.0) if up and across else 1.0)
            for up in (-1, 0, 1)
            for across in (-1, 0, 1)
            if (up or across) and free[row + up, col] and free[row, col + across] and free[row + up, col + across]
        ]
        if (row - 1, col - 1) != tuple(goal):
            assert to_go[row, col] == min(around, default=math.inf)
