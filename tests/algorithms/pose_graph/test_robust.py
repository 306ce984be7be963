"""Pose graphs with wrong edges: they are weighed down, and the poses are those of the graph without them."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.pose_graph import PoseGraph, optimize, optimize_robustly

INFORMATION = np.diag((100.0, 100.0, 400.0))


def two_rounds(wrong, noise=0.05, seed=1, count=24):
    """Two rounds on a circle: each pose seen from the one before, and from the first round; some wrongly."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * math.pi / count
    side = 10.0 * math.sin(0.5 * angle)
    step = np.array([side * math.cos(0.5 * angle), side * math.sin(0.5 * angle), angle])
    true = np.zeros((2 * count, 3))
    for i in range(1, 2 * count):
        true[i] = am.compose(true[i - 1 : i], step[None])[0]
    scale = noise * np.array([2.0, 2.0, 1.0])
    edges = [(i, i + 1) for i in range(2 * count - 1)] + [(i, i + count) for i in range(count)]
    pairs = np.array(edges)
    measured = am.relative(true[pairs[:, 0]], true[pairs[:, 1]]) + scale * rng.normal(size=(len(edges), 3))
    bad = 2 * count - 1 + rng.choice(count, wrong, replace=False)
    measured[bad] += rng.choice([-1.0, 1.0], (wrong, 3)) * rng.uniform(1.0, 3.0, (wrong, 3))
    poses = np.zeros((2 * count, 3))
    for i in range(1, 2 * count):
        poses[i] = am.compose(poses[i - 1 : i], measured[i - 1 : i])[0]
    return PoseGraph.of(poses, edges, measured, [INFORMATION] * len(edges)), true, bad


@pytest.mark.parametrize("seed", range(5))
def test_wrong_edges_do_not_bend_the_graph(seed):
    graph, true, bad = two_rounds(3, noise=0.03, seed=seed)
    found = optimize_robustly(graph)
    off = np.hypot(*(found.poses - true)[:, :2].T).max()
    plain = np.hypot(*(optimize(graph).poses - true)[:, :2].T).max()
    assert off < 0.7
    assert plain > 2.0 * off
    right = np.delete(found.weights, bad)
    assert found.weights[bad].max() < 0.3
    assert np.median(right) > 0.99
    assert ((found.weights > 0.0) & (found.weights <= 1.0)).all()


def test_without_wrong_edges_it_is_the_least_squares_optimum():
    graph, _, _ = two_rounds(0, noise=0.02)
    found, plain = optimize_robustly(graph), optimize(graph, start="poses")
    np.testing.assert_array_equal(found.weights, 1.0)
    np.testing.assert_allclose(found.poses, plain.poses, atol=1e-4)
    assert found.chi2 == pytest.approx(plain.chi2, rel=1e-6)


def test_weights_are_those_of_the_formula():
    """Between two poses alone with two edges, the errors can be told by hand."""
    graph = PoseGraph.of(
        [[0, 0, 0], [1, 0, 0]], [(0, 1), (0, 1), (0, 1)], [[1, 0, 0], [1, 0, 0], [9, 0, 0]], [INFORMATION] * 3
    )
    found = optimize_robustly(graph, scale=2.0)
    squares = 100.0 * (found.poses[1, 0] - np.array([1.0, 1.0, 9.0])) ** 2
    np.testing.assert_allclose(found.weights, np.minimum(1.0, 4.0 / (2.0 + squares)) ** 2, atol=2e-4)
    assert found.poses[1, 0] == pytest.approx(1.0, abs=0.01)
    assert found.chi2 == pytest.approx(float((found.weights * squares).sum()), rel=1e-9)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"weights": [1.0]}, "a positive number for each of 71 edges"),
        ({"weights": np.zeros(71)}, "a positive number for each of 71 edges"),
        ({"scale": 0.0}, "scale: expected a positive number, got 0"),
        ({"scale": math.nan}, "scale: expected a positive number, got nan"),
    ],
)
def test_wrong_arguments_are_refused(given, words):
    graph, _, _ = two_rounds(0)
    with pytest.raises(am.GraphError, match=words):
        optimize_robustly(graph, **given)
