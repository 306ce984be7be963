"""Pose graphs solved: known optima of real ones, and small ones by hand."""

import math
import time
from pathlib import Path

import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.pose_graph import PoseGraph, chi2_of, covariance_of, linear_start, optimize, read_g2o

GRAPHS = Path(__file__).resolve().parents[4] / "shared" / "maps" / "g2o"
REAL = {"intel": (45.004696, 4, 551.735731), "MIT": (41.163269, 6, None)}


def real(name):
    path = GRAPHS / f"{name}.g2o"
    if not path.is_file():
        pytest.skip("the real graphs are not here")
    return read_g2o(path)


def ring(count=24, radius=5.0, noise=0.0, seed=1):
    """Poses on a circle, each seen from the one before, and the first from the last; what was measured is noisy."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * math.pi / count
    side = 2.0 * radius * math.sin(0.5 * angle)
    step = np.array([side * math.cos(0.5 * angle), side * math.sin(0.5 * angle), angle])
    measured = step + noise * rng.normal(size=(count, 3))
    edges = [(i, (i + 1) % count) for i in range(count)]
    true = np.zeros((count, 3))
    for i in range(1, count):
        true[i] = am.compose(true[i - 1 : i], step[None])[0]
    return PoseGraph.of(np.zeros((count, 3)), edges, measured, [np.diag((100.0, 100.0, 400.0))] * count), true


@pytest.mark.parametrize("name", REAL)
def test_real_graphs_reach_their_known_optimum(name):
    graph = real(name)
    optimize(graph)  # imports scipy
    begun = time.process_time()
    found = optimize(graph)
    taken = time.process_time() - begun
    chi2, iterations, stored = REAL[name]
    assert found.chi2 == pytest.approx(chi2, rel=1e-7)
    assert found.chi2 == pytest.approx(chi2_of(graph, found.poses), rel=1e-12)
    assert found.iterations <= iterations
    assert taken < 2.0
    np.testing.assert_array_equal(found.poses[0], graph.poses[0])
    if stored is not None:
        assert chi2_of(graph) == pytest.approx(stored, abs=1e-6)


def test_from_odometry_alone_one_of_them_stays_in_a_local_minimum():
    graph = real("MIT")
    poses = graph.poses.copy()
    for (i, j), measured in zip(graph.edges.tolist(), graph.measurements, strict=True):
        if j == i + 1:
            poses[j] = am.compose(poses[i : i + 1], measured[None])[0]
    odometry = PoseGraph.of(poses, graph.edges, graph.measurements, graph.information)
    assert optimize(odometry, start="poses").chi2 > 700.0
    assert optimize(odometry).chi2 == pytest.approx(41.163269, rel=1e-7)


def test_without_noise_a_ring_is_found_from_nothing():
    graph, true = ring()
    found = optimize(graph)
    np.testing.assert_allclose(found.poses[:, :2], true[:, :2], atol=1e-9)
    np.testing.assert_allclose(am.wrap_angle(found.poses[:, 2] - true[:, 2]), 0.0, atol=1e-9)
    assert found.chi2 < 1e-18
    np.testing.assert_allclose(linear_start(graph)[:, :2], true[:, :2], atol=1e-9)


def test_at_the_optimum_no_pose_can_be_moved_to_a_smaller_chi2():
    graph, _ = ring(noise=0.1)
    found = optimize(graph, tolerance=1e-15)
    for i in range(1, len(found.poses)):
        for j in range(3):
            slope = 0.0
            for sign in (1.0, -1.0):
                poses = found.poses.copy()
                poses[i, j] += sign * 1e-5
                slope += sign * chi2_of(graph, poses) / 2e-5
            assert abs(slope) < 1e-4


@pytest.mark.long
def test_the_expected_chi2_is_the_number_of_redundant_measurements():
    # Each of 200 rings has 3 numbers more than it needs; its chi2 is that of 3 degrees of freedom.
    chi2 = []
    for seed in range(200):
        graph, _ = ring(count=12, seed=seed)
        rng = np.random.default_rng(seed)
        noise = rng.normal(size=(12, 3)) / np.sqrt((100.0, 100.0, 400.0)) * 0.1
        graph = PoseGraph.of(graph.poses, graph.edges, graph.measurements + noise, graph.information * 100.0)
        chi2.append(optimize(graph).chi2)
    assert 2.463 < np.mean(chi2) < 3.603  # 99.9 % of such means


def test_two_poses_are_what_was_measured():
    graph = PoseGraph.of([[1.0, 2.0, 0.5], [0, 0, 0]], [[0, 1]], [[2.0, 0.0, 3.0]], [np.eye(3)])
    found = optimize(graph)
    wanted = am.compose(graph.poses[:1], graph.measurements)[0]
    np.testing.assert_allclose(found.poses[1], wanted, atol=1e-12)


def test_a_single_pose_stays():
    graph = PoseGraph.of([[1.0, 2.0, 0.5]], [], [], np.zeros((0, 3, 3)))
    np.testing.assert_array_equal(optimize(graph).poses, graph.poses)


def test_a_graph_in_parts_is_refused():
    graph = PoseGraph.of(np.zeros((3, 3)), [[0, 1]], [[1.0, 0, 0]], [np.eye(3)], ids=[4, 5, 6])
    with pytest.raises(am.GraphError, match="2 parts: no edges lead from pose 4 to pose 6"):
        optimize(graph)


def test_edges_that_tell_nothing_are_refused():
    graph = PoseGraph.of(np.zeros((2, 3)), [[0, 1]], [[1.0, 0, 0]], [np.diag((1.0, 1.0, 0.0))])
    with pytest.raises(am.GraphError, match="do not determine the poses"):
        optimize(graph)


def test_an_unknown_start_is_refused():
    with pytest.raises(am.GraphError, match="expected 'linear' or 'poses', got 'odometry'"):
        optimize(ring()[0], start="odometry")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"poses": [[0, 0, np.nan], [0, 0, 0]]}, "poses: number 0 is .*finite"),
        ({"poses": np.zeros((0, 3))}, "at least one pose"),
        ({"edges": [[0, 2]]}, "edge 0 leads from pose 0 to 2"),
        ({"edges": [[1, 1]]}, "edge 0 leads from pose 1 to 1"),
        ({"edges": [[0, 1], [0, 1]]}, "a measurement for each of 2 edges, got 1"),
        ({"measurements": [[1.0, 2.0]]}, "measurements: expected numbers of shape"),
        ({"information": [np.diag((1.0, 1.0, -1.0))]}, "without negative eigenvalues"),
        ({"information": [[[1.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]]}, "symmetric"),
        ({"ids": [3, 3]}, "two poses have the id 3"),
        ({"ids": [3]}, "an id for each of 2 poses, got 1"),
    ],
)
def test_what_is_no_graph_is_refused(changes, message):
    good = {"poses": np.zeros((2, 3)), "edges": [[0, 1]], "measurements": np.zeros((1, 3)), "information": [np.eye(3)]}
    PoseGraph.of(**good)
    with pytest.raises(am.GraphError, match=message):
        PoseGraph.of(**(good | changes))


def test_the_covariance_of_a_chain_adds_up():
    # Straight ahead, an error of the heading moves all that follows sideways.
    step = np.diag((0.01, 0.02, 0.003))
    graph = PoseGraph.of(np.zeros((3, 3)), [[0, 1], [1, 2]], [[2.0, 0, 0]] * 2, [np.linalg.inv(step)] * 2)
    poses = optimize(graph).poses
    np.testing.assert_allclose(covariance_of(graph, poses, 1), step, atol=1e-12)
    swing = np.array([[1.0, 0, 0], [0, 1, 2.0], [0, 0, 1]])
    np.testing.assert_allclose(covariance_of(graph, poses, 2), swing @ step @ swing.T + step, atol=1e-12)
    np.testing.assert_array_equal(covariance_of(graph, poses, 0), np.zeros((3, 3)))


def test_a_closed_loop_makes_the_last_pose_surer():
    graph, _ = ring()
    chain = PoseGraph.of(graph.poses, graph.edges[:-1], graph.measurements[:-1], graph.information[:-1])
    poses = optimize(graph).poses
    last = len(poses) - 1
    assert np.trace(covariance_of(graph, poses, last)) < 0.2 * np.trace(covariance_of(chain, poses, last))
