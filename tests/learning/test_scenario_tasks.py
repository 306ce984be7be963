"""Tasks in scenarios: the table [task], from the file to an environment and back."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")


import amorsim as am
from amorsim.learning import make_vec
from amorsim.tasks import PointGoal

ROOT = Path(__file__).resolve().parents[2]
TEXT = (ROOT / "amorsim/learning/scenarios/point-goal.toml").read_text(encoding="utf-8")


def written(folder: Path, task: str) -> Path:
    text = TEXT.replace('map = "../../scenarios/office.wld"', f'map = "{ROOT}/amorsim/scenarios/office.wld"')
    assert '[task]\nuse = "point_goal"\n' in text
    file = folder / "mine.toml"
    file.write_text(text.replace('[task]\nuse = "point_goal"\n', task), encoding="utf-8")
    return file


def test_a_scenario_is_an_environment_without_python(tmp_path: Path) -> None:
    file = written(tmp_path, '[task]\nuse = "point_goal"\ndistance = [0.5, 2.0]\nhorizon = 10.0\n')
    assert am.load(file).task == PointGoal(distance=(0.5, 2.0), horizon=10.0)
    envs = make_vec(file, 3)
    assert envs.task == PointGoal(distance=(0.5, 2.0), horizon=10.0)
    assert make_vec(file, 2, horizon=5.0).task == PointGoal(distance=(0.5, 2.0), horizon=5.0)
    assert make_vec(file, 2, task=PointGoal()).task == PointGoal()
    seen, _ = envs.reset(seed=1)
    assert seen.shape == (3, 186)


def test_a_task_stays_in_what_a_run_keeps(tmp_path: Path) -> None:
    scenario = am.load(written(tmp_path, '[task]\nuse = "point_goal"\ntolerance = 0.3\n'))
    assert scenario.resolved is not None
    assert scenario.resolved["task"]["use"] == "point_goal"
    assert scenario.resolved["task"]["tolerance"] == 0.3
    am.run(scenario, tmp_path / "run", duration=0.5, progress=False)
    again = am.load(tmp_path / "run" / "scenario.toml")
    assert again.task == PointGoal(tolerance=0.3)
    assert again.robots[0].controller == am.controllers.Manual()


@pytest.mark.parametrize(
    ("task", "words"),
    [
        ('[task]\nuse = "point_gaol"\n', r"mine.toml:13: task.use: .*point_goal"),
        ('[task]\nuse = "point_goal"\nhorizont = 3\n', r"mine.toml:14: task.horizont: .*horizon"),
        ('[task]\nuse = "point_goal"\nhorizon = -3\n', r"mine.toml:14: task.horizon: .*> 0"),
    ],
)
def test_wrong_tasks_are_faults_at_their_line(task: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(am.ScenarioError, match=words):
        am.load(written(tmp_path, task))


def test_a_policy_without_its_task_is_told_how_to_name_one(tmp_path: Path) -> None:
    file = written(tmp_path, "")
    text = file.read_text(encoding="utf-8")
    file.write_text(text.replace('{ use = "manual" }', '{ use = "policy", file = "mine.onnx" }'), encoding="utf-8")
    with pytest.raises(
        am.ScenarioError, match=r"controller.task: missing; expected a table with use = the name of a task"
    ):
        am.load(file)


def test_what_has_no_task_is_refused_in_words() -> None:
    with pytest.raises(ValueError, match=r"demo: expected a scenario with \[task\]"):
        make_vec("demo")
    with pytest.raises(TypeError, match=r"no parameter 'distnace'; .*Did you mean 'distance'"):
        make_vec("amorsim/PointGoal-v0", distnace=(1.0, 2.0))
    with pytest.raises(am.AmorsimError, match=r"task: expected .*PointGoal"):
        am.Scenario(map=am.load("demo").map, robots=am.load("demo").robots, task="point_goal")  # type: ignore[arg-type]
