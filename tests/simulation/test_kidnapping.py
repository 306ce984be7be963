"""Robots that are carried away in the middle of a run."""

from __future__ import annotations

import tomllib
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.read import loads
from tests import building


def read(text):
    return loads(tomllib.loads(text), Path(am.__file__).parent / "scenarios")


def scenario(*kidnappings):
    given = am.load("landmarks")
    robot = attrs.evolve(given.robots[0], kidnappings=kidnappings)
    return attrs.evolve(given, robots=[robot], resolved=None)


def test_it_is_carried_away_at_its_time_and_that_is_an_event():
    sim = am.Simulation(scenario(am.Kidnapping(time=0.25, x=12.0, y=7.0, heading=1.0)), replicas=2)
    sim.run(0.3)
    assert not sim.events
    sim.step()
    assert [(event.kind, event.tick, event.replica) for event in sim.events] == [
        ("kidnapped", 3, 0),
        ("kidnapped", 3, 1),
    ]
    assert sim.events[0].value == (12.0, 7.0, 1.0)
    assert str(sim.events[0]) == "0.300 s: rover was kidnapped"
    assert np.hypot(*(sim.true_pose[0, :2] - (12.0, 7.0))) < 0.1
    assert np.hypot(*(sim.estimated_pose[0, :2] - (12.0, 7.0))) > 5.0


def test_restored_it_is_carried_away_again():
    sim = am.Simulation(scenario(am.Kidnapping(time=0.3, x=12.0, y=7.0)))
    sim.step()
    kept = sim.snapshot()
    sim.run(1.0)
    first = sim.digest()
    sim.restore(kept)
    sim.run(1.0)
    assert sim.digest() == first
    assert [event.kind for event in sim.events] == ["kidnapped"]


def test_a_run_with_one_is_reproduced(tmp_path):
    am.run(scenario(am.Kidnapping(time=0.3, x=12.0, y=7.0)), tmp_path / "run", duration=1.0)
    assert "kidnapped" in (tmp_path / "run" / "events.csv").read_text()
    assert am.reproduce(tmp_path / "run").is_exact


def test_where_a_wall_is_nobody_can_be_put():
    sim = am.Simulation(scenario(am.Kidnapping(time=0.0, x=-5.0, y=7.0)))
    with pytest.raises(am.AmorsimError, match="cannot stand at"):
        sim.step()


def two(first, second):
    """A robot of each name, at x = -2 m and 2 m, both carried to a place at once."""
    robots = [
        building.robot(
            name=name, pose=am.Pose(x=x), kidnappings=[am.Kidnapping(time=0.5, x=to, y=0.0)], on_collision="continue"
        )
        for name, x, to in (first, second)
    ]
    return am.Simulation(building.scenario(*robots, map=building.empty()), replicas=2)


@pytest.mark.parametrize("names", ["ab", "ba"])
@pytest.mark.parametrize("to", [-5.0, -2.0])
def test_robots_that_are_carried_at_once_do_not_stand_in_each_others_way(names, to):
    """One to where the other was, and that one away, or to where the first was."""
    sim = two((names[0], -2.0, 2.0), (names[1], 2.0, to))
    sim.run(0.6)
    for replica in range(2):
        assert sim.robot(names[0], replica).true_pose.tolist() == [2.0, 0.0, 0.0]
        assert sim.robot(names[1], replica).true_pose.tolist() == [to, 0.0, 0.0]
    assert [event.kind for event in sim.events] == ["kidnapped"] * 4


def test_robots_that_are_carried_to_one_place_are_refused_and_none_moves():
    sim = two(("a", -2.0, 0.0), ("b", 2.0, 0.1))
    with pytest.raises(am.AmorsimError, match=r"robot 'a' cannot stand at .*: it would overlap 'b'"):
        sim.run(0.6)
    assert sim.true_pose[:, 0].tolist() == [-2.0, 2.0, -2.0, 2.0]
    assert not sim.events


def test_a_file_says_so_and_is_written_so():
    given = scenario(am.Kidnapping(time=0.3, x=12.0, y=7.0, heading=0.5), am.Kidnapping(time=3.0, x=2.0, y=7.0))
    again = read(table_text(resolved_table(given)))
    assert again.robots[0].kidnappings == given.robots[0].kidnappings
    text = table_text(resolved_table(given)).replace("time = 3.0", "time = -3.0")
    with pytest.raises(am.ScenarioError, match=r"kidnappings\.1\.time: expected a number \[s\] >= 0"):
        read(text)
