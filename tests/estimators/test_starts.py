"""What estimators make of what the robot knows of its start."""

from __future__ import annotations

import attrs
import numpy as np
import pytest

import amorsim as am
from tests.estimators import slam_rig

AREA = {"width": 8.0, "height": 8.0, "resolution": 0.1}
NOTHING = am.InitialBelief(kind="nothing")
MAKERS = {
    "scan_matching": lambda: am.estimators.ScanMatching(wheel_variance=1e-6, range_std=0.01),
    "grid_mapping": lambda: am.estimators.GridMapping(wheel_variance=1e-6, **AREA),
    "grid_slam": lambda: am.estimators.GridSlam(wheel_variance=1e-6, range_std=0.01, particles=2, nodes=20, **AREA),
    "graph_slam": lambda: am.estimators.GraphSlam(wheel_variance=1e-6, range_std=0.01, nodes=50, **AREA),
}


def knowing(belief, **estimators):
    given = slam_rig.scenario(**estimators)
    return attrs.evolve(given, robots=[attrs.evolve(given.robots[0], initial_belief=belief)], dt=0.1)


@pytest.mark.parametrize("name", MAKERS)
def test_what_needs_a_start_says_so(name):
    with pytest.raises(am.ComponentError, match=f"{name} starts from a pose, but the robot knows nothing of its start"):
        am.Simulation(knowing(NOTHING, it=MAKERS[name]()))


def test_a_map_in_a_fixed_place_may_take_poses_from_what_finds_the_start():
    mapper = am.estimators.GridMapping(estimator="where", wheel_variance=0.0, center_x=3.0, center_y=2.0, **AREA)
    where = am.estimators.MonteCarlo(wheel_variance=1e-4, beams=12, particles_min=50, particles_max=500)
    given = knowing(NOTHING, where=where, map=mapper)
    robot = attrs.evolve(given.robots[0], knowledge=am.Knowledge(map=given.map))
    sim = am.Simulation(attrs.evolve(given, robots=[robot]))
    sim.run(0.3)
    frame = sim.frames()[0]
    assert frame.estimates["map"].pose.tobytes() == frame.estimates["where"].pose.tobytes()
    assert np.isfinite(frame.beliefs["map"]["occupancy"]).any()


@pytest.mark.parametrize("name", MAKERS)
def test_doubt_about_the_start_stays_in_the_covariance(name):
    """An error of the first heading moves the estimate across the way that it has gone."""
    belief = am.InitialBelief(kind="gaussian", std=0.2, heading_std=0.1)
    sim = am.Simulation(knowing(belief, it=MAKERS[name]()), replicas=2)
    start = sim.estimated_pose.copy()
    assert np.diagonal(sim.covariance[0]) == pytest.approx((0.04, 0.04, 0.01), abs=1e-5)
    sim.run(3.0)
    way = sim.estimated_pose - start
    assert np.hypot(way[:, 0], way[:, 1]).min() > 0.3
    first = np.diag((0.04, 0.04, 0.01))
    for row in range(2):
        moves = np.array([[1.0, 0.0, -way[row, 1]], [0.0, 1.0, way[row, 0]], [0.0, 0.0, 1.0]])
        # What wheels and scans add on this way is far smaller.
        np.testing.assert_allclose(sim.covariance[row], moves @ first @ moves.T, atol=2e-4)
