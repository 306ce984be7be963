"""The graph in an estimator's state: which loops close at once, which wait, and which are never believed."""

import math

import numpy as np
import pytest

import amorsim as am
from amorsim.algorithms.pose_graph import PoseGraph
from amorsim.algorithms.pose_graph.robust import RobustOptimum
from amorsim.estimators.node_graph import NodeGraph, _as_sure_as_it_fits, empty_nodes, loops_of

INFORMATION = np.diag((1e4, 1e4, 1e4))


def line_of_nodes(count=30):
    """A graph of nodes 1 m apart, each linked to the one before, with the robot at the last."""
    state = empty_nodes(1, count, 1)
    state |= {name: np.zeros((1, 3)) for name in ("pose", "key_pose", "last", "scan_pose")}
    state |= {name: np.zeros((1, 3, 3)) for name in ("spread", "key_covariance", "cross")}
    state["link"] = np.zeros((1, 4, 3))
    graph = NodeGraph(state, 0)
    for n in range(count - 5):
        go_on(state, graph, n)
    return state, graph


def go_on(state, graph, n):
    before = state["key_pose"].copy()
    state["pose"][0] = state["key_pose"][0] = n, 0.0, 0.0
    state["link"][0, 0] = am.relative(before, state["key_pose"])[0]
    assert graph.grow(np.zeros(1))


def close(graph, first, off):
    """Let a match of the newest node say that it is `off` (3,) from where it is thought to be."""
    place = graph.poses[-1] + np.array(off)
    return graph.close(first, graph.count - 1, am.relative(graph.poses[first][None], place[None])[0], INFORMATION)


def test_loops_that_are_not_believed_make_a_graph_no_surer():
    """Edges of 15 mm that disagree by 9.5 mm, and as many wrong loops, which weigh nothing."""
    n, rng = 60, np.random.default_rng(3)
    std = np.array([0.01, 0.01, 0.004]) + 0.005
    poses = np.stack((np.arange(n, dtype=float), np.zeros(n), np.zeros(n)), axis=1)
    pairs = np.array([(i, i + 1) for i in range(n - 1)] + [(i, i + 2) for i in range(n - 2)])
    steps = am.relative(poses[pairs[:, 0]], poses[pairs[:, 1]]) + rng.normal(0.0, 0.0095, (len(pairs), 3)) * [1, 1, 0.4]
    right = PoseGraph.of(poses, pairs, steps, np.repeat(np.diag(std**-2)[None], len(pairs), axis=0))
    wrong = np.array([(i, n - 1 - i) for i in range(20)] * 3)
    both = PoseGraph.of(
        poses,
        np.concatenate((pairs, wrong)),
        np.concatenate((steps, am.relative(poses[wrong[:, 0]], poses[wrong[:, 1]]) + 5.0)),
        np.repeat(np.diag(std**-2)[None], len(pairs) + len(wrong), axis=0),
    )
    alone = _as_sure_as_it_fits(right, RobustOptimum(poses, np.ones(len(pairs)), 0.0))
    weights = np.concatenate((np.ones(len(pairs)), np.full(len(wrong), 1e-9)))
    among = _as_sure_as_it_fits(both, RobustOptimum(poses, weights, 0.0))
    assert 1.01 < alone.information[0, 0, 0] / right.information[0, 0, 0] < 3.0  # neither the least share nor all
    np.testing.assert_array_equal(among.information[0], alone.information[0])


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


def test_loops_of_nodes_far_apart_do_not_confirm_each_other():
    state, graph = line_of_nodes(45)
    assert not close(graph, 2, (1.0, -0.5, 0.0))
    for _ in range(4):
        go_on(state, graph, graph.count)
    state["pending_nodes"][0, 0, 1] -= 9  # 13 before the newest
    assert not close(graph, 3, (1.0, -0.5, 0.0))
    assert loops_of(state).tolist() == [0]


def test_the_motions_between_two_nodes_tell_how_far_a_loop_may_be_off():
    """Against the composed motions: 10 steps of 1 m, each off by 1 cm and 0.004 rad, add up as steps on a lever."""
    _, graph = line_of_nodes()
    far, turned = graph.window_between(5, 15)
    across = math.hypot(0.01 * math.sqrt(10), 0.004 * math.sqrt(sum(n**2 for n in range(10))))
    assert far == pytest.approx(5.0 * across, rel=1e-6)
    assert turned == pytest.approx(5.0 * 0.004 * math.sqrt(10), rel=1e-6)


def test_an_old_node_is_looked_at_again_when_it_has_moved():
    """Nodes 24 to 12 go back beside 0 to 12: the newest is looked at each time, each older one once."""
    state, graph = line_of_nodes(30)
    state["node_pose"][0, 13:25, 0] = 24.0 - np.arange(13, 25)
    seen = [pair for _ in range(30) for pair in graph.nodes_to_look_at(5, 1.0)]
    assert seen.count((0, 24)) == 30
    older = [pair for pair in seen if pair[1] != 24]
    assert len(older) == len(set(older)) > 5
    state["node_pose"][0, 20, 1] += 0.5
    again = [pair for _ in range(5) for pair in graph.nodes_to_look_at(5, 1.0) if pair[1] != 24]
    assert again == [(4, 20)]
