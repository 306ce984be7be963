"""Components of every kind in a user's file: read without running it, loaded, carried along and reproduced."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.runs.reproduce import reproduce
from amorsim.scenario.files.write import resolved_table
from amorsim.scenario.programs.user_components import USER_CODE
from amorsim.scenario.reading.planners import read_planner

CODE = """
import math
from pathlib import Path

import amorsim as am
import attrs
import numpy as np

with (Path(__file__).parent / "ran.txt").open("a") as file:
    file.write("x")


class Still:
    def __init__(self, start, shift=0.0):
        self.pose = np.array(start)
        self.shift = shift

    def update(self, readings, command, elapsed):
        self.pose[0] += self.shift * elapsed
        return self.pose, np.eye(3) * 0.01


@attrs.frozen(kw_only=True)
class Turned(am.Estimator):
    bias: float = am.parameter(0.0, unit="rad", ge=-1.0, le=1.0, help="what it adds to the heading")

    def start(self, context):
        return {"pose": context.pose.copy()}

    def update(self, robot, readings, command, elapsed, state, draws):
        pose = state["pose"].copy()
        pose[:, 2:] += self.bias
        return am.Estimate(pose, np.zeros((robot.rows, 3, 3)))


@attrs.define(kw_only=True)
class Count(am.Recorder):
    name: str = am.parameter("count.txt", help="of its file")
    steps: int = attrs.field(default=0, init=False)
    file: Path = attrs.field(default=None, init=False)

    def open(self, run, frames):
        self.file = run.folder / self.name

    def write(self, frames, events):
        self.steps += 1

    def close(self):
        self.file.write_text(str(self.steps))


@attrs.frozen(kw_only=True)
class Straight(am.Planner):
    bend: float = am.parameter(0.0, help="not used")

    def plan(self, world, start, goal, *, footprint=None):
        heading = math.atan2(goal[1] - start[1], goal[0] - start[0])
        poses = np.array([[*start[:2], heading], [*goal[:2], heading]])
        length = math.dist(start[:2], goal[:2])
        return am.Plan(status="found", poses=poses, length=length, cost=length)


@attrs.frozen(kw_only=True)
class Glide(am.Motion):
    speed: float = am.parameter(0.1, unit="m/s", help="forward")

    def propose(self, view, dt, state, draws):
        return np.concatenate((np.full((view.rows, 1), self.speed * dt), np.zeros((view.rows, 2))), axis=1)


@attrs.frozen(kw_only=True)
class Bounce(am.Controller):
    speed: float = am.parameter(0.2, unit="m/s", help="forward")

    def command(self, robot, readings, estimate, clock, state, draws):
        twist = np.concatenate((np.full((robot.rows, 1), self.speed), np.zeros((robot.rows, 2))), axis=1)
        return robot.drive.command_for(twist, np.zeros((robot.rows, len(robot.drive.joints))))


@attrs.frozen(kw_only=True)
class Last(am.Metric):
    unit = "m"
    better = "lower"
    part: int = am.parameter(0, help="of the pose")

    def measure(self, episode):
        return episode.kept["true_pose"][-1, :, self.part]


def alone(*_):
    return None
"""

SCENARIO = """
format = 1

[world]
map = "room.wld"

[simulation]
duration = 1.0

[recording]
also = [{ use = "mine.py:Count", name = "steps.txt" }]

[[robots]]
name = "rover"
model = "pioneer2dx"
controller = { use = "navigate", goals = [[4.0, 2.0]], planner = { use = "mine.py:Straight", bend = 0.5 } }
knowledge = { map = "room.wld" }

[robots.estimators.still]
use = "mine.py:Still"
shift = 0.5

[robots.estimators.turned]
use = "mine.py:Turned"
bias_deg = 10.0

[[robots]]
name = "other"
model = "pioneer2dx"
pose = { x = 1.5, y = 3.0 }
controller = { use = "mine.py:Bounce", speed = 0.1 }

