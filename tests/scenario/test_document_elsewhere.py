"""Documents saved elsewhere: names of files that lead to the same files, or to copies, and never an absolute one."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.plugins.manager import default_registry

TEXT = """\
# All that names a file.
format = 1
description = "A yard."

[world]
map = "maps/room.wld"

[recording]
also = []

[[robots]]
name = "rover"
model = "models/cart.toml"       # which has a program of its own
pose = { x = 1.0, y = 1.5 }
controller = { use = "mine.py:drive", speed = 0.2 }
knowledge = { map = "maps/plan.wld" }

[[robots]]
name = "r"
count = 2
shape = { rectangle = [0.2, 0.1] }
drive = { use = "differential", wheel_radius_left = 0.02, wheel_radius_right = 0.02, track = 0.1, rate_max_deg = 900 }
start = { grid = [2.0, 2.0], spacing = 0.5 }

[[obstacles]]
name = "ann"
shape = { circle = 0.2 }
motion = { use = "track", file = "ann.csv" }

[[obstacles]]
name = "bob"
shape = { circle = 0.1 }
start = { random = "anywhere" }
motion = { use = "mine.py:stroll" }
"""
PROGRAM = """\
from helper import still


def drive(readings, estimate, clock, speed=0.1):
    return still()


def stroll(obstacle):
    return still()
"""


@pytest.fixture
def document(tmp_path):
    home = tmp_path / "home"
    for folder in ("maps", "models"):
        (home / folder).mkdir(parents=True)
    (home / "maps" / "room.wld").write_text("width 4000\nheight 3000\n")
    (home / "maps" / "plan.wld").write_text("width 4000\nheight 3000\n1000 0 1000 500\n")
    (home / "models" / "cart.toml").write_text(
        '# mine\nformat = 1\nmodel = "../base.toml"\ncontroller = { use = "own.py:drive" }\n'
    )
    (home / "models" / "own.py").write_text("def drive(readings, estimate, clock):\n    return None\n")
    (home / "base.toml").write_text('format = 1\nmodel = "pioneer2dx"\ndrive.track = 0.4\n')
    (home / "mine.py").write_text(PROGRAM)
    (home / "helper.py").write_text("def still():\n    return (0.0, 0.0)\n")
    (home / "ann.csv").write_text("time,x,y\n0,3.0,1.0\n5,3.0,2.0\n")
    (home / "yard.toml").write_text(TEXT)
    return am.open_document(home / "yard.toml")


def test_the_document_is_sound(document):
    assert document.faults() == ()


def test_elsewhere_the_same_files_are_named_from_there(document, tmp_path):
    away = tmp_path / "away" / "deep"
    away.mkdir(parents=True)
    saved = document.save(away / "other.toml")
    text = saved.read_text()
    changed = [now for before, now in zip(TEXT.splitlines(), text.splitlines(), strict=True) if before != now]
    assert changed == [
        'map = "../../home/maps/room.wld"',
        'model = "../../home/models/cart.toml"       # which has a program of its own',
        'controller = { use = "../../home/mine.py:drive", speed = 0.2 }',
        'knowledge = { map = "../../home/maps/plan.wld" }',
        'motion = { use = "track", file = "../../home/ann.csv" }',
        'motion = { use = "../../home/mine.py:stroll" }',
    ]
    again = am.open_document(saved)
    assert again.faults() == ()
    assert again.get("robots.rover.drive.track") == 0.4
    assert document.text == TEXT
    assert document.path.name == "yard.toml"


def test_copies_need_nothing_else(document, tmp_path):
    away = tmp_path / "away"
    away.mkdir()
    (away / "room.wld").write_text("another\n")
    saved = document.save(away / "yard.toml", copy=True)
    (tmp_path / "home").rename(tmp_path / "gone")
    assert (away / "room.wld").read_text() == "another\n"
    assert 'map = "room_2.wld"' in saved.read_text()
    assert str(tmp_path) not in "".join(file.read_text(errors="replace") for file in away.rglob("*") if file.is_file())
    again = am.open_document(saved)
    assert again.faults() == ()
    assert again.get("robots.rover.drive.track") == 0.4
    assert (away / "cart.toml").read_text().startswith("# mine\nformat = 1\n")
    scenario = again.scenario()
    assert scenario.robots[0].knowledge.map.size == (4.0, 3.0)
    assert [robot.name for robot in scenario.robots] == ["rover", "r0", "r1"]


def test_absolute_names_become_relative(document, tmp_path):
    document.set("world.map", str(tmp_path / "home" / "maps" / "room.wld"))
    away = tmp_path / "away"
    away.mkdir()
    assert 'map = "../home/maps/room.wld"' in document.save(away / "yard.toml").read_text()


def test_saving_twice_copies_nothing_again(document, tmp_path):
    away = tmp_path / "away"
    away.mkdir()
    document.save(away / "yard.toml", copy=True)
    before = {file: file.read_bytes() for file in away.rglob("*") if file.is_file()}
    document.save(away / "yard.toml", copy=True)
    assert {file: file.read_bytes() for file in away.rglob("*") if file.is_file()} == before


def test_a_bundled_scenario_is_saved_with_its_map(tmp_path):
    saved = am.open_document("demo").save(tmp_path / "mine.toml", copy=True)
    assert (tmp_path / "office.wld").is_file()
    original = Path(default_registry().file("scenario", "demo"))
    assert saved.read_text() == original.read_text()


def test_what_cannot_be_copied_leaves_no_file(document, tmp_path):
    (tmp_path / "home" / "ann.csv").unlink()
    away = tmp_path / "away"
    away.mkdir()
    with pytest.raises(am.RunError, match=r"ann\.csv"):
        document.save(away / "yard.toml", copy=True)
    assert not (away / "yard.toml").exists()


def test_a_document_names_the_files_that_it_depends_on(tmp_path):
    text = """format = 1
world = { map = "maps/room.wld" }
[[robots]]
name = "rover"
model = "../own.toml"
controller = { use = "own.py:Circling" }
[[robots]]
name = "scout"
model = "pioneer2dx"
controller = { use = "wander" }
knowledge = { map = "maps/room.wld" }
"""
    here = tmp_path / "study"
    found = am.Document(text, here / "some.toml").files()
    assert found == (here / "some.toml", here / "maps" / "room.wld", here / ".." / "own.toml", here / "own.py")
