"""A pose graph from scans, with loops closed."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators import DeadReckoning, GraphSlam, ScanMatching
from amorsim.testing import check_component
from tests.estimators.slam_rig import errors_of, scenario

SMALL = {"wheel_variance": 1e-3, "range_std": 0.01, "resolution": 0.1, "width": 9.0, "height": 7.0}
# For many rows: small windows.
FEW = {"window": 0.05, "window_angle": 0.04, "loop_window": 0.1, "loop_window_angle": 0.1, "nodes": 12}


def slam(**changes):
    few = {"key_distance": 0.4, "key_angle": math.radians(40.0), "loop_gap": 6, "loop_window": 0.5, "nodes": 80}
    return GraphSlam(**(SMALL | few | changes))


@pytest.mark.long
def test_it_keeps_the_contract():
    check_component(slam(match_distance=0.0, match_angle=0.0, key_distance=0.02, loop_gap=2, **FEW))


@pytest.mark.long
def test_it_closes_loops_and_maps_the_room():
    sim = am.Simulation(scenario(slam=slam(), wheels=DeadReckoning()))
    off = errors_of(sim, 40.0)
    beliefs = sim.frames()[0].beliefs["slam"]
    assert beliefs["graph_loops"][0] >= 2
    assert off["slam"].max() < 0.05
    assert off["slam"][-1, 0] < off["wheels"][-1, 0] / 10.0
    found = am.estimated_map(beliefs)
    cells, unknown = found.to_array(), found.unknown_array()
    known = np.isfinite(beliefs["occupancy"][0])
    assert known.sum() > 0.9 * 6.0 * 4.0 / 0.01
    rows, cols = np.nonzero(cells)
    centres = np.stack((cols + 0.5, rows + 0.5), axis=1) * 0.1 + found.origin[:2]
    outside = ((centres < -0.1) | (centres > (6.1, 4.1))).any(axis=1)
    assert outside.mean() < 0.02
    assert unknown[~known].all()


def test_its_graph_is_one_that_can_be_solved():
    sim = am.Simulation(scenario(slam=slam()))
    sim.run(15.0)
    beliefs = sim.frames()[0].beliefs["slam"]
    count = int(np.isfinite(beliefs["graph_poses"][0, :, 0]).sum())
    edges = beliefs["graph_edges"][0]
    edges = edges[edges[:, 0] >= 0]
    assert count > 6
    assert len(edges) >= count - 1
    assert edges.max() == count - 1
    assert np.isnan(beliefs["graph_poses"][0, count:]).all()


def test_with_no_room_for_nodes_it_goes_on_as_scan_matching():
    given = {"wheel_variance": 1e-3, "range_std": 0.01, "key_distance": 0.4, "key_angle": math.radians(40.0)}
    sim = am.Simulation(scenario(slam=slam(nodes=3), matched=ScanMatching(**given)))
    sim.run(10.0)
    frame = sim.frames()[0]
    assert np.isfinite(frame.beliefs["slam"]["graph_poses"][0]).all()
    np.testing.assert_array_equal(frame.estimates["slam"].pose, frame.estimates["matched"].pose)


def test_a_replica_alone_and_among_others_has_the_same_bits():
    given = scenario(slam=slam())
    many, one = am.Simulation(given, replicas=3), am.Simulation(given, replicas=[1])
    for sim in (many, one):
        sim.run(16.0)
    every, alone = many.frames()[0], one.frames()[0]
    assert every.estimates["slam"].pose[1:2].tobytes() == alone.estimates["slam"].pose.tobytes()
    for name, array in alone.beliefs["slam"].items():
        assert array.tobytes() == every.beliefs["slam"][name][1:2].tobytes(), name


@pytest.mark.long
def test_round_the_office_matching_is_five_times_and_the_graph_twenty_times_as_near_as_the_wheels():
    scenario = am.load("loop")
    sim = am.Simulation(scenario)
    off = errors_of(sim, scenario.duration)
    rmse = {name: float(np.sqrt(np.mean(values**2))) for name, values in off.items()}
    assert not sim.events
    assert rmse["wheels"] > 5.0 * rmse["matched"]
    assert rmse["wheels"] > 20.0 * rmse["graph"]
