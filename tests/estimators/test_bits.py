"""Every estimator gives the same bits in the simulation, without it, alone, and among other replicas."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest

import amorsim as am
from amorsim.plugins.manager import make_registry
from tests.estimators import slam_rig

AREA = {"width": 8.0, "height": 8.0, "resolution": 0.1}
SCANS = {"wheel_variance": 1e-4, "range_std": 0.01, "match_distance": 0.05}
MARKS = ((0.5, 0.5), (4.0, 0.6), (4.0, 3.0), (0.6, 3.0))
SIGHTED = {"landmarks": "fiducial", "range_std": 0.05, "bearing_std": 0.02}
MAKERS = {
    "dead_reckoning": lambda: am.estimators.DeadReckoning(),
    "ekf": lambda: am.estimators.Ekf(wheel_variance=1e-4, **SIGHTED),
    "ukf": lambda: am.estimators.Ukf(wheel_variance=1e-4, **SIGHTED),
    "monte_carlo": lambda: am.estimators.MonteCarlo(
        wheel_variance=1e-4, beams=12, particles_min=50, particles_max=300, update_distance=0.05
    ),
    "scan_matching": lambda: am.estimators.ScanMatching(**SCANS),
    "grid_mapping": lambda: am.estimators.GridMapping(wheel_variance=1e-4, **AREA),
    "grid_slam": lambda: am.estimators.GridSlam(particles=3, nodes=20, **SCANS, **AREA),
    "graph_slam": lambda: am.estimators.GraphSlam(nodes=50, **SCANS, **AREA),
}
STEPS = 15


def scenario(name):
    """A robot with laser and landmarks whose start is known with some doubt."""
    given = slam_rig.scenario(it=MAKERS[name](), beams=61)
    robot = given.robots[0]
    fiducial = am.MountedSensor(sensor=am.sensors.Fiducial(slots=4, fov=2.0 * math.pi))
    robot = attrs.evolve(
        robot,
        sensors={**robot.sensors, "fiducial": fiducial},
        initial_belief=am.InitialBelief(kind="gaussian", std=0.05, heading_std=0.05),
        knowledge=am.Knowledge(map=given.map, landmarks=MARKS, landmark_ids=(1, 2, 3, 4)),
    )
    landmarks = [am.Landmark(x=x, y=y, id=i + 1) for i, (x, y) in enumerate(MARKS)]
    return attrs.evolve(given, robots=[robot], landmarks=landmarks, dt=0.1)


def test_none_is_missing():
    assert set(MAKERS) == set(make_registry(entry_points=()).names("estimator"))


@pytest.mark.parametrize("name", MAKERS)
def test_a_runner_gives_the_bits_of_the_simulation(name):
    sim = am.Simulation(scenario(name), seed=5, replicas=[2])
    runner = am.EstimatorRunner(sim.scenario.robots[0], "it", dt=sim.dt, seed=5, replica=2)
    for step in range(STEPS):
        if step:
            sim.step()
        frame = sim.frames()[0]
        readings = {name: reading.measured[0] for name, (_, reading) in frame.readings.items()}
        estimate = runner.update(frame.time[0], readings, frame.command[0])
        assert estimate.pose.tobytes() == frame.estimates["it"].pose[0].tobytes()
        assert estimate.covariance.tobytes() == frame.estimates["it"].covariance[0].tobytes()
    found = frame.beliefs.get("it", {})
    beliefs = runner.beliefs if found else {}
    assert set(beliefs) == set(found)
    for belief, array in found.items():
        assert beliefs[belief].tobytes() == array[0].tobytes(), belief
    assert np.hypot(*(frame.true_pose[0, :2] - (1.0, 1.0))) > 0.3


@pytest.mark.parametrize("name", MAKERS)
def test_a_replica_has_the_same_bits_alone_and_among_others(name):
    many = am.Simulation(scenario(name), seed=5, replicas=4, threads=2)
    one = am.Simulation(scenario(name), seed=5, replicas=[2])
    for sim in (many, one):
        for _ in range(STEPS):
            sim.step()
    assert many.digest(2) == one.digest(2)
    frame, alone = many.frames()[0], one.frames()[0]
    assert frame.estimates["it"].covariance[2].tobytes() == alone.estimates["it"].covariance[0].tobytes()
    for belief, array in alone.beliefs.get("it", {}).items():
        assert array[0].tobytes() == frame.beliefs["it"][belief][2].tobytes(), belief


@pytest.mark.long
@pytest.mark.parametrize("name", MAKERS)
def test_a_replica_has_the_same_bits_alone_and_among_a_thousand(name):
    many = am.Simulation(scenario(name), seed=5, replicas=1000, threads=2)
    one = am.Simulation(scenario(name), seed=5, replicas=[700])
    for sim in (many, one):
        for _ in range(8):
            sim.step()
    assert many.digest(700) == one.digest(700)
    frame, alone = many.frames()[0], one.frames()[0]
    assert frame.estimates["it"].covariance[700].tobytes() == alone.estimates["it"].covariance[0].tobytes()
    for belief, array in alone.beliefs.get("it", {}).items():
        assert array[0].tobytes() == frame.beliefs["it"][belief][700].tobytes(), belief
