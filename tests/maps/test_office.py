"""The office that ships: read whole, every room reached, no place where a robot is caught."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import numpy as np
import pytest

import amorsim.maps.wld
from amorsim.core.maps.map import Map
from amorsim.maps.wld import Wld

PROJECT = Path(__file__).resolve().parents[2]
OFFICE = Path(amorsim.maps.wld.__file__).parents[1] / "scenarios" / "office.wld"


@pytest.fixture(scope="module")
def office() -> Map:
    return Wld().load(OFFICE)


def places() -> dict[str, tuple[float, float]]:
    """The free place that the office's file names for each room [m]."""
    found = re.findall(r"^;; (.+?), [^,]+, free at (\d+) (\d+)$", OFFICE.read_text(encoding="utf-8"), re.MULTILINE)
    return {name: (int(x) / 1000, int(y) / 1000) for name, x, y in found}


def reachable(office: Map, radius: float, step: float = 0.02) -> np.ndarray:
    """Cells of `step` that a disc can be brought to from the start, (rows, columns)."""
    ndimage = pytest.importorskip("scipy.ndimage")
    room = ndimage.distance_transform_edt(office.to_array(resolution=step) == 0) * step
    labels, _ = ndimage.label(room > radius)
    assert office.start is not None
    start = labels[int(office.start[1] / step), int(office.start[0] / step)]
    assert start > 0
    return np.asarray(labels == start)


def test_office_is_what_its_script_draws() -> None:
    script = PROJECT / "tools" / "draw_office.py"
    if not script.is_file():
        pytest.skip("the tools are not installed")
    spec = importlib.util.spec_from_file_location("draw_office", script)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.draw() == OFFICE.read_text(encoding="utf-8")


def test_office_is_read_whole(office: Map) -> None:
    assert office.warnings == ()
    assert office.shape == (16000, 24000)
    assert office.origin == (0.0, 0.0, 0.0)
    assert office.start == (1.4, 8.2, 0.0)
    numbers = re.findall(r"^(?!;)[^;]*", OFFICE.read_text(encoding="utf-8"), re.MULTILINE)
    assert not any("." in line for line in numbers), "whole millimetres only"


def test_office_rooms_can_all_be_reached_by_a_robot_with_room_to_spare(office: Map) -> None:
    rooms = places()
    assert len(rooms) >= 12 + 4  # twelve rooms, and the lobby and corridors
    step = 0.02
    ground = reachable(office, 0.38, step)
    for name, (x, y) in rooms.items():
        assert ground[int(y / step), int(x / step)], name


def test_office_rooms_are_apart_but_for_their_doors(office: Map) -> None:
    """With a disc wider than any door each room is a place of its own."""
    ndimage = pytest.importorskip("scipy.ndimage")
    step = 0.02
    room = ndimage.distance_transform_edt(office.to_array(resolution=step) == 0) * step
    door = 1.1 / 2
    labels, _ = ndimage.label(room > door)
    _, nearest = ndimage.distance_transform_edt(labels == 0, return_indices=True)
    owners = {}
    for name, (x, y) in places().items():
        row, column = int(y / step), int(x / step)
        owners[name] = int(labels[tuple(nearest[:, row, column])])
    corridors = {name for name in owners if name == "Lobby" or "corridor" in name}
    assert len({owners[name] for name in corridors}) == 1
    rooms = [owners[name] for name in owners if name not in corridors]
    assert len(set(rooms)) == len(rooms) >= 12


def test_office_has_no_traps(office: Map) -> None:
    """Where a robot of 0.33 m fits there is, within 0.3 m, a place for one of 0.38 m."""
    ndimage = pytest.importorskip("scipy.ndimage")
    step = 0.02
    tight, easy = reachable(office, 0.33, step), reachable(office, 0.38, step)
    far = ndimage.distance_transform_edt(~easy)[tight] * step
    assert far.max() < 0.3
