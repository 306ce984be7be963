"""`am.view`: the window for a scenario that was made in Python."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Controller
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.scenario.files.write import with_maps, write_table
from amorsim.ui.simulator.recipe import Recipe
from tests import building
from tests.ui.sessions import Driven
from tests.ui.views import View, drive

pytestmark = pytest.mark.long  # seconds each, in a browser and processes of its own

pytest.importorskip("starlette", reason="the extra 'ui' is not installed")

SCRIPT = """
import amorsim as am
from cart import Patrol


def circle(readings, estimate, clock):
    return am.Twist(0.2, 0.3)


def made():
    rover = am.Robot(
        name="rover",
        shape=am.Shape.circle(0.3),
        drive=am.drives.Differential(wheel_radius_left=0.08, wheel_radius_right=0.08, track=0.33, rate_max=20.0),
        sensors={"encoder": am.sensors.Encoder(counts_per_revolution=39400.0)},
        estimators={"dead_reckoning": am.estimators.DeadReckoning()},
        controller=circle,
        pose=am.Pose(x=-1.0, y=-1.0),
    )
    cart = am.Obstacle(name="cart", shape=am.Shape.circle(0.2), pose=am.Pose(x=1.0, y=1.0), motion=Patrol)
    room = am.Map.from_segments([(-3, -3, 3, -3), (3, -3, 3, 3), (3, 3, -3, 3), (-3, 3, -3, -3)])
    return am.Scenario(map=room, robots=[rover], obstacles=[cart])
"""
CART = """
class Patrol:
    def velocity(self, obstacle):
        return (0.1, 0.0)
"""
VIEW = '\nam.view(made(), out="out", browser=False)\nprint("done")\n'
GUARDED = '\nif __name__ == "__main__":\n    am.view(made(), out="out", browser=False)\n    print("done")\n'
TWICE = """
import os, signal, sys
import amorsim as am
from script import made


class Interrupting:
    # Ctrl-C as soon as the address is there.
    def write(self, text):
        sys.__stdout__.write(text)
        if text.startswith("http://"):
            os.kill(os.getpid(), signal.SIGINT)

    def flush(self):
        sys.__stdout__.flush()


sys.stdout = Interrupting()
for name in ("one", "two"):
    am.view(made(), out=name, browser=False)
    print("done with", name)
