"""The graph in an estimator's state: which loops close at once, which wait, and which are never believed."""

import numpy as np
import pytest

import amorsim as am
from amorsim.estimators.node_graph import NodeGraph, empty_nodes, loops_of

INFORMATION = np.diag((1e4, 1e4, 1e4))


def line_of_nodes(count=30):
    """A graph of nodes 1 m apart, each linked to the one before, with the robot at the last."""
    state = empty_nodes(1, count, 1)
    state |= {name: np.zeros((1, 3)) for name in ("pose", "key_pose", "last", "scan_pose")}
    state |= {name: np.zeros((1, 3, 3)) for name in ("spread", "key_covariance")}
    graph = NodeGraph(state, 0)
    for n in range(count - 5):
        go_on(state, graph, n)
    return state, graph


def go_on(state, graph, n):
    state["pose"][0] = n, 0.0, 0.0
    assert graph.grow(np.zeros(1))
    state["key_pose"][0] = state["pose"][0]


def close(graph, first, off):
    """Let a match of the newest node say that it is `off` (3,) from where it is thought to be."""
    place = graph.poses[-1] + np.array(off)
    return graph.close(first, am.relative(graph.poses[first][None], place[None])[0], INFORMATION)


def test_a_loop_that_moves_the_robot_little_closes_at_once():
    state, graph = line_of_nodes()
    assert close(graph, 2, (0.2, 0.1, 0.05))
    assert loops_of(state).tolist() == [1]


def test_a_loop_that_moves_it_far_waits_until_another_agrees():
    state, graph = line_of_nodes()
    assert not close(graph, 2, (1.0, -0.5, 0.0))
    assert loops_of(state).tolist() == [0]
    go_on(state, graph, graph.count)
    assert close(graph, 3, (1.1, -0.6, 0.02))
    assert loops_of(state).tolist() == [2]
    assert graph.solve()
    assert graph.poses[-1, :2] == pytest.approx((graph.count - 1 + 1.05, -0.55), abs=0.1)


@pytest.mark.parametrize("second", [(1.8, -0.5, 0.0), (1.0, -0.5, 0.15), (-1.0, 0.5, 0.0)])
def test_loops_that_contradict_each_other_are_not_believed(second):
    state, graph = line_of_nodes()
    assert not close(graph, 2, (1.0, -0.5, 0.0))
    go_on(state, graph, graph.count)
    assert not close(graph, 3, second)
    assert loops_of(state).tolist() == [0]


def test_a_loop_does_not_wait_for_ever():
    state, graph = line_of_nodes(45)
    assert not close(graph, 2, (1.0, -0.5, 0.0))
    state["pending_nodes"][0, :, 1] -= 13  # as if so many nodes had come since
    go_on(state, graph, graph.count)
    assert not close(graph, 3, (1.0, -0.5, 0.0))
    assert loops_of(state).tolist() == [0]
