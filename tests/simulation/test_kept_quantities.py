"""`Simulation.run` keeps quantities of every step as arrays, with rows as those of the simulation."""

from __future__ import annotations

import functools

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.contracts import LazyBeliefs
from amorsim.core.execution import memory
from amorsim.scenario.spec import MountedSensor
from amorsim.sensors.laser import Laser
from tests import building

NAMES = ("true_pose", "estimated_pose", "covariance", "active", "command", "readings.laser", "readings.laser.true")


def two_robots(**changes):
    laser = {"encoder": building.encoder(), "laser": MountedSensor(sensor=Laser(beams=5, range_max=8.0))}
    first = building.robot(name="b", controller=building.Roam(), sensors=laser)
    second = building.robot(name="a", controller=building.Roam(), pose=am.Pose(x=4.0, y=3.0), **changes)
    return building.scenario(first, second)


def one_robot():
    laser = {"encoder": building.encoder(), "laser": MountedSensor(sensor=Laser(beams=5, range_max=8.0))}
    return building.scenario(building.robot(controller=building.Roam(), sensors=laser))


def test_what_is_kept_is_what_the_simulation_has_after_each_step() -> None:
    kept = am.Simulation(one_robot(), replicas=3).run(1.0, keep=NAMES)
    again = am.Simulation(one_robot(), replicas=3)
    steps = again.steps_of(1.0)
    assert set(kept) == set(NAMES)
    for step in range(steps):
        again.step()
        for name in NAMES[:4]:
            assert (kept[name][step] == getattr(again, name)).all(), name
        assert (kept["readings.laser"][step] == again.readings["laser"].measured).all()
        assert (kept["readings.laser.true"][step] == again.readings["laser"].true).all()
    assert kept["true_pose"].shape == (steps, 3, 3)
    assert kept["readings.laser"].shape == (steps, 3, 5)
    assert kept["active"].dtype == bool


def test_parts_are_kept_by_robot() -> None:
    alone, pulled = building.robot(name="a", pose=am.Pose(x=4.0, y=3.0)), building.robot(drive=building.tractor())
    simulation = am.Simulation(building.scenario(alone, pulled), replicas=2)
    kept = simulation.run(0.2, keep=["part_pose"])["part_pose"]
    assert kept.shape == (simulation.steps_of(0.2), 4, 1, 3)
    assert np.isnan(kept[:, ::2]).all()
    assert (kept[-1, 1::2, 0] == simulation.part_pose).all()
    without = am.Simulation(one_robot()).run(0.2, keep=["part_pose"])["part_pose"]
    assert without.shape[1:] == (1, 0, 3)


def test_keeping_changes_no_bit() -> None:
    with_, without = (am.Simulation(one_robot(), replicas=2) for _ in range(2))
    with_.run(1.0, keep=NAMES)
    assert without.run(1.0) is None
    assert with_.digest() == without.digest()


def test_what_a_robot_lacks_is_nan() -> None:
    simulation = am.Simulation(two_robots(), replicas=2)
    kept = simulation.run(0.5, keep=("readings.laser", "true_twist", "true_pose"))
    assert simulation.names == ("a", "b")
    assert np.isnan(kept["readings.laser"][:, [0, 2]]).all()
    assert not np.isnan(kept["readings.laser"][:, [1, 3]]).any()
    assert (kept["readings.laser"][-1, 3] == simulation.robot("b", 1).readings["laser"].measured).all()
    assert not np.isnan(kept["true_twist"]).any()
    assert (kept["true_twist"][-1, 2] == simulation.robot("a", 1).true_twist).all()


def test_beliefs_and_estimates_are_kept() -> None:
    scenario = am.load("landmarks")
    estimator = next(name for name, one in scenario.robots[0].estimators.items() if type(one).__name__ == "Ekf")
    belief = f"beliefs.{estimator}.landmarks_nis"
    kept = am.Simulation(scenario).run(2.0, keep=(belief, f"estimates.{estimator}.covariance"))
    assert kept[belief].shape[1] == 1
    assert np.isfinite(kept[belief]).any()
    assert kept[f"estimates.{estimator}.covariance"].shape[1:] == (1, 3, 3)


ASKED: list[str] = []


@attrs.frozen(kw_only=True)
class Counting(am.Estimator):
    """Knows where it began, and notes in `ASKED` what is asked of its beliefs."""

    def start(self, context):
        return {"pose": context.pose.copy()}

    def update(self, robot, readings, command, elapsed, state, draws):
        return am.Estimate(state["pose"], np.zeros((robot.rows, 3, 3)))

    def beliefs(self, state):
        ASKED.append("beliefs")

        def array(name):
            ASKED.append(name)
            return state["pose"][:, :1] * 1.0

        return LazyBeliefs({name: functools.partial(array, name) for name in ("large", "small", "other")})


def test_only_beliefs_that_are_kept_are_computed() -> None:
    ASKED.clear()
    given = building.scenario(building.robot(controller=building.Roam(), estimators={"it": Counting()}))
    simulation = am.Simulation(given, replicas=2)
    simulation.run(1.0, keep=("true_pose", "command", "estimates.it.pose"))
    assert not ASKED
    steps = simulation.steps_of(1.0)
    kept = simulation.run(1.0, keep=("beliefs.it.small", "true_pose", "beliefs.it.other"))
    assert set(ASKED) == {"beliefs", "small", "other"}
    # Once a step, and some times for the names and shapes.
    assert steps <= ASKED.count("small") <= steps + 2
    assert steps <= ASKED.count("beliefs") <= steps + 3
    assert kept["beliefs.it.small"].shape == (steps, 2, 1)


def test_an_unknown_belief_is_told_with_those_that_there_are() -> None:
    given = building.scenario(building.robot(controller=building.Roam(), estimators={"it": Counting()}))
    with pytest.raises(
        am.AmorsimError, match=r"no belief 'smal'; known beliefs: large, other, small\. Did you mean 'small'"
    ):
        am.Simulation(given).run(1.0, keep=("beliefs.it.smal",))


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("true_poses", "Did you mean 'true_pose'?"),
        ("readings.lazer", "no sensor 'lazer'; known sensors: encoder, laser. Did you mean 'laser'?"),
        ("readings.laser.value", "no quantity 'value'; known quantities: age, fresh, measured, stamp, true"),
        ("estimates.ekf.pose", "no estimator 'ekf'"),
        ("beliefs.dead_reckoning.nis", "no estimator of beliefs 'dead_reckoning'; known estimators of beliefs: none"),
        (3, "keep: expected a list of names, each a text, got 3 among them"),
    ],
)
def test_an_unknown_name_is_reported_before_any_step(name: object, words: str) -> None:
    simulation = am.Simulation(one_robot())
    with pytest.raises(am.AmorsimError, match=words.replace("?", r"\?").replace(".", r"\.")):
        simulation.run(1.0, keep=(name,))
    assert simulation.tick == 0


def test_a_text_is_no_list_of_names() -> None:
    with pytest.raises(am.AmorsimError, match=r"expected a list of names, as \['true_pose'\]"):
        am.Simulation(one_robot()).run(1.0, keep="true_pose")


def test_what_does_not_fit_into_memory_is_refused_before_it_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    simulation = am.Simulation(one_robot(), replicas=4)
    monkeypatch.setattr(memory, "memory_of_machine", lambda: 1_000_000)
    with pytest.raises(am.AmorsimError, match=r"36000 steps of readings.laser in 4 replicas would take .* at most;"):
        simulation.run(3600.0, keep=("readings.laser",))
    assert simulation.tick == 0
    assert simulation.run(1.0, keep=("readings.laser",))
