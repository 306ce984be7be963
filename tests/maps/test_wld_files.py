"""Line worlds that others drew: what makes their walls fit together, and their slips."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_array_equal

from amorsim.core.errors import MapError
from amorsim.maps.wld import Wld
from amorsim.maps.wld_statements import LineWorld, parse_world
from tests.examples import settings

MAPS = Path(__file__).resolve().parents[3] / "shared" / "maps" / "wld"


def real(name: str) -> Path:
    if not (MAPS / name).is_file():
        pytest.skip(f"no {MAPS / name}")
    return MAPS / name


def read(path: Path, **options: str) -> LineWorld:
    return parse_world(path.read_text(encoding="latin-1"), **options)


def dangling(world: LineWorld) -> int:
    """How many ends of walls meet no other wall's end within 1 mm."""
    ends = world.segments.reshape(-1, 2)
    gaps = np.hypot(*np.moveaxis(ends[:, None] - ends[None], 2, 0))
    np.fill_diagonal(gaps, np.inf)
    return int(np.sum(gaps.min(axis=1) > 0.001))


def test_university_corridor_fits_together_clockwise_only() -> None:
    path = real("uwa-ee4.wld")
    world = read(path)
    assert len(world.segments) == 443
    assert world.warnings == ()
    assert world.extent == (0.0, 0.0, 50.51, 23.63)
    assert dangling(world) == 4
    assert dangling(read(path, push_sign="anticlockwise")) == 14


def test_university_door_fills_its_gap() -> None:
    # The wall 22280 0 22280 5080 goes on at 22280 6390; between them is a door, drawn from 0 0 to 1305 0 in a
    # frame pushed at 22280 6390 90. All of it is in a frame at (15000 + 6148, 5000 + 1750).
    corner = np.array([15.0 + 6.148 + 22.28, 5.0 + 1.75])
    path = real("uwa-ee4.wld")

    def nearest(options: dict[str, str], height: float) -> float:
        ends = read(path, **options).segments.reshape(-1, 2)
        return float(np.hypot(*(ends - corner - (0, height)).T).min())

    assert nearest({}, 6.390) < 1e-9
    assert nearest({}, 6.390 - 1.305) < 1e-9
    assert nearest({"push_sign": "anticlockwise"}, 6.390 - 1.305) > 0.004


def test_serpentine_position_is_inside_its_outer_wall() -> None:
    world = read(real("serp-sm.wld"))
    assert world.warnings == ()
    assert world.start == (1.559, 4.381, 0.0)
    outer = world.segments[:4]
    assert outer[:, 0::2].min() < world.start[0] < outer[:, 0::2].max()
    assert outer[:, 1::2].min() < world.start[1] < outer[:, 1::2].max()


def test_table_position_faces_its_open_side() -> None:
    world = read(real("table.wld"))
    assert world.warnings == ()
    assert len(world.segments) == 34
    assert world.start == (0.2, 1.28, -math.pi / 2)


def test_concentric_typos_are_said() -> None:
    world = read(real("concentric.wld"))
    assert [warning.split(":")[0] for warning in world.warnings] == [
        "line 294",
        "line 312",
        "line 330",
        "line 348",
    ]
    assert all("ush 500 0 -5" in warning for warning in world.warnings)
    assert world.extent[:2] == (0.0, 0.0)


def test_hallway_is_a_map() -> None:
    loaded = Wld(resolution=0.01).load(real("hallway.wld"))
    assert loaded.warnings == ()
    assert loaded.shape == (2363, 5051)
    assert loaded.start == (6.5, 18.25, 0.0)
    assert not loaded.occupied(np.array([loaded.start[:2]]))[0]


@given(st.data())
@settings(max_examples=50)
def test_a_file_cut_off_anywhere_is_read_so_far_or_refused(data: st.DataObject) -> None:
    text = real("table.wld").read_text(encoding="latin-1")
    whole = parse_world(text)
    cut = text[: data.draw(st.integers(0, len(text)))]
    if not re.search(r"^\s*width +[1-9]", cut, re.MULTILINE) or not re.search(r"^height +[1-9]", cut, re.MULTILINE):
        with pytest.raises(MapError, match="no wall"):
            parse_world(cut)
        return
    world = parse_world(cut)
    # Of the last line, a number may be shorter, or some missing.
    kept = max(len(world.segments) - 1, 0)
    assert_array_equal(world.segments[:kept], whole.segments[:kept])
    assert len(world.warnings) <= 2
