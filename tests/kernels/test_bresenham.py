"""Bresenham's line against a textbook's, and ranges along it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.kernels.raycast.bresenham import bresenham_cells
from tests import building
from tests.examples import settings

CELL = st.integers(-60, 60)


def textbook(x0: int, y0: int, x1: int, y1: int) -> list[tuple[int, int]]:
    """The line as textbooks have it: one octant with a decision variable, the others by mirroring it."""
    dx, dy = abs(x1 - x0), abs(y1 - y0)
    if dy > dx:
        return [(x, y) for y, x in textbook(y0, x0, y1, x1)]
    sx, sy = (1 if x1 >= x0 else -1), (1 if y1 >= y0 else -1)
    cells, y, decision = [], y0, 2 * dy - dx
    for i in range(dx + 1):
        cells.append((x0 + sx * i, y))
        if decision > 0:
            y += sy
            decision -= 2 * dx
        decision += 2 * dy
    return cells


def cells(x0: int, y0: int, x1: int, y1: int) -> list[tuple[int, int]]:
    out = np.empty((max(abs(x1 - x0), abs(y1 - y0)) + 1, 2), dtype=np.int64)
    bresenham_cells(x0, y0, x1, y1, out)
    return [(int(x), int(y)) for x, y in out]


@settings(deadline=None)  # the first call may compile
@given(CELL, CELL, CELL, CELL)
def test_the_cells_are_a_textbooks(x0: int, y0: int, x1: int, y1: int) -> None:
    ours, theirs = cells(x0, y0, x1, y1), textbook(x0, y0, x1, y1)
    assert len(ours) == len(theirs)
    assert (ours[0], ours[-1]) == ((x0, y0), (x1, y1))
    length = max(abs(x1 - x0), abs(y1 - y0))
    for i, (mine, other) in enumerate(zip(ours, theirs, strict=True)):
        # Where the line passes just between two cells (a tie), textbooks differ in which they take; nowhere else.
        if mine != other:
            exact_x, exact_y = x0 + (x1 - x0) * i / length, y0 + (y1 - y0) * i / length
            off = max(abs(mine[0] - exact_x), abs(mine[1] - exact_y))
            assert off == pytest.approx(0.5)
            assert max(abs(mine[0] - other[0]), abs(mine[1] - other[1])) == 1


def laser(traversal: str, heading: float, x: float = 2.003, y: float = 2.504) -> float:
    device = am.sensors.Laser(beams=1, fov=0.1, range_max=20.0, traversal=traversal)
    robot = building.robot(sensors={"laser": device}, estimators={}, pose=am.Pose(x=x, y=y, heading=heading))
    sim = am.Simulation(building.scenario(robot, map=building.room(resolution=0.01)))
    return float(sim.robot("rover").readings["laser"].true[0])


@pytest.mark.parametrize("heading", [0.0, 0.3, math.pi / 2, -2.5, math.pi])
def test_the_papers_way_reads_within_a_cell_or_two_of_the_exact_way(heading: float) -> None:
    assert laser("bresenham", heading) == pytest.approx(laser("exact", heading), abs=0.03)
    assert laser("bresenham", heading) != laser("exact", heading)


def test_along_an_axis_it_counts_cells() -> None:
    # From cell 200 to the wall's first cell, 599: 399 cells of 1 cm.
    assert laser("bresenham", 0.0) == pytest.approx(3.99, abs=1e-12)


def test_beyond_its_range_it_reads_nothing() -> None:
    device = am.sensors.Laser(beams=1, fov=0.1, range_max=3.0, traversal="bresenham")
    robot = building.robot(sensors={"laser": device}, estimators={}, pose=am.Pose(x=2.0, y=2.5))
    sim = am.Simulation(building.scenario(robot))
    assert sim.robot("rover").readings["laser"].true[0] == math.inf


def test_a_sonar_has_it_too_and_bodies_are_seen() -> None:
    sonar = am.sensors.Sonar(elements=(am.Mount(),), half_angle=0.2, range_max=5.0, traversal="bresenham")
    robot = building.robot(sensors={"sonar": sonar}, estimators={}, pose=am.Pose(x=2.0, y=2.5))
    post = am.Obstacle(name="post", shape=am.Shape.circle(0.1), pose=am.Pose(x=4.0, y=2.5))
    alone = am.Simulation(building.scenario(robot))
    assert alone.robot("rover").readings["sonar"].true[0] == pytest.approx(3.999, abs=0.005)
    both = am.Simulation(building.scenario(robot, obstacles=[post]))
    assert both.robot("rover").readings["sonar"].true[0] == pytest.approx(1.9, abs=0.005)
