"""Other programs' files on the command line: run, checked, changed, drawn and made into scenarios of one's own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from PIL import Image

from amorsim.ui.simulator.recipe import Recipe

WORLD = """\
# A room with two robots, as Stage has it.
resolution 0.05
interval_sim 100
define bot position ( size [0.4 0.3 0.2] ranger( sensor( range [0 5] fov 180 samples 91 ) ) ctrl "wander" )
floorplan( size [6 4 1] bitmap "room.png" )
bot( name "a" pose [-2 0 0 0] )
bot( name "b" pose [2 0 0 180] )
model( name "box" pose [0 1 0 0] size [0.5 0.5 0.5] )
gripper()
"""


@pytest.fixture
def world(tmp_path: Path) -> Path:
    (tmp_path / "worlds").mkdir()
    path = tmp_path / "worlds" / "room.world"
    path.write_text(WORLD)
    Image.new("L", (60, 40), 255).save(path.with_name("room.png"))
    return path


def test_a_stage_world_runs_and_is_reproduced(amorsim, world, tmp_path) -> None:
    result = amorsim("run", world, "--duration", 5, "--out", "out")
    assert result.status == 0, result.err
    assert "a: drove" in result.out
    assert "b: drove" in result.out
    assert "room: room.world:9: a gripper that no robot carries is left out" in result.err
    folder = tmp_path / "out"
    assert (folder / "room" / "room.world").is_file()
    assert (folder / "room" / "room.png").is_file()
    assert (folder / "picture.png").is_file()
    assert json.loads((folder / "run.json").read_text())
    assert amorsim("reproduce", "out").status == 0


def test_a_stage_world_is_checked_and_its_faults_are_reported(amorsim, world) -> None:
    result = amorsim("check", world)
    assert result.status == 0, result.err
    assert "no faults; 6.00 m x 4.00 m, 2 robots (a, b)" in result.out
    world.write_text(WORLD.replace("[2 0 0 180]", "[2 0 0 x]"))
    result = amorsim("check", world)
    assert result.status == 2
    assert "room.world:7: pose: expected a number" in result.err


def test_settings_and_a_resolution_are_for_the_file_too(amorsim, world) -> None:
    result = amorsim("check", world, "--resolved", "--resolution", 0.1, "--set", "loader.sonar_as_ray=true")
    assert result.status == 0, result.err
    assert "resolution = 0.1" in result.out
    assert "unknown key" in amorsim("check", world, "--set", "loader.rays=true").err


def test_the_window_shows_a_stage_world(world) -> None:
    simulation, remark = Recipe(name=str(world)).simulation()
    assert list(simulation.names) == ["a", "b"]
    assert not remark


def test_a_stage_world_becomes_a_scenario_of_ones_own(amorsim, world, tmp_path) -> None:
    result = amorsim("new", "mine", "--from", world, "--copy")
    assert result.status == 0, result.err
    text = (tmp_path / "mine" / "scenario.toml").read_text()
    assert text.startswith("#:schema scenario.schema.json\n# From room.world.\n")
    assert amorsim("check", "mine/scenario.toml").status == 0
    assert world.read_text() == WORLD
