"""What is drawn of a scenario that has faults."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry
from amorsim.ui.scene.still import StillBuilder
from amorsim.ui.simulator.frames.scenes import SceneBuilder

ROOM = "0 0 6000 0\n6000 0 6000 5000\n6000 5000 0 5000\n0 5000 0 0\n"
SOUND = """format = 1
world = { map = "room.wld" }

[[robots]]
name = "rover"
model = "pioneer2dx"
pose = { x = 1.5, y = 2.5, heading_deg = 90.0 }
controller = { use = "wander" }

[[robots]]
name = "scout"
model = "pioneer2dx"
pose = { x = 4.5, y = 2.5 }

[[obstacles]]
name = "box"
shape = { circle = 0.3 }
pose = { x = 3.0, y = 1.0 }

[[landmarks]]
id = 7
x = 5.0
y = 4.0

[[lights]]
x = 1.0
y = 4.0

[[zones]]
name = "ice"
shape = { rectangle = [1.0, 0.5] }
pose = { x = 5.0, y = 1.0 }
ground = [{ use = "scale", factor = 0.9 }]
"""


@pytest.fixture
def still_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """The still scene of the sound text with parts of it replaced."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "room.wld").write_text(ROOM)

    def make(*changes: tuple[str, str]) -> Any:
        text = SOUND
        for old, new in changes:
            assert old in text
            text = text.replace(old, new, 1)
        (tmp_path / "some.toml").write_text(text)
        still = StillBuilder(am.open_document("some.toml").partial(), "some").still
        json.dumps(still, allow_nan=False)
        return still

    return make


@pytest.mark.parametrize("name", sorted(default_registry().names("scenario")))
def test_of_a_sound_scenario_it_is_the_simulations_scene(name: str) -> None:
    still = StillBuilder(am.open_document(name).partial(), name).still
    scenario = am.load(name)
    simulation = am.Simulation(scenario)
    scene = SceneBuilder(simulation).scene
    order = {robot["name"]: robot for robot in still["scene"]["robots"]}
    assert set(order) == {robot["name"] for robot in scene["robots"]}
    for key in ("map", "maps", "floor", "dt", "duration", "seed"):
        assert still["scene"][key] == scene[key], key  # type: ignore[literal-required]
    for robot in scene["robots"]:
        kind = still["scene"]["kinds"][order[robot["name"]]["kind"]]
        assert {**kind, "sensors": None} == {**scene["kinds"][robot["kind"]], "sensors": None}
    assert [one["name"] for one in still["scene"]["obstacles"]] == [one["name"] for one in scene["obstacles"]]
    drawn = {robot.name for robot in scenario.robots if robot.pose is None}
    for place, robot in zip(still["robots"], still["scene"]["robots"], strict=True):
        assert (place is None) == (robot["name"] in drawn)
        if place is not None:
            assert place == pytest.approx(simulation.robot(robot["name"]).true_pose.tolist())


def test_what_can_be_read_has_its_place_and_the_rest_an_outline(still_of: Any) -> None:
    still = still_of(
        ('use = "wander"', 'use = "wonder"'), ('name = "scout"', 'name = "scout"\ndrive = { track = "x" }')
    )
    assert [robot["name"] for robot in still["scene"]["robots"]] == ["rover"]
    assert still["robots"] == [[1.5, 2.5, pytest.approx(1.5707963)]]
    assert [(one["name"], one["pose"]) for one in still["outlines"]] == [("scout", [4.5, 2.5, 0.0])]
    assert len(still["outlines"][0]["footprint"]["polygon"]) == 8
    assert [one["name"] for one in still["scene"]["obstacles"]] == ["box"]
    assert still["obstacles"] == [[3.0, 1.0, 0.0]]
    assert still["extent"] == [0.0, 0.0, 6.0, 5.0]
    floor = still["scene"]["floor"]
    assert (floor["landmarks"], floor["lights"]) == ([[5.0, 4.0, 0.05]], [[1.0, 4.0]])
    assert len(floor["zones"]) == 1


def test_without_a_map_all_that_stands_in_the_world_is_in_sight(still_of: Any) -> None:
    still = still_of(("room.wld", "rom.wld"))
    assert (still["scene"]["map"], still["scene"]["maps"]) == (None, [])
    x0, y0, x1, y1 = still["extent"]
    assert x0 < 0.9
    assert y0 < 0.6
    assert x1 > 5.5
    assert y1 > 4.1


def test_a_body_whose_start_is_drawn_has_no_place_yet(still_of: Any) -> None:
    still = still_of(
        ("pose = { x = 4.5, y = 2.5 }", 'start = { random = "anywhere" }'),
        ("pose = { x = 3.0, y = 1.0 }", 'start = { random = "anywhere" }'),
    )
    assert [place is None for place in still["robots"]] == [False, True]
    assert still["obstacles"] == [None]


def test_of_an_empty_file_there_is_an_empty_world(tmp_path: Path) -> None:
    (tmp_path / "some.toml").write_text("")
    still = StillBuilder(am.open_document(tmp_path / "some.toml").partial(), "some").still
    assert still["scene"]["robots"] == []
    x0, y0, x1, y1 = still["extent"]
    assert x0 < x1
    assert y0 < y1


def test_nothing_of_a_users_runs(still_of: Any, tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(
        "import pathlib\npathlib.Path('was-run').touch()\ndef go(r, e, c):\n    return (0, 0)\n"
    )
    still = still_of(('use = "wander"', 'use = "own.py:go"'), ("circle = 0.3", "circle = -0.3"))
    assert [robot["name"] for robot in still["scene"]["robots"]] == ["rover", "scout"]
    assert not (tmp_path / "was-run").exists()
