"""Policies as controllers: what was learned in an environment drives in a scenario, to the bit."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("gymnasium", reason="the extra 'learn' is not installed")
onnxruntime = pytest.importorskip("onnxruntime", reason="the extra 'learn' is not installed")

import attrs  # noqa: E402
import numpy as np  # noqa: E402

import amorsim as am  # noqa: E402
from amorsim.controllers import Policy, policy  # noqa: E402
from amorsim.learning import make_vec  # noqa: E402
from amorsim.tasks import PointGoal  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
FILE = ROOT / "amorsim" / "scenarios" / "point-goal.onnx"
SCENARIO = ROOT / "amorsim" / "learning" / "scenarios" / "point-goal.toml"


def test_it_drives_in_a_scenario_as_in_an_environment() -> None:
    """Of three environments, each step is that of the same replica driven by the controller."""
    envs = make_vec("amorsim/PointGoal-v0", 3, autoreset_mode="Disabled")
    session = onnxruntime.InferenceSession(str(FILE))
    seen, _ = envs.reset(seed=41)
    goals = envs._worlds.episode["goal"].copy()
    poses = []
    for _ in range(60):
        actions = [session.run(None, {"observation": one[None]})[0][0] for one in seen]
        seen, _, terminated, _, _ = envs.step(np.array(actions))
        poses.append(envs.simulation.true_pose.copy())
        if terminated.any():
            break
    assert len(poses) > 15
    scenario = am.load(SCENARIO)
    for row, goal in enumerate(goals.tolist()):
        driven = Policy(file=str(FILE), task=PointGoal(), goals=(tuple(goal),), tolerance=1e-6)
        robots = [attrs.evolve(scenario.robots[0], controller=driven)]
        simulation = am.Simulation(attrs.evolve(scenario, robots=robots), seed=0, replicas=[41 + row])
        for number, pose in enumerate(poses):
            simulation.step()
            np.testing.assert_array_equal(simulation.true_pose[0], pose[row], err_msg=f"row {row}, step {number}")


def test_it_goes_from_goal_to_goal_and_stops() -> None:
    scenario = am.load("learned")
    simulation = am.Simulation(scenario)
    simulation.run(scenario.duration)
    assert [event.value for event in simulation.events] == [f"{number} of 6" for number in range(1, 7)]
    place = simulation.true_pose.copy()
    simulation.run(2.0)
    np.testing.assert_array_equal(simulation.true_pose, place)


def made(**changes: object) -> am.Simulation:
    scenario = am.load("learned")
    robot = scenario.robots[0]
    assert isinstance(robot.controller, Policy)
    controller = attrs.evolve(robot.controller, **changes)
    return am.Simulation(attrs.evolve(scenario, robots=[attrs.evolve(robot, controller=controller)]))


def test_what_cannot_be_run_is_refused_in_words(tmp_path: Path) -> None:
    with pytest.raises(am.AmorsimError, match=r"nowhere.onnx: there is no such file"):
        made(file=str(tmp_path / "nowhere.onnx"))
    (tmp_path / "text.onnx").write_text("no network")
    with pytest.raises(am.AmorsimError, match=r"text.onnx: expected a network in ONNX's format"):
        made(file=str(tmp_path / "text.onnx"))
    with pytest.raises(am.AmorsimError, match=r"task.period: expected a whole number of steps of 0.1 s, got 0.25 s"):
        made(task=PointGoal(period=0.25))
    scenario = am.load("learned")
    robot = scenario.robots[0]
    fewer = attrs.evolve(robot.sensors["laser"], sensor=attrs.evolve(robot.sensors["laser"].sensor, beams=91))
    robot = attrs.evolve(robot, sensors={**robot.sensors, "laser": fewer})
    with pytest.raises(am.AmorsimError, match=r"expected an input of 96 values.*got tensor\(float\) of 186"):
        am.Simulation(attrs.evolve(scenario, robots=[robot]))


def test_without_onnxruntime_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    policy._network.cache_clear()
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(am.AmorsimError, match=r'extra "learn": python -m pip install "amorsim\[learn\]"'):
        made()
