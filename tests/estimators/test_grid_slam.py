"""Particles with a path each."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators import DeadReckoning, GridSlam
from amorsim.kernels.matching.particles import Particles, resample
from amorsim.testing import check_component
from tests.estimators.slam_rig import errors_of, scenario

SMALL = {"wheel_variance": 1e-3, "range_std": 0.01, "resolution": 0.1, "width": 9.0, "height": 7.0, "nodes": 60}


def slam(**changes):
    return GridSlam(**(SMALL | {"particles": 8, "match_distance": 0.2, "node_distance": 0.4} | changes))


@pytest.mark.long
def test_it_keeps_the_contract():
    check_component(slam(match_distance=1e-3, match_angle=1e-3, node_distance=0.0, particles=4, nodes=6))


def test_it_follows_the_robot_and_maps_the_room():
    sim = am.Simulation(scenario(slam=slam(), wheels=DeadReckoning()))
    off = errors_of(sim, 40.0)
    beliefs = sim.frames()[0].beliefs["slam"]
    assert off["slam"].max() < 0.08
    assert off["slam"][-1, 0] < off["wheels"][-1, 0] / 5.0
    assert beliefs["weights"].sum() == pytest.approx(1.0)
    assert 1.0 <= beliefs["effective_particles"][0] <= 8.0 + 1e-9
    found = am.estimated_map(beliefs)
    rows, cols = np.nonzero(found.to_array())
    centres = np.stack((cols + 0.5, rows + 0.5), axis=1) * 0.1 + found.origin[:2]
    assert len(centres) > 120
    assert ((centres < -0.1) | (centres > (6.1, 4.1))).any(axis=1).mean() < 0.02


def test_the_same_run_again_has_the_same_bits_and_another_seed_has_not():
    maps = []
    for seed in (4, 4, 5):
        sim = am.Simulation(scenario(slam=slam()), seed=seed)
        sim.run(6.0)
        maps.append(sim.frames()[0].beliefs["slam"])
    for name, array in maps[0].items():
        assert array.tobytes() == maps[1][name].tobytes(), name
    assert maps[0]["particles"].tobytes() != maps[2]["particles"].tobytes()


def test_a_replica_alone_and_among_others_has_the_same_bits():
    given = scenario(slam=slam())
    many, one = am.Simulation(given, replicas=3), am.Simulation(given, replicas=[1])
    for sim in (many, one):
        sim.run(5.0)
    every, alone = many.frames()[0], one.frames()[0]
    assert every.estimates["slam"].pose[1:2].tobytes() == alone.estimates["slam"].pose.tobytes()
    assert every.estimates["slam"].covariance[1:2].tobytes() == alone.estimates["slam"].covariance.tobytes()
    for name, array in alone.beliefs["slam"].items():
        assert array.tobytes() == every.beliefs["slam"][name][1:2].tobytes(), name


def particles_of(weights):
    count = len(weights)
    pose = np.zeros((1, count, 3))
    pose[0, :, 0] = np.arange(count)
    path = np.repeat(pose[:, :, None], 2, axis=2)
    drift, node_drift = np.zeros((1, 3, 3)), np.zeros((1, 2, 3, 3))
    return Particles(pose, np.log(np.array([weights], dtype=float)), path, np.array([2]), drift, node_drift)


def drawn(weights, share, mark):
    found = particles_of(weights)
    count = len(weights)
    room = np.empty((count, 3)), np.empty((count, 2, 3))
    resample(found, np.ones((1, 1), dtype=bool), share, np.array([[mark]]), *room)
    return found


@pytest.mark.parametrize("mark", [0.01, 0.37, 0.5, 0.99])
def test_systematic_resampling_keeps_each_as_often_as_its_weight_says(mark):
    weights = np.array([0.1, 0.5, 0.0, 0.3, 0.1])
    found = drawn(weights + 1e-300, 1.0, mark)
    counts = np.bincount(found.pose[0, :, 0].astype(int), minlength=5)
    assert (np.abs(counts - 5.0 * weights) < 1.0).all()
    np.testing.assert_array_equal(found.path[0, :, 1], found.pose[0])
    np.testing.assert_allclose(np.exp(found.weight), 0.2)


def test_particles_of_equal_weight_are_kept():
    found = drawn([0.5, 0.5, 0.5, 0.5], 0.5, 0.3)
    np.testing.assert_array_equal(found.pose[0, :, 0], np.arange(4))
    np.testing.assert_allclose(np.exp(found.weight), 0.25)


def test_effective_number_decides():
    # Weights 1, 0.5 and 0.5: 2.667 of 3 are effective.
    assert drawn([1.0, 0.5, 0.5], 0.88, 0.3).pose[0, :, 0].tolist() == [0.0, 1.0, 2.0]
    assert math.isclose(np.exp(drawn([1.0, 0.5, 0.5], 0.88, 0.3).weight[0, 0]), 0.5)
    assert math.isclose(np.exp(drawn([1.0, 0.5, 0.5], 0.9, 0.3).weight[0, 0]), 1.0 / 3.0)
