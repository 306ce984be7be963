"""A plain class tells what else it believes: to the window, to metrics, and from a grader's process."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amorsim as am
from amorsim.analysis import RunFiles
from tests import building


class Cloud:
    """Particles, fewer from step to step, and a map."""

    def __init__(self, start: Any) -> None:
        self.pose, self.count = np.array(start), 9

    def update(self, readings: Any, command: Any, elapsed: float) -> Any:
        self.count = max(3, self.count - 1)
        return self.pose

    def beliefs(self) -> dict[str, Any]:
        return {"particles": np.tile(self.pose, (self.count, 1)), "steps": self.count, "is_sure": np.array([True])}


def simulation(estimator: Any, **kwargs: Any) -> am.Simulation:
    robot = building.robot(estimators={"own": estimator})
    return am.Simulation(building.scenario(robots=[robot]), **kwargs)


def test_they_are_those_of_each_object() -> None:
    sim = simulation(Cloud, replicas=2)
    beliefs = sim.frames()[0].beliefs["own"]
    assert beliefs["particles"].shape == (2, 8, 3)
    assert beliefs["steps"].tolist() == [8, 8]
    assert beliefs["is_sure"].dtype == np.bool_
    kept = sim.run(0.3, keep=("beliefs.own.steps", "last.beliefs.own.particles", "last.true_pose"), progress=False)
    assert kept["beliefs.own.steps"][:, 0].tolist() == [7, 6, 5]
    assert kept["last.beliefs.own.particles"].shape == (1, 2, 5, 3)
    assert (kept["last.true_pose"][0] == sim.true_pose).all()


def test_a_smaller_cloud_than_that_of_another_row_is_filled_up() -> None:
    sim = simulation(Cloud, replicas=2)
    sim.frames()
    sim.reset(1)
    sim.step()
    made = sim.frames()[0].beliefs["own"]["particles"]
    assert made.shape[0] == 2
    assert np.isfinite(made[0, :3]).all()


class Silent(Cloud):
    beliefs = None  # type: ignore[assignment]


class Wrong(Cloud):
    def beliefs(self) -> Any:
        return ["particles"]


class Plain:
    def __init__(self, start: Any) -> None:
        self.pose = np.array(start)

    def update(self, readings: Any, command: Any, elapsed: float) -> Any:
        return self.pose


def test_a_class_without_them_has_none(tmp_path: Path) -> None:
    sim = simulation(Plain)
    assert dict(sim.frames()[0].beliefs["own"]) == {}
    with pytest.raises(am.AmorsimError, match="occupancy"):
        sim.run(0.1, keep=("last.beliefs.own.occupancy",), progress=False)
    lines = inspect.getsource(Plain).replace("Any", "object").replace("np.array", "list")
    (tmp_path / "plain.py").write_text(lines)
    scenario = building.write_rover(tmp_path, "estimators = { own = { use = 'plain.py:Plain' } }")
    am.run(am.load(scenario), tmp_path / "run", duration=0.3)
    assert "own" not in RunFiles(tmp_path / "run").believers


@pytest.mark.parametrize("kind", [Wrong, Silent])
def test_what_is_not_arrays_by_name_is_said_with_the_class(kind: type) -> None:
    sim = simulation(kind)
    with pytest.raises(am.ComponentError, match="beliefs"):
        dict(sim.frames()[0].beliefs["own"])


def test_quantities_of_the_last_step_are_known_by_name() -> None:
    with pytest.raises(am.AmorsimError, match="quantity"):
        simulation(Plain).run(0.1, keep=("last.nothing",), progress=False)
