"""Maps written as Stage worlds and as maps of MobileSim: read again, they have the same cells in the same places."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import amorsim as am
from amorsim.core.errors import MapError
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.foreign.mobilesim import MobileSimMap
from amorsim.foreign.stage.map import StageMap
from tests.examples import settings

SIDES = st.sampled_from((0.001, 0.02, 0.05, 0.1, 1.0 / 3.0, 2.0))


@st.composite
def cells(draw: st.DrawFn) -> am.Map:
    """A map of a few cells, whose corner lies on the grid."""
    side = draw(SIDES)
    rows, cols = draw(st.integers(1, 12)), draw(st.integers(1, 12))
    array = draw(st.lists(st.booleans(), min_size=rows * cols, max_size=rows * cols))
    corner = draw(st.integers(-50, 50)) * side, draw(st.integers(-50, 50)) * side, 0.0
    return am.Map.from_array(np.reshape(array, (rows, cols)), resolution=side, origin=corner)


@pytest.mark.parametrize("ending", [".world", ".map"])
@given(world=cells())
@settings(max_examples=40)
def test_cells_are_the_same(tmp_path_factory, ending: str, world: am.Map) -> None:
    path = tmp_path_factory.mktemp("maps") / f"any{ending}"
    use = {".world": "stage", ".map": "mobilesim"}[ending]
    saved = am.save_map(world, path, use=use)
    assert have_same_cells(saved, world)
    again = am.load_map(path, use=use, resolution=world.resolution)
    assert have_same_cells(again, world)


@given(
    walls=st.lists(st.tuples(*[st.floats(-3, 3)] * 4), min_size=1, max_size=8),
    side=st.sampled_from((0.01, 0.05)),
)
@settings(max_examples=30)
def test_lines_stay_lines_in_mobilesim(tmp_path_factory, walls, side: float) -> None:
    world = am.Map.from_segments(walls, resolution=side, extent=(-3, -3, 3, 3), start=(0.5, 0.25, 1.0))
    saved = am.save_map(world, tmp_path_factory.mktemp("maps") / "any.map", use="mobilesim")
    assert have_same_cells(saved, world)
    assert saved.start[:2] == (0.5, 0.25)
    assert saved.start[2] == pytest.approx(1.0)
    np.testing.assert_allclose(saved.segments, world.segments, atol=1e-15)


def test_what_is_written_is_a_scenario_too(tmp_path) -> None:
    array = np.ones((30, 40))
    array[1:-1, 1:-1] = 0
    world = am.Map.from_array(array, resolution=0.1)
    am.save_map(world, tmp_path / "hall.world", use="stage")
    scenario = am.load(tmp_path / "hall.world")
    assert have_same_cells(scenario.map, world)
    assert scenario.robots[0].model == "pioneer2dx"


@pytest.mark.parametrize("kind", [StageMap, MobileSimMap])
def test_a_turned_map_is_refused(kind, tmp_path) -> None:
    world = am.Map.from_array([[1, 0]], resolution=0.1, origin=(0.0, 0.0, math.pi / 6))
    with pytest.raises(MapError, match="this map is turned"):
        kind.save(world, tmp_path / "x.map")
