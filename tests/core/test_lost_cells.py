"""What a copy of a map lost: cells, distance, unknown cells, the start."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from amorsim.core.maps.lost_cells import lost_cells
from amorsim.core.maps.map import Map
from tests.examples import settings

CELLS = np.zeros((6, 9), np.uint8)
CELLS[2, 3] = 1


def test_the_same_map_lost_nothing() -> None:
    world = Map.from_array(CELLS, resolution=0.5, start=(1.0, 1.0, 0.0))
    assert lost_cells(world, world).is_nothing
    lost = lost_cells(world, Map.from_array(CELLS, resolution=0.5))
    assert lost.has_start
    assert not lost.is_nothing


two = st.tuples(st.integers(1, 8), st.integers(1, 8)).flatmap(
    lambda shape: st.tuples(*[hnp.arrays(np.bool_, shape)] * 2)
)


@settings(deadline=None)
@given(pair=two)
def test_against_all_pairs_of_cells(pair: tuple[np.ndarray, np.ndarray]) -> None:
    one, other = pair
    lost = lost_cells(Map.from_array(one, resolution=0.5), Map.from_array(other, resolution=0.5))
    assert (lost.cells, lost.of) == (int((one != other).sum()), one.size)
    farthest = 0.0
    for mine, its in ((one, other), (other, one)):
        for place in np.argwhere(mine & ~its):
            all_there = [math.dist(place, there) * 0.5 for there in np.argwhere(its)]
            farthest = max(farthest, min(all_there, default=math.inf))
    assert lost.farthest == pytest.approx(farthest)


def test_a_shift_of_the_grid_is_reported() -> None:
    one = Map.from_array(CELLS, resolution=0.5, origin=(0.02, 0.0, 0.0))
    lost = lost_cells(one, Map.from_array(CELLS, resolution=0.5))
    assert lost.cells == 0
    assert lost.farthest == pytest.approx(0.02)


def test_a_coarser_copy_is_off_by_less_than_its_cells() -> None:
    walls = [(0.0, 0.0, 3.0, 0.0), (1.0, 0.3, 2.0, 0.9)]
    fine = Map.from_segments(walls, resolution=0.01, extent=(0, 0, 3, 1))
    lost = lost_cells(fine, Map.from_array(fine.to_array(resolution=0.1), resolution=0.1))
    assert lost.cells > 0
    assert 0.0 < lost.farthest < 0.1 * math.sqrt(2)


def test_unknown_cells_that_are_lost_are_counted() -> None:
    unknown = np.zeros_like(CELLS)
    unknown[0, :4] = 1
    one = Map.from_array(CELLS, unknown=unknown, resolution=0.5)
    assert lost_cells(one, Map.from_array(CELLS, resolution=0.5)).unknown == 4
    unknown[0, 1:] = 0
    assert lost_cells(one, Map.from_array(CELLS, unknown=unknown, resolution=0.5)).unknown == 3
