"""Starts that are drawn without a simulation are those of a simulation."""

from __future__ import annotations

from pathlib import Path

import pytest

import amorsim as am
from amorsim.simulation.fleet.starting import drawn_starts

FLEET = """format = 1

[world]
map = {world}

[simulation]
seed = 9

[[robots]]
name = "lone"
model = "pioneer2dx"

[[robots]]
name = "fleet"
model = "pioneer2dx"
count = 5
start = {{ random = [1.0, 1.0, 5.0, 5.0], clearance = 0.05 }}

[[obstacles]]
name = "post"
shape = {{ circle = 0.15 }}
count = 6
start = {{ random = "anywhere" }}
"""
WORLDS = ['"room.wld"', '{ generate = "maze", per = "replica" }']


@pytest.mark.parametrize("world", WORLDS)
@pytest.mark.parametrize("replica", [0, 3])
def test_starts_are_those_of_a_run(world: str, replica: int, tmp_path: Path) -> None:
    (tmp_path / "room.wld").write_text(
        "0 0 6000 0\n6000 0 6000 6000\n6000 6000 0 6000\n0 6000 0 0\nposition 500 500 0\n"
    )
    file = tmp_path / "fleet.toml"
    file.write_text(FLEET.format(world=world))
    scenario = am.load(file)
    starts = drawn_starts(scenario, scenario.map, scenario.seed, replica)
    assert sorted(starts) == [*(f"fleet{n}" for n in range(5)), *(f"post{n}" for n in range(6))]
    simulation = am.Simulation(scenario, replicas=[replica])
    for name, pose in starts.items():
        body = simulation.robot(name) if name.startswith("fleet") else simulation.obstacle(name)
        assert body.true_pose == pytest.approx(pose, abs=0.0)
