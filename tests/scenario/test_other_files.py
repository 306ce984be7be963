"""Maps and other programs' files opened as documents: a new scenario next to them, and no byte of theirs changed."""

from __future__ import annotations

from pathlib import Path

import pytest

from amorsim.core.errors import DocumentError
from amorsim.scenario.documents.document import open_document
from amorsim.scenario.reading.read import load, scenario_for_map

WORLDS = Path(__file__).resolve().parents[2] / "docs" / "worlds"
MAPS = {
    "court.geojson": {},
    "hall.wld": {},
    "labyrinth.maz": {},
    "plan.png": {"resolution": 0.025},
    "seen.yaml": {},
    "valley.map": {"resolution": 0.5},
    "workshop.dxf": {},
}


@pytest.fixture
def worlds(tmp_path: Path) -> Path:
    for file in WORLDS.iterdir():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    return tmp_path


@pytest.mark.parametrize("name", MAPS)
def test_a_map_becomes_a_scenario_next_to_it(worlds: Path, name: str) -> None:
    before = {path: path.read_bytes() for path in worlds.iterdir()}
    document = open_document(worlds / name)
    assert document.path == (worlds / name).with_suffix(".toml")
    for option, value in MAPS[name].items():
        document.set(f"world.{option}", value)
    assert not document.partial().faults
    document.save()
    assert {path: path.read_bytes() for path in before} == before
    found, expected = load(document.path), scenario_for_map(worlds / name, **MAPS[name])
    assert found.map == expected.map
    assert [robot.pose for robot in found.robots] == [robot.pose for robot in expected.robots]


def test_a_name_that_is_taken_is_numbered(worlds: Path) -> None:
    (worlds / "hall.toml").write_text("")
    assert open_document(worlds / "hall.wld").path == worlds / "hall_2.toml"


def test_faults_of_the_map_are_faults_of_the_document(worlds: Path) -> None:
    (worlds / "valley.map").write_text("type octile\nheight 2\nwidth 2\nmap\n..\n")
    faults = open_document(worlds / "valley.map").partial().faults
    assert [fault.path for fault in faults] == ["world.map"]
    assert "valley.map" in faults[0].message


def test_text_that_no_loader_knows_is_still_a_scenario(tmp_path: Path) -> None:
    path = tmp_path / "scenario.txt"
    path.write_text("[simulation]\nseed = 3\n")
    assert open_document(path).get("simulation.seed") == 3
    assert open_document(path).path == path


def test_a_map_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(DocumentError, match="there is no such file"):
        open_document(tmp_path / "hall.wld")
