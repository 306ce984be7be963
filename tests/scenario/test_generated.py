"""Generated worlds in scenarios: read, run, written down again, and refused in words."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import Draws, WorldGenerator
from amorsim.core.maps.same_cells import have_same_cells
from amorsim.plugins.manager import make_registry
from amorsim.plugins.registry import Registry
from amorsim.scenario.documents.field_at import field_at
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text, with_copies, write_table
from amorsim.scenario.reading.read import check_words, loads
from amorsim.testing import check_component

MAZE = 'map = { generate = "maze", seed = 3, size = [6, 5] }'


def read(document: str, **options: Any) -> am.Scenario:
    return loads(tomllib.loads(document), Path(), **options)


def text(world: str = MAZE, robot: str = "") -> str:
    return f"""
format = 1
[world]
{world}
[simulation]
duration = 1.0
[[robots]]
name = "rover"
model = "pioneer2dx"
{robot}
"""


def test_the_world_is_that_of_python() -> None:
    scenario = read(text())
    assert scenario.map == am.worlds.maze(3, size=(6.0, 5.0))
    assert am.Simulation(scenario).true_pose[0, :2].tolist() == list(scenario.map.start[:2])


def test_what_is_resolved_is_read_as_the_same_world() -> None:
    scenario = read(text())
    table = resolved_table(scenario)
    assert table["world"]["map"]["generate"] == "maze"
    assert table["world"]["map"]["seed"] == 3
    assert read(table_text(table)).map == scenario.map


def test_a_robot_that_knows_the_same_world_shares_it() -> None:
    scenario = read(text(robot=f"[robots.knowledge]\n{MAZE}"))
    assert scenario.robots[0].knowledge.map is scenario.map


def test_a_copy_of_the_scenario_has_the_cells_and_the_start_in_files(tmp_path: Path) -> None:
    scenario = read(text())
    write_table(with_copies(scenario, tmp_path), tmp_path / "scenario.toml")
    again = am.load(tmp_path / "scenario.toml")
    assert again.map.source.path.parent == tmp_path
    assert have_same_cells(again.map, scenario.map)
    one, other = am.Simulation(scenario), am.Simulation(again)
    assert one.true_pose.tolist() == other.true_pose.tolist()


def test_an_override_changes_the_seed() -> None:
    scenario = read(text(), overrides=["world.map.seed=4"])
    assert scenario.map == am.worlds.maze(4, size=(6.0, 5.0))


@pytest.mark.parametrize(
    ("world", "path", "words"),
    [
        ('map = { generate = "maz" }', "world.map.generate", "Did you mean 'maze'?"),
        ("map = { seed = 3 }", "world.map.generate", "missing; expected the name of a world generator: barn, cave"),
        ('map = { generate = "maze", seed = -1 }', "world.map.seed", "expected a whole number from 0"),
        ('map = { generate = "maze", seed = true }', "world.map.seed", "expected a whole number from 0"),
        ('map = { generate = "maze", lops = 0.5 }', "world.map.lops", "Did you mean 'loops'?"),
        ('map = { generate = "maze", loops = 2 }', "world.map.loops", "<= 1"),
        ('map = { generate = "maze" }\nresolution = 0.1', "world.resolution", "unknown key"),
    ],
)
def test_a_fault_is_found_without_making_the_world(tmp_path: Path, world: str, path: str, words: str) -> None:
    (tmp_path / "study.toml").write_text(text(world))
    with pytest.raises(am.ScenarioError) as caught:
        check_words(tmp_path / "study.toml")
    (fault,) = caught.value.faults
    assert fault.path == path
    assert words in fault.message
    assert fault.line == 4 if "resolution" not in path else fault.line == 5


def test_a_world_that_cannot_be_is_a_fault_of_the_map() -> None:
    with pytest.raises(am.ScenarioError, match=r"world\.map: Maze with seed 0: corridor is 0\.4 m"):
        read(text('map = { generate = "maze", corridor = 0.4 }'))


def test_a_path_leads_to_the_generators_field(registry: Registry) -> None:
    values = tomllib.loads(text())
    field = field_at(values, ("world", "map", "corridor"), registry, Path())
    assert field is not None
    assert field.unit == "m"
    assert field_at({"world": {"map": "room.wld"}}, ("world", "map", "corridor"), registry, Path()) is None


# ------------------------------------------------------------------------------------------- generators of one's own


@attrs.frozen(kw_only=True)
class Hall(WorldGenerator):
    """An empty hall; what it gives is broken in the way that `kind` says."""

    side: float = am.parameter(4.0, unit="m", gt=0, help="of the hall")
    kind: str = am.parameter(
        "whole", choices=("whole", "nothing", "crash", "no start", "in a wall", "clock"), help="of it"
    )

    def generate(self, draws: Draws) -> am.Map:
        if self.kind == "nothing":
            return None  # type: ignore[return-value]
        if self.kind == "crash":
            raise ZeroDivisionError("oh")
        middle = self.side / 2
        start = {"no start": None, "in a wall": (-1.0, 0.0, 0.0)}.get(self.kind, (middle, middle, 0.0))
        cells = np.zeros((round(self.side / 0.1),) * 2)
        if self.kind == "clock":
            _CALLS.append(0)
            cells[0, : len(_CALLS)] = 1
        return am.Map.from_array(cells, resolution=0.1, start=start)


_CALLS: list[int] = []


@pytest.fixture
def with_hall() -> Registry:
    registry = make_registry(entry_points=())
    registry.world_generator("hall", Hall)
    return registry


def test_a_generator_of_ones_own(with_hall: Registry) -> None:
    scenario = read(text('map = { generate = "hall", side = 5 }'), registry=with_hall)
    assert scenario.map.size == (5.0, 5.0)
    assert resolved_table(scenario, registry=with_hall)["world"]["map"] == {
        "generate": "hall",
        "seed": 0,
        "side": 5.0,
        "kind": "whole",
    }
    with pytest.warns(UserWarning, match="the same world"):  # it draws nothing
        check_component(Hall())


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("nothing", "which is not a map"),
        ("crash", "failed with ZeroDivisionError: oh"),
        ("no start", "whose start is None; expected a free place"),
        ("in a wall", "expected a free place"),
    ],
)
def test_a_broken_generator_is_named(with_hall: Registry, kind: str, words: str) -> None:
    with pytest.raises(am.ScenarioError, match=f"Hall with seed 0 .*{words}"):
        read(text(f'map = {{ generate = "hall", kind = "{kind}" }}'), registry=with_hall)


@pytest.mark.parametrize("kind", ["nothing", "crash", "no start", "in a wall", "clock"])
def test_the_check_finds_a_broken_generator(kind: str) -> None:
    with pytest.raises(am.ComponentError, match="world generator Hall"):
        check_component(Hall(kind=kind))
