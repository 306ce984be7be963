"""Users' programs run where a simulation is made of a scenario, and nowhere before."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import attrs
import pytest

import amorsim as am
from amorsim.scenario.files.write import resolved_table, with_copies
from amorsim.scenario.reading.read import check_words
from tests.studies import make_study

MARKED = (
    "from pathlib import Path\n\nwith (Path(__file__).parent / 'ran.txt').open('a') as file:\n    file.write('x')\n\n\n"
    "def drive(readings, estimate, clock, speed):\n    return am.Twist(speed)\n\n\nimport amorsim as am\n"
)

READS: dict[str, Callable[[Path], Any]] = {
    "load": am.load,
    "words": check_words,
    "document": lambda path: am.open_document(path).scenario(),
    "faults": lambda path: am.open_document(path).faults(),
    "partial": lambda path: am.open_document(path).partial(),
    "resolved": lambda path: resolved_table(am.load(path)),
    "copies": lambda path: with_copies(am.load(path), path.parent.parent),
    "pickle": lambda path: pickle.loads(pickle.dumps(am.load(path).robots[0].controller)),
    "changed": lambda path: attrs.evolve(am.load(path), duration=3.0),
}


@pytest.mark.parametrize("read", READS.values(), ids=list(READS))
def test_nothing_runs_where_a_scenario_is_read_and_written(tmp_path: Path, read: Callable[[Path], Any]) -> None:
    path = make_study(tmp_path / "study", MARKED)
    read(path)
    assert not (path.parent / "ran.txt").exists()


def test_it_runs_once_for_a_simulation(tmp_path: Path) -> None:
    path = make_study(tmp_path / "study", MARKED)
    scenario = am.load(path)
    first, second = am.Simulation(scenario), am.Simulation(scenario, seed=5)
    assert (path.parent / "ran.txt").read_text() == "x"
    for simulation in (first, second):
        simulation.run(0.3)
        assert simulation.robot("rover").true_twist[0] > 0.0


def test_a_scenario_that_was_loaded_stays_as_it_is_loaded(tmp_path: Path) -> None:
    """An edit of the file changes only simulations that are made afterwards."""
    path = make_study(tmp_path / "study", MARKED)
    simulation = am.Simulation(am.load(path))
    (path.parent / "controller.py").write_text("def drive(readings, estimate, clock, speed):\n    return None\n")
    simulation.reset()
    simulation.run(0.3)
    again = am.Simulation(am.load(path))
    again.run(0.3)
    assert simulation.robot("rover").true_twist[0] > 0.0
    assert again.robot("rover").true_twist[0] == 0.0


def test_robots_of_one_table_share_a_group(tmp_path: Path) -> None:
    path = make_study(tmp_path / "study", MARKED)
    scenario = am.load(path, ["robots.0.pose.y=1.0", "robots.0.name=rover"])
    rover = scenario.robots[0]
    both = attrs.evolve(scenario, robots=[rover, attrs.evolve(rover, name="other", pose=am.Pose(x=5.0, y=3.0))])
    simulation = am.Simulation(both)
    one, other = simulation.scenario.robots
    assert one.controller is other.controller
    assert len(simulation._fleet.groups) == 1


def test_faults_of_loading_have_lines_and_come_together(tmp_path: Path) -> None:
    path = make_study(tmp_path / "study", "1 / 0\n\n\ndef drive(r, e, c, speed):\n    pass\n")
    (path.parent / "other.py").write_text("import nothing_there\n\n\ndef go(o):\n    pass\n")
    text = path.read_text() + (
        "\n[[obstacles]]\nname = 'box'\nshape = { circle = 0.1 }\npose = { x = 6.0, y = 4.0 }\n"
        "motion = { use = 'other.py:go' }\n"
    )
    path.write_text(text)
    lines = text.splitlines()
    with pytest.raises(am.ScenarioError) as caught:
        am.Simulation(am.load(path))
    of_robot, of_obstacle = caught.value.faults
    assert (of_robot.file, of_robot.named) == (str(path), "robots.rover.controller.use")
    assert "controller.py:drive" in lines[(of_robot.line or 0) - 1]
    assert "controller.py, line 1: ZeroDivisionError" in of_robot.message
    assert (of_obstacle.named, lines[(of_obstacle.line or 0) - 1]) == (
        "obstacles.box.motion.use",
        "motion = { use = 'other.py:go' }",
    )
    assert "other.py, line 1: ModuleNotFoundError" in of_obstacle.message
