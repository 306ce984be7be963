"""Robots that differ in name and pose alone: one of them is read where a document is looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import attrs
import pytest

import amorsim as am
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.reading import contents

HEAD = """format = 1
world.map = "room.wld"
"""
ROBOT = """
[[robots]]
name = "r{n}"
model = "pioneer2dx"
pose = {{ x = {x}, y = 2.0 }}
controller = {{ use = "{use}" }}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "room.wld").write_text("0 0 90000 0\n90000 0 90000 5000\n90000 5000 0 5000\n0 5000 0 0\n")
    return tmp_path


def many(folder: Path, count: int, **changed: str) -> am.Document:
    file = folder / "many.toml"
    robots = [ROBOT.format(n=n, x=2.0 + 1.5 * n, use=changed.get(f"r{n}", "wander")) for n in range(count)]
    file.write_text(HEAD + "".join(robots))
    return am.open_document(file)


def assert_same(robots: tuple[am.Robot, ...], document: am.Document) -> None:
    """Each robot says what that of the scenario does which a run reads."""
    scenario = document.scenario()
    for one, other in zip(robots, scenario.robots, strict=True):
        said, meant = (resolved_table(attrs.evolve(scenario, robots=(robot,))) for robot in (one, other))
        assert said == meant


def test_one_of_many_is_read_and_all_are_there(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[str] = []
    read_robot = contents.read_robot

    def counting(node: Any, *more: Any) -> Any:
        read.append(node.path[1])
        return read_robot(node, *more)

    monkeypatch.setattr(contents, "read_robot", counting)
    document = many(folder, 4)
    seen = document.partial()
    assert read == ["0"]
    read.clear()
    assert_same(seen.robots, document)
    assert [robot.name for robot in seen.robots] == [f"r{n}" for n in range(4)]
    assert [robot.pose.x for robot in seen.robots] == [2.0 + 1.5 * n for n in range(4)]
    read.clear()
    document = many(folder, 4, r3="wonder")
    seen = document.partial()
    assert [fault.path for fault in seen.faults] == ["robots.3.controller.use"]
    assert len(seen.robots) == 4
    assert read == ["0", "3", "3", "3"]  # the faulty one once in each reading, the last without its controller
    with pytest.raises(am.AmorsimError, match="wonder"):
        document.scenario()


def test_the_same_words_in_a_model_and_in_the_scenario_mean_two_files(folder: Path) -> None:
    (folder / "parts").mkdir()
    (folder / "parts" / "mine.toml").write_text(
        'format = 1\nmodel = "pioneer2dx"\ncontroller = { use = "drive.py:drive" }\n'
    )
    (folder / "parts" / "drive.py").write_text("def drive(readings, estimate, clock):\n    return 0.0\n")
    text = "".join(ROBOT.format(n=n, x=2.0 + 2.0 * n, use="drive.py:drive") for n in range(2))
    text = text.replace("pioneer2dx", "parts/mine.toml").replace('controller = { use = "drive.py:drive" }', "", 1)
    (folder / "two.toml").write_text(HEAD + text)
    (fault,) = am.open_document(folder / "two.toml").faults()
    assert fault.path == "robots.1.controller.use"


def test_an_error_of_the_pose_is_checked_at_each_pose(folder: Path) -> None:
    document = many(folder, 3)
    for n in range(3):
        document.set(f"robots.{n}.errors.pose.x", {"add": 0.1 * n})
    seen = document.partial()
    assert seen.faults == ()
    assert_same(seen.robots, document)
