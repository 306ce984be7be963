"""The plugin as it is installed: found by its entry point, and a scenario in which all of it is at work."""

from pathlib import Path

import amorsim_example as example
import numpy as np

import amorsim as am
from amorsim.plugins.manager import default_registry

NAMES = {
    "drive": ("example-tricycle", example.Tricycle),
    "sensor": ("beacon", example.Beacon),
    "noise": ("drift", example.Drift),
    "map_loader": ("maze", example.Maze),
    "recorder": ("tally", example.Tally),
    "metric": ("detour", example.Detour),
    "task": ("roam", example.Roam),
    "scenario_loader": ("course", example.Course),
    "world_generator": ("posts", example.Posts),
    "controller": ("bounce", example.Bounce),
    "planner": ("flood", example.Flood),
    "motion": ("shuttle", example.Shuttle),
    "estimator": ("compass_odometry", example.CompassOdometry),
}


def test_everything_is_registered_by_this_distribution() -> None:
    registry = default_registry()
    for kind, (name, cls) in NAMES.items():
        assert registry.get(kind, name) is cls
        assert registry.entry(kind, name).plugin.distribution == "amorsim-example"
    assert not [problem for problem in registry.problems if "example" in problem]


def test_the_scenario_runs_by_its_name_and_again_from_its_folder(tmp_path: Path) -> None:
    scenario = am.load("example-maze")
    lift = scenario.robots[0]
    assert isinstance(lift.drive, example.Tricycle)
    summary = am.run(scenario, tmp_path / "run", duration=20.0)
    assert summary.is_complete
    assert summary.distance["lift"] > 1.0
    assert summary.collisions["lift"] == 0
    assert am.reproduce(tmp_path / "run").is_same
    header, line = (tmp_path / "run" / "tally.csv").read_text().splitlines()
    assert header == "replica,robot,distance,collisions"
    assert line == f"0,lift,{summary.distance['lift']:.3f},0"


def test_replica_3_of_5_is_replica_3_alone_and_a_snapshot_leads_to_the_same_end() -> None:
    scenario = am.load("example-maze")
    five = am.Simulation(scenario, replicas=5)
    five.run(4.0)
    middle = five.snapshot()
    five.run(4.0)
    end = five.digest()
    five.restore(middle)
    five.run(4.0)
    assert five.digest() == end
    alone = am.Simulation(scenario, replicas=[3])
    alone.run(8.0)
    assert alone.digest(3) == five.digest(3)
    assert not np.array_equal(five.digest(3), five.digest(2))
