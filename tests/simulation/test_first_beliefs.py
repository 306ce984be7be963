"""What robots know of their start: all, all but for a Gaussian error, or nothing."""

from __future__ import annotations

import tomllib
from pathlib import Path

import attrs
import numpy as np
import pytest
from scipy.stats import chi2

import amorsim as am
from amorsim.core.parameters import ParameterError
from amorsim.scenario.files.resolved import resolved_table
from amorsim.scenario.files.write import table_text
from amorsim.scenario.reading.read import loads

FILE = """
format = 1
[world]
map = "hall.wld"
[[robots]]
model = "pioneer2dx"
pose = { x = 2.8, y = 3.0 }
"""


def read(text):
    return loads(tomllib.loads(text), Path(am.__file__).parent / "scenarios")


def scenario(belief, estimator=None):
    given = am.load("landmarks")
    estimators = {"wheels": estimator or am.estimators.DeadReckoning()}
    return attrs.evolve(given, robots=[attrs.evolve(given.robots[0], initial_belief=belief, estimators=estimators)])


def test_an_exact_start_is_the_pose_that_was_given():
    sim = am.Simulation(scenario(am.InitialBelief()), replicas=2)
    np.testing.assert_array_equal(sim.estimated_pose, [[2.8, 3.0, 0.0]] * 2)
    assert (sim.covariance == 0.0).all()


def test_a_gaussian_start_is_as_wrong_as_its_covariance_says():
    covariance = (0.04, 0.01, 0.002, 0.09, -0.003, 0.01)
    belief = am.InitialBelief(kind="gaussian", covariance=covariance)
    sim = am.Simulation(scenario(belief), replicas=1000)
    np.testing.assert_allclose(sim.covariance, np.broadcast_to(belief.matrix, (1000, 3, 3)), rtol=1e-14)
    error = sim.true_pose - sim.estimated_pose
    nees = np.einsum("ni,ij,nj->n", error, np.linalg.inv(belief.matrix), error)
    low, high = chi2.ppf([0.0005, 0.9995], 3000) / 1000
    assert low < nees.mean() < high


def test_a_replica_draws_its_start_alone_and_each_episode_another():
    belief = am.InitialBelief(kind="gaussian", std=0.1, heading_std=0.05)
    many, one = am.Simulation(scenario(belief), replicas=7), am.Simulation(scenario(belief), replicas=[4])
    assert many.estimated_pose[4].tobytes() == one.estimated_pose[0].tobytes()
    assert len(np.unique(many.estimated_pose[:, 0])) == 7
    first = many.estimated_pose.copy()
    many.step()
    one.step()
    many.reset(replicas=[4])
    one.reset()
    assert many.estimated_pose[4].tobytes() == one.estimated_pose[0].tobytes()
    assert (many.estimated_pose[4] != first[4]).all()


@pytest.mark.parametrize("estimator", [am.estimators.DeadReckoning(), am.estimators.Ekf(wheel_variance=1e-5)])
def test_estimators_that_need_a_start_refuse_to_have_none(estimator):
    with pytest.raises(am.ComponentError, match="knows nothing of its start"):
        am.Simulation(scenario(am.InitialBelief(kind="nothing"), estimator))


def test_a_runner_draws_the_start_of_the_simulation_and_none_for_a_real_robot():
    given = scenario(am.InitialBelief(kind="gaussian", std=0.2))
    sim = am.Simulation(given, replicas=[3])
    robot = given.robots[0]
    reading = sim.frames()[0].readings["encoder"][1].measured[0]
    runner = am.EstimatorRunner(robot, "wheels", seed=sim.seed, replica=3)
    assert runner.update(0.0, {"encoder": reading}).pose.tobytes() == sim.estimated_pose[0].tobytes()
    real = am.EstimatorRunner(robot, "wheels").update(0.0, {"encoder": reading})
    assert real.pose.tolist() == [2.8, 3.0, 0.0]
    np.testing.assert_allclose(np.diag(real.covariance), [0.04, 0.04, 0.0])


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"kind": "gaussian", "covariance": (1.0, 2.0, 0.0, 1.0, 0.0, 1.0)}, "positive covariance.*eigenvalue is -1"),
        ({"kind": "gaussian", "covariance": (-1.0, 0.0, 0.0, 1.0, 0.0, 1.0)}, "positive covariance"),
        ({"kind": "gaussian", "std": 0.1, "covariance": (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)}, "got both"),
        ({"kind": "exact", "std": 0.1}, "only with kind 'gaussian'"),
        ({"kind": "gaussian", "std": -0.1}, ">= 0"),
        ({"kind": "some"}, "'exact', 'gaussian'"),
    ],
)
def test_beliefs_that_are_none_are_refused(fields, problem):
    with pytest.raises(ParameterError, match=problem):
        am.InitialBelief(**fields)


def test_who_knows_nothing_needs_an_estimator():
    with pytest.raises(ParameterError, match="needs an estimator"):
        am.load_robot("pioneer2dx", estimators={}, initial_belief=am.InitialBelief(kind="nothing"))


@pytest.mark.parametrize(
    "belief",
    [
        am.InitialBelief(kind="nothing"),
        am.InitialBelief(kind="gaussian", std=0.25, heading_std=0.5),
        am.InitialBelief(kind="gaussian", covariance=(0.04, 0.01, 0.0, 0.09, 0.0, 0.01)),
    ],
)
def test_a_scenario_is_written_with_it(belief):
    table = resolved_table(attrs.evolve(scenario(belief), resolved=None))
    again = read(table_text(table))
    assert again.robots[0].initial_belief == belief


def test_a_file_says_what_a_robot_knows():
    robot = read(FILE + "initial_belief = { kind = 'gaussian', std = 0.3, heading_std_deg = 10.0 }\n").robots[0]
    assert robot.initial_belief == am.InitialBelief(kind="gaussian", std=0.3, heading_std=np.radians(10.0))
    with pytest.raises(am.ScenarioError, match=r"initial_belief\.kind"):
        read(FILE + "initial_belief = { kind = 'none' }\n")
    with pytest.raises(am.ScenarioError, match=r"initial_belief\.covariance.*positive"):
        read(FILE + "initial_belief = { kind = 'gaussian', covariance = [1, 2, 0, 1, 0, 1] }\n")
