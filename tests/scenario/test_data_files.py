"""Files that fields of components name: a folder that is made of a scenario has copies of all of them."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.plugins import manager
from amorsim.scenario.documents.names import name_from
from amorsim.scenario.files.model_files import save_robot
from amorsim.scenario.files.write import resolved_table, table_text, with_copies


@attrs.frozen(kw_only=True)
class Table(am.Noise):
    """Leaves values as they are, by a table in a file."""

    table: str = am.parameter("", file=True, help="the file of the table")

    def corrupt(self, values: Any, side: Any, elapsed: Any, state: Any, draws: Any) -> Any:
        return np.asarray(values)


@attrs.frozen(kw_only=True)
class Map(am.planners.AStar):
    """A planner with a table of costs."""

    costs: str = am.parameter("", file=True, static=True, help="the file of the costs")


class Plugin:
    """What has files in its fields."""

    @staticmethod
    @am.hookimpl
    def amorsim_register(registry: Any) -> None:
        registry.noise("table", Table)
        registry.planner("costs", Map)


@pytest.fixture(autouse=True)
def _registry(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    registry = manager.make_registry({"tables": Plugin}, entry_points=(), disabled="")
    monkeypatch.setattr(manager, "make_registry", lambda: registry)
    manager.default_registry.cache_clear()
    yield
    manager.default_registry.cache_clear()


@pytest.fixture
def scenario(tmp_path: Path) -> am.Scenario:
    (tmp_path / "data").mkdir()
    for name in ("a.csv", "b.csv", "c.csv"):
        (tmp_path / "data" / name).write_text(name)
    (tmp_path / "room.wld").write_text("width 4000\nheight 3000\n")
    (tmp_path / "one.toml").write_text(
        "format = 1\nworld = { map = 'room.wld' }\n[[robots]]\nname = 'rover'\nmodel = 'pioneer2dx'\n"
        "pose = { x = 1, y = 1 }\nground = [{ use = 'table', table = 'data/a.csv' }]\n"
        "sensors.laser.noise = [{ use = 'table', table = 'data/b.csv' }]\n"
        "controller = { use = 'navigate', goals = [[2, 2]], planner = { use = 'costs', costs = 'data/c.csv' } }\n"
    )
    return am.load(tmp_path / "one.toml")


def test_a_folder_of_copies_has_them_all(scenario: am.Scenario, tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    folder.mkdir()
    document = with_copies(scenario, folder)
    text = table_text(document)
    assert str(tmp_path) not in text
    assert {file.name for file in folder.iterdir()} == {"a.csv", "b.csv", "c.csv", "room.wld"}
    (folder / "again.toml").write_text(text)
    planner = am.load(folder / "again.toml").robots[0].controller.planner  # type: ignore[union-attr, attr-defined]
    assert planner.costs == str(folder / "c.csv")


def test_names_from_a_folder_are_relative(scenario: am.Scenario, tmp_path: Path) -> None:
    document = resolved_table(scenario)
    name_from(tmp_path / "elsewhere", document, scenario)
    assert str(tmp_path) not in table_text(document)
    assert document["robots"][0]["controller"]["planner"]["costs"] == "../data/c.csv"


def test_a_model_names_them_from_its_folder(scenario: am.Scenario, tmp_path: Path) -> None:
    save_robot(scenario.robots[0], tmp_path / "data" / "mine.toml")
    text = (tmp_path / "data" / "mine.toml").read_text()
    assert str(tmp_path) not in text
    assert 'costs = "c.csv"' in text