[[obstacles]]
name = "box"
shape = { circle = 0.2 }
pose = { x = 3.0, y = 3.5 }
motion = { use = "mine.py:Glide", speed = 0.05 }
"""

ROOM = "0 0 6000 0\n6000 0 6000 4000\n6000 4000 0 4000\n0 4000 0 0\nposition 1500 1500 0\n"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    folder = tmp_path / "study"
    folder.mkdir()
    (folder / "room.wld").write_text(ROOM)
    (folder / "mine.py").write_text(CODE)
    (folder / "scenario.toml").write_text(SCENARIO)
    return folder / "scenario.toml"


def test_reading_runs_nothing_and_a_simulation_runs_the_file_once(path: Path) -> None:
    scenario = am.load(path)
    resolved_table(scenario)
    assert not (path.parent / "ran.txt").exists()
    am.Simulation(scenario)
    assert (path.parent / "ran.txt").read_text() == "x"


def test_each_is_what_its_class_says(path: Path) -> None:
    simulation = am.Simulation(am.load(path))
    simulation.run(1.0)
    rover, other = (simulation.robot(name) for name in ("rover", "other"))
    frame = next(frame for frame in simulation.frames() if "rover" in frame.names)
    assert frame.estimates["still"].pose[0, 0] == pytest.approx(1.5 + 0.5)
    assert frame.estimates["still"].covariance[0].tolist() == (np.eye(3) * 0.01).tolist()
    assert frame.estimates["turned"].pose[0, 2] == pytest.approx(np.radians(10.0))
    assert rover.true_pose[0] > 1.6
    assert other.true_twist[0] == pytest.approx(0.1, rel=0.05)
    assert simulation.obstacle("box").true_pose[0] == pytest.approx(3.05)


def test_a_runs_folder_carries_the_file_and_reproduces_elsewhere(path: Path, tmp_path: Path) -> None:
    am.run(am.load(path), tmp_path / "run")
    shutil.move(tmp_path / "run", tmp_path / "moved")
    shutil.rmtree(path.parent)
    moved = tmp_path / "moved"
    assert (moved / "steps.txt").read_text() == "10"
    text = (moved / "scenario.toml").read_text()
    assert text.count('"mine.py:') == 6
    assert "bias_deg = 10" in text
    assert reproduce(moved).is_same


@pytest.mark.parametrize(
    ("said", "instead", "place", "message"),
    [
        ("bias_deg = 10.0", "bias_deg = 100.0", "estimators.turned.bias_deg", "<= 57.2958, got 100.0"),
        ("bias_deg = 10.0", "bias = 0.1", "estimators.turned.bias", "this is an angle: write bias_deg"),
        ("shift = 0.5", "shaft = 0.5", "estimators.still.use", "id you mean 'shift'?"),
        ("mine.py:Still", "mine.py:alone", "estimators.still.use", "expected a class, as an estimator remembers"),
        ("mine.py:Still", "mine.py:Stil", "estimators.still.use", "id you mean 'Still'?"),
        ("mine.py:Still", "mine.py:Glide", "estimators.still", "expected"),
        ("mine.py:Straight", "mine.py:Still", "controller.planner.use", "expected a subclass of am.Planner"),
        ("mine.py:Straight", "mine.py:Bounce", "controller.planner.use", "expected a subclass of am.Planner"),
        ("bend = 0.5", "bent = 0.5", "controller.planner.bent", "id you mean 'bend'?"),
        ("mine.py:Count", "mine.py:alone", "recording.also.0.use", "expected a subclass of am.Recorder"),
        ("speed = 0.05", "speed = 'fast'", "motion.speed", "got 'fast'"),
    ],
)
def test_faults_name_the_file_and_the_line(path: Path, said: str, instead: str, place: str, message: str) -> None:
    path.write_text(SCENARIO.replace(said, instead))
    with pytest.raises(am.AmorsimError) as caught:
        am.Simulation(am.load(path)).step()
    assert message in str(caught.value)
    if not isinstance(caught.value, am.ScenarioError):  # a class that says nothing of its kind in its text
        return
    (fault,) = caught.value.faults
    assert fault.file == str(path)
    assert place in (fault.named or fault.path)
    line = path.read_text().splitlines()[(fault.line or 0) - 1]
    assert instead.split(" =")[0] in line or line == 'use = "mine.py:Still"'


def test_a_component_that_breaks_its_contract_is_refused_with_its_problems(path: Path) -> None:
    text = CODE.replace("def propose(self, view, dt, state, draws)", "def propose(self, view, dt)")
    (path.parent / "mine.py").write_text(text)
    with pytest.raises(am.ScenarioError, match=r"mine.py: Glide: propose: expected \(view, dt, state, draws\)"):
        am.Simulation(am.load(path))


@pytest.mark.parametrize("code", ["return None", "return 1, 2, 3, 4", "return float('nan'), 0, 0", "1 / 0"])
def test_what_a_plain_estimator_does_wrong_names_it_and_its_robot(path: Path, code: str) -> None:
    own = CODE.replace("return self.pose, np.eye(3) * 0.01", code)
    (path.parent / "mine.py").write_text(own)
    with pytest.raises(am.ComponentError, match=r"estimator .*mine.py:Still. of robot .rover. r"):
        am.Simulation(am.load(path)).step()


@pytest.mark.long
def test_check_loads_all_of_them_in_another_process(path: Path) -> None:
    assert am.check_code(am.load(path)) == ()
    path.write_text(SCENARIO.replace("shift = 0.5", "shift = 'a'").replace("bias_deg = 10.0", "bias_deg = 'b'"))
    (path.parent / "mine.py").write_text(CODE.replace("self.shift = shift", "self.shift = shift + 1.0"))
    messages = [fault.message for fault in am.check_code(am.load(path))]
    assert len(messages) == 2
    assert "making its object for a try with the options {'shift': 'a'} raised TypeError" in messages[0]
    assert "bias_deg: expected a number" in messages[1]
    assert not [name for name in sys.modules if name.startswith("amorsim_controller") and "mine" in name]


def test_a_snapshot_holds_the_objects_of_an_estimator(path: Path) -> None:
    simulation = am.Simulation(am.load(path))
    simulation.run(0.3)
    held = simulation.snapshot()
    simulation.run(0.3)
    digest = simulation.digest()
    simulation.restore(held)
    simulation.run(0.3)
    assert simulation.digest() == digest


def test_a_plain_class_can_be_given_as_an_object(path: Path) -> None:
    class Here:
        def __init__(self, start: np.ndarray) -> None:
            self.pose = start

        def update(self, readings, command, elapsed):
            assert readings["laser"].measured.shape == (181,)
            return self.pose

    scenario = am.load(path)
    rover = attrs.evolve(scenario.robots[0], estimators={"here": Here})
    simulation = am.Simulation(attrs.evolve(scenario, robots=[rover]))
    simulation.run(0.5)
    assert simulation.estimated_pose[0].tolist() == [1.5, 1.5, 0.0]


def test_a_component_of_an_imported_file_is_recorded_without_a_plugin(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own_filters.py").write_text(CODE)
    monkeypatch.syspath_prepend(str(tmp_path))
    import own_filters

    scenario = am.load(path)
    rover = attrs.evolve(scenario.robots[0], estimators={"turned": own_filters.Turned(bias=0.2)})
    am.run(attrs.evolve(scenario, robots=[rover], obstacles=[], recording=am.Recording()), tmp_path / "run")
    assert (tmp_path / "run" / "own_filters.py").is_file()
    assert "own_filters.py:Turned" in (tmp_path / "run" / "scenario.toml").read_text()
    assert reproduce(tmp_path / "run").is_same


def test_an_estimator_in_a_file_runs_on_a_log(path: Path) -> None:
    robot = attrs.evolve(am.load(path).robots[0], pose=am.Pose(x=1.0, y=2.0))
    runner = am.EstimatorRunner(robot, "still")
    runner.update(0.0, {})
    assert runner.update(1.0, {}).pose.tolist() == [1.5, 2.0, 0.0]


def test_a_planner_in_a_file_is_asked_for_by_name(path: Path) -> None:
    planner = read_planner(f"{path.parent / 'mine.py'}:Straight", ["bend=0.25"])
    assert type(planner).__name__ == "Straight"
    assert planner.bend == 0.25  # type: ignore[attr-defined]
    with pytest.raises(am.ScenarioError, match="id you mean 'bend'"):
        read_planner(f"{path.parent / 'mine.py'}:Straight", ["bent=0.25"])


def study(path: Path, metric: str) -> dict[str, object]:
    return {
        "format": 1,
        "scenario": str(path),
        "replicas": 2,
        "duration": 0.2,
        "metrics": {"end": {"use": f"{path.parent / 'mine.py'}:{metric}", "part": 1, "robot": "rover"}},
    }


def test_a_study_measures_with_a_metric_in_a_file(path: Path, tmp_path: Path) -> None:
    found = am.sweep(study(path, "Last"), tmp_path / "out")
    assert found["end"].tolist() == pytest.approx([1.5, 1.5], abs=0.01)
    assert found.about["metrics"]["end"]["unit"] == "m"
    (path.parent / "mine.py").write_text(CODE.replace("episode.kept", "0.0 * episode.kept"))
    with pytest.raises(am.StudyError, match=r"another .*mine\.py"):
        am.sweep(study(path, "Last"), tmp_path / "out")


def test_a_study_names_what_is_wrong_with_its_metric(path: Path, tmp_path: Path) -> None:
    with pytest.raises(am.StudyError, match=r"metrics.end.use: .*expected a subclass of am.Metric"):
        am.sweep(study(path, "Straight"), tmp_path / "out")
    tables = study(path, "Last")
    tables["metrics"]["end"]["prt"] = 2  # type: ignore[index]
    with pytest.raises(am.StudyError, match=r"metrics.end.prt: .*id you mean 'part'"):
        am.sweep(tables, tmp_path / "out")


def test_the_kinds_that_a_file_may_have_are_those_of_the_guide() -> None:
    guide = (Path(__file__).parents[2] / "docs" / "how-to" / "write-a-plugin.md").read_text(encoding="utf-8")
    paragraph = next(part for part in guide.split("\n\n") if part.startswith("Some kinds need no plugin"))
    assert all(f"`{kind}`" in paragraph for kind in USER_CODE)
