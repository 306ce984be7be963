"""Zones in files: read, written, and what is wrong with them."""

from __future__ import annotations

import copy
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.reading.read import loads

ROOM = "width 7000\nheight 4000\n0 0 7000 0\n7000 0 7000 4000\n7000 4000 0 4000\n0 4000 0 0\n"
BASE: dict[str, Any] = {
    "format": 1,
    "world": {"map": "room.wld"},
    "robots": [{"name": "rover", "model": "pioneer2dx", "pose": {"x": 1.0, "y": 2.0}}],
    "zones": [
        {"name": "oil", "shape": {"circle": 0.8}, "pose": {"x": 3.0}, "ground": [{"use": "scale", "factor": 0.7}]},
        {"shape": {"rectangle": [0.1, 2.0]}, "ground": [{"use": "bump", "height": 0.01}]},
    ],
}


def read(folder: Path, **changes: Any) -> am.Scenario:
    (folder / "room.wld").write_text(ROOM, encoding="utf-8")
    document = copy.deepcopy(BASE)
    document["zones"][0] |= changes
    return loads(document, folder)


def test_zones_are_read_and_written_again(tmp_path: Path) -> None:
    scenario = read(tmp_path)
    oil, sill = scenario.zones
    assert (oil.name, oil.pose.x, oil.ground[0].name) == ("oil", 3.0, "scale")
    assert sill.name == "zone2"
    again = loads(resolved_table(scenario), tmp_path)
    assert resolved_table(again) == resolved_table(scenario)
    assert again.zones[1].shape == sill.shape


@pytest.mark.parametrize(
    ("changes", "path", "problem"),
    [
        ({"slip": 0.3}, "zones.0.slip", "unknown key; known keys: name, shape, pose, ground"),
        ({"shape": {"circle": -1.0}}, "zones.0.shape.circle", "above 0 m"),
        ({"shape": {"polygon": [[0, 0], [1, 0], [0, 1]], "rounding": 0.1}}, "zones.0.shape", "without rounding"),
        ({"ground": [{"use": "scale", "factor": -1}]}, "zones.0.ground.0.factor", "> 0"),
        ({"name": "zone2"}, "", ""),
        ({"name": "no name"}, "zones.0.name", "expected a name"),
    ],
)
def test_faults_say_where_they_are(tmp_path: Path, changes: dict[str, Any], path: str, problem: str) -> None:
    with pytest.raises(am.ScenarioError, match=r"zones") as caught:
        read(tmp_path, **changes)
    if path:
        assert path in [fault.path for fault in caught.value.faults]
        assert problem in str(caught.value)


def test_two_zones_of_one_name_are_a_fault(tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text(ROOM, encoding="utf-8")
    document = copy.deepcopy(BASE)
    document["zones"][1]["name"] = "oil"
    with pytest.raises(am.ScenarioError, match=r"zones.1.name: zones.0 is called 'oil' too"):
        loads(document, tmp_path)


def test_a_setting_finds_a_zone_by_name(tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text(ROOM, encoding="utf-8")
    scenario = loads(copy.deepcopy(BASE), tmp_path, ["zones.oil.ground.scale.factor=0.4"])
    assert scenario.zones[0].ground[0].noise.factor == 0.4  # type: ignore[attr-defined]


def test_a_run_over_zones_reproduces_and_shows_them(tmp_path: Path) -> None:
    scenario = read(tmp_path)
    summary = am.run(scenario, tmp_path / "run", duration=1.0)
    assert am.reproduce(summary.folder).is_exact