"""


def write(folder: Path, rest: str) -> None:
    (folder / "cart.py").write_text(CART)
    (folder / "script.py").write_text(SCRIPT + rest)


@pytest.mark.skipif(sys.platform != "linux", reason="processes are looked for in /proc")
def test_a_scenario_made_in_python_is_shown_until_ctrl_c(
    tmp_path: Path, views: list[View], monkeypatch: pytest.MonkeyPatch
) -> None:
    write(tmp_path, GUARDED)
    view = View(cwd=tmp_path, script="script.py")
    views.append(view)
    drive(view)
    _, said = view.end(signal.SIGINT)
    assert view.process.returncode == 0
    assert said.splitlines() == ["results: out", "done"]
    monkeypatch.syspath_prepend(tmp_path)  # for what the copy of the script imports
    outcome = am.reproduce(tmp_path / "out")
    assert outcome.is_exact
    assert outcome.steps > 3


def test_a_script_may_open_one_window_after_the_other(tmp_path: Path) -> None:
    write(tmp_path, "")
    (tmp_path / "twice.py").write_text(TWICE)
    ended = subprocess.run(
        [sys.executable, "twice.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300.0, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert [line for line in ended.stdout.splitlines() if line.startswith("done")] == ["done with one", "done with two"]


def test_a_script_that_opens_its_window_everywhere_learns_what_to_do(tmp_path: Path) -> None:
    write(tmp_path, VIEW)
    ended = subprocess.run(
        [sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120.0, check=False
    )
    assert ended.returncode == 1
    assert "if __name__ == '__main__':" in ended.stderr.splitlines()[-1]
    assert "done" not in ended.stdout
    assert not (tmp_path / "out").exists()


def circle(readings: Any, estimate: Any, clock: Any) -> am.Twist:
    return am.Twist(0.2, 0.3)


@attrs.frozen(kw_only=True)
class Own(Controller):
    def command(self, robot: Any, readings: Any, estimate: Any, clock: Any, state: Any, draws: Any) -> Any:
        return np.zeros((robot.rows, 2))


def test_what_no_other_process_can_find_is_refused() -> None:
    def inside(readings: Any, estimate: Any, clock: Any) -> am.Twist:
        return am.Twist(0.2, 0.3)

    controllers: list[Callable[..., Any]] = [inside, lambda readings, estimate, clock: None]
    for controller in controllers:
        scenario = building.scenario(building.robot(controller=controller))
        with pytest.raises(am.ScenarioError, match=r"robots.rover.controller: .* at the top of no file"):
            am.view(scenario)
    cart = am.Obstacle(
        name="cart", shape=am.Shape.circle(0.2), pose=am.Pose(x=4.0, y=4.0), motion=lambda obstacle: None
    )
    with pytest.raises(am.ScenarioError, match=r"obstacles.cart.motion: .* at the top of no file"):
        am.view(building.scenario(obstacles=[cart]))
    with pytest.raises(am.ScenarioError, match="Own is not registered"):
        am.view(building.scenario(building.robot(controller=Own())))


def test_mistakes_are_reported_without_the_file_that_nobody_wrote() -> None:
    scenario = building.scenario(building.robot(controller=circle, pose=am.Pose(x=0.0, y=0.0)))
    with pytest.raises(am.AmorsimError, match=r"^robots.rover.pose: at .* the footprint overlaps"):
        am.view(scenario, browser=False)


def test_a_scenario_that_is_saved_names_its_files_from_its_own_folder(tmp_path: Path) -> None:
    study, project = tmp_path / "study", tmp_path / "project"
    for folder in (study, study / "parts", project / "mine"):
        folder.mkdir(parents=True)
    (study / "room.wld").write_text("width 8000\nheight 6000\nposition 1000 1000 0\n")
    (study / "parts" / "mine.py").write_text("def wait(obstacle):\n    return 0.0, 0.0\n")
    (study / "track.csv").write_text("time,x,y\n0,3,3\n10,4,3\n")
    (study / "scenario.toml").write_text(
        'format = 1\n[world]\nmap = "room.wld"\n[[robots]]\nmodel = "pioneer2dx"\n'
        "[[obstacles]]\nshape = { circle = 0.2 }\npose = { x = 5.0, y = 5.0 }\n"
        'motion = { use = "parts/mine.py:wait" }\n'
        "[[obstacles]]\nshape = { circle = 0.2 }\npose = { x = 3.0, y = 3.0 }\n"
        'motion = { use = "track", file = "track.csv" }\n'
    )
    with Driven(Recipe(name=str(study / "scenario.toml")), project=project) as session:
        assert session.request({"do": "save_scenario", "name": "mine/first"})["ok"]
    text = (project / "mine" / "first.toml").read_text()
    assert str(tmp_path) not in text
    for name in ("../../study/room.wld", "../../study/parts/mine.py:wait", "../../study/track.csv"):
        assert f'"{name}"' in text
    (tmp_path / "moved").mkdir()
    study.rename(tmp_path / "moved" / "study")
    project.rename(tmp_path / "moved" / "project")
    am.load(tmp_path / "moved" / "project" / "mine" / "first.toml")


def test_a_bundled_scenario_is_saved_with_its_map(tmp_path: Path) -> None:
    with Driven(Recipe(name="khepera-maze"), project=tmp_path) as session:
        assert session.request({"do": "save_scenario", "name": "own"})["ok"]
    assert 'map = "own.wld"' in (tmp_path / "own.toml").read_text()
    again = am.load(tmp_path / "own.toml")
    assert have_same_cells(again.map, am.load("khepera-maze").map)


def test_a_scenario_that_is_saved_keeps_its_map(tmp_path: Path) -> None:
    passing, project = tmp_path / "passing", tmp_path / "project"
    passing.mkdir()
    project.mkdir()
    world = building.room()
    robot = building.robot(knowledge=am.Knowledge(map=world))
    file = passing / "made.toml"
    write_table(with_maps(building.scenario(robot, map=world), passing), file)
    (project / "first.wld").write_text("somebody else's")
    with Driven(Recipe(name=str(file), passing=str(passing)), project=project) as session:
        assert session.request({"do": "save_scenario", "name": "first"})["ok"]
    for path in passing.iterdir():
        path.unlink()
    again = am.load(project / "first.toml")
    assert again.map.source is not None
    assert again.map.source.path == project / "first-2.wld"
    assert again.robots[0].knowledge.map is not None
    assert have_same_cells(again.map, world)
    assert (project / "first.wld").read_text() == "somebody else's"


@pytest.mark.parametrize("given", [None, 5, am.Simulation])
def test_what_can_be_shown_is_said_where_something_else_is_given(given: Any) -> None:
    with pytest.raises(am.AmorsimError, match=r"scenario: expected a Scenario, a file, or the name of a bundled"):
        am.view(given, browser=False)
