"""The pose graph of one robot in an estimator's state: arrays of a fixed size over rows."""

from __future__ import annotations

import math
from collections.abc import Iterator

import attrs
import numpy as np

from amorsim.algorithms.pose_graph import PoseGraph, covariance_of, optimize_robustly
from amorsim.algorithms.pose_graph.robust import RobustOptimum, weighted
from amorsim.algorithms.pose_graph.solve import squared_errors
from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import State
from amorsim.core.errors import GraphError
from amorsim.core.poses import compose, relative, wrap_angle

__all__ = ["NodeGraph", "empty_nodes", "loops_of", "near_node"]


_STD = np.array([0.01, 0.01, 0.004])  # [m, m, rad] added to each edge: matches share errors that they do not know of
_SHARES = 0.5 ** np.arange(6, -1, -1)  # of the variance of _STD, least first, that edges may turn out to have
_ROUNDS = 3  # of weighing the edges in one step: the next loop goes on from there
_MATCH = ("measurement", "information")
_AGREE = (0.3, math.radians(5.0))  # [m, rad] up to which two places of a node are the same
_PENDING = 16  # loops that wait for others
_LOOKS = 20  # old nodes in a step, among which one is looked for that may close a loop
_RECENT = 12  # nodes that two loops may be apart to confirm each other
_PLAUSIBLE = 5.0  # standard deviations: matches, too, are wrong by more than they know
_ARM = 5.0  # [m] from a node, at which its scan's points are taken to be
_TURN = 1.0  # [m] by which a node that looks the other way counts as farther away: it sees other walls


def empty_nodes(rows: int, most: int, beams: int) -> State:
    """Graphs without a node, with room for a number of them and for twice as many edges."""
    return {
        "node_count": np.zeros(rows, np.int64),
        "node_pose": np.full((rows, most, 3), np.nan),
        "node_drawn": np.full((rows, most, 3), np.nan),
        "node_ranges": np.full((rows, most, beams), np.nan),
        "edge_count": np.zeros(rows, np.int64),
        "edge_nodes": np.full((rows, 2 * most, 2), -1, np.int64),
        "edge_measurement": np.full((rows, 2 * most, 3), np.nan),
        "edge_information": np.full((rows, 2 * most, 3, 3), np.nan),
        "edge_weight": np.ones((rows, 2 * most)),
        "node_looked_at": np.full(rows, -1, np.int64),
        "node_near": np.full((rows, most), -1, np.int64),
        "node_guess": np.full((rows, most, 3), np.nan),
        "pending_next": np.zeros(rows, np.int64),
        "pending_nodes": np.full((rows, _PENDING, 2), -1, np.int64),
        "pending_measurement": np.full((rows, _PENDING, 3), np.nan),
        "pending_information": np.full((rows, _PENDING, 3, 3), np.nan),
    }


def loops_of(state: State) -> Ints:
    """How many edges of each row's graph close a loop `(N,)`."""
    edges = state["edge_nodes"]
    return np.asarray(((edges[:, :, 1] - edges[:, :, 0]) > 1).sum(axis=1))


class NodeGraph:
    """The graph of one row of a state, and changes to it."""

    def __init__(self, state: State, row: int) -> None:
        self._state = state
        self._row = row

    @property
    def count(self) -> int:
        """How many nodes there are."""
        return int(self._state["node_count"][self._row])

    @property
    def poses(self) -> Array:
        """The nodes' poses (n, 3)."""
        return np.asarray(self._state["node_pose"][self._row, : self.count])

    def grow(self, ranges: Array) -> bool:
        """Add the row's new key as a node, linked to the one before; False if there is no more room."""
        state, row, count = self._state, self._row, self.count
        if count == state["node_pose"].shape[1]:
            return False
        state["node_pose"][row, count] = state["key_pose"][row]
        state["node_ranges"][row, count] = ranges
        state["node_count"][row] = count + 1
        if count:
            moved, spread = state["link"][row, 0], state["link"][row, 1:]
            self._link(count - 1, count, moved, spread)
        return True

    def nodes_to_look_at(self, gap: int, distance: float) -> Iterator[tuple[int, int]]:
        """The newest node, and perhaps an older one that closes no loop, each with the node to look for it at.

        The older ones are gone through in turn. One is looked at again when the graph has moved it, relative to the
        node that is nearest now.
        """
        state, row, newest = self._state, self._row, self.count - 1
        near = near_node(self, newest, gap, distance)
        if near is not None:
            yield near, newest
        edges = state["edge_nodes"][row, : int(state["edge_count"][row])]
        in_loop = set(edges[edges[:, 1] - edges[:, 0] > 1].ravel().tolist())
        for node in (int(state["node_looked_at"][row]) + np.arange(1, _LOOKS + 1)) % max(newest, 1):
            state["node_looked_at"][row] = node
            near = None if node in in_loop else near_node(self, int(node), gap, distance)
            if near is not None and not self._was_looked_at(near, int(node)):
                yield near, int(node)
                return

    def _was_looked_at(self, near: int, node: int) -> bool:
        """Whether a loop between two nodes was looked for where they are now; from now on it was."""
        before = self._state["node_guess"][self._row, node]
        guess = self.relative(near, np.array([node]))[0]
        is_old = self._state["node_near"][self._row, node] == near and _is_same(before, guess)
        if not is_old:
            self._state["node_near"][self._row, node] = near
            before[:] = guess
        return bool(is_old)

    def close(self, first: int, node: int, measured: Array, information: Array) -> bool:
        """Let a match of a node with an old one close a loop, or wait; whether the graph has a new edge.

        A loop that moves the node far is believed when another one, of a node near it, moves it to the same place: two
        that are consistent, after J. G. Mangelson et al., "Pairwise consistent measurement set maximization for robust
        multi-robot map merging" (2018).
        """
        state, row = self._state, self._row
        place = _from(self.poses[first], measured)
        nodes = state["pending_nodes"][row]
        agreeing: list[int] = []
        if not _is_same(place, self.poses[node]):
            for slot in np.flatnonzero((nodes[:, 0] >= 0) & (np.abs(nodes[:, 1] - node) <= _RECENT)).tolist():
                old, then = nodes[slot].tolist()
                there = _from(self.poses[old], state["pending_measurement"][row, slot])
                if then != node and _is_same(_from(there, self.relative(then, np.array([node]))[0]), place):
                    agreeing.append(slot)
            if not agreeing:
                slot = int(state["pending_next"][row])
                state["pending_next"][row] = (slot + 1) % _PENDING
                nodes[slot] = first, node
                state["pending_measurement"][row, slot] = measured
                state["pending_information"][row, slot] = information
                return False
        for slot in agreeing:
            self._close(*nodes[slot].tolist(), *(state[f"pending_{name}"][row, slot] for name in _MATCH))
            nodes[slot] = -1
        return self._close(first, node, measured, information)

    def window_between(self, first: int, node: int) -> tuple[float, float]:
        """How far [m, rad] from where a node seems to be, seen from an earlier one, it can be by the motions alone."""
        spread = self._spread_between(first, node)
        largest = float(np.linalg.eigvalsh(spread[:2, :2])[-1])
        return _PLAUSIBLE * math.sqrt(largest), _PLAUSIBLE * math.sqrt(spread[2, 2])

    def _spread_between(self, first: int, node: int) -> Array:
        """The covariance (3, 3) of a node in the frame of an earlier one, by the motions alone, in its own frame."""
        state, row = self._state, self._row
        steps = np.flatnonzero(_is_motion(state["edge_nodes"][row], first, node))
        ends = self.poses[state["edge_nodes"][row, steps, 1]]
        to_end = relative(ends, np.repeat(self.poses[node : node + 1], len(ends), axis=0))
        c, s = np.cos(to_end[:, 2]), np.sin(to_end[:, 2])
        # What an error at the end of a step, in its frame, does to the node in the node's frame.
        effect = np.zeros((len(steps), 3, 3))
        effect[:, 0, 0], effect[:, 0, 1] = c, s
        effect[:, 1, 0], effect[:, 1, 1] = -s, c
        effect[:, 2, 2] = 1.0
        effect[:, 0, 2] = -c * to_end[:, 1] + s * to_end[:, 0]
        effect[:, 1, 2] = s * to_end[:, 1] + c * to_end[:, 0]
        spread = np.linalg.inv(state["edge_information"][row, steps])
        return np.asarray((effect @ spread @ effect.transpose(0, 2, 1)).sum(axis=0))

    def _close(self, first: int, second: int, measured: Array, information: Array) -> bool:
        """Add an edge that closes a loop; False if there is no more room."""
        if int(self._state["edge_count"][self._row]) == self._state["edge_nodes"].shape[1]:
            return False
        covariance = np.linalg.inv(information).astype(np.float64)
        self._link(first, second, measured, covariance)
        return True

    def _link(self, first: int, second: int, measured: Array, covariance: Array) -> None:
        state, row = self._state, self._row
        place = int(state["edge_count"][row])
        # A match measures in the frame of the first node; an edge has its errors in that of the measured pose.
        c, s = np.cos(measured[2]), np.sin(measured[2])
        turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        information = np.linalg.inv(turn @ covariance @ turn.T + np.diag(_STD**2))
        state["edge_nodes"][row, place] = first, second
        state["edge_measurement"][row, place] = measured
        state["edge_information"][row, place] = 0.5 * (information + information.T)
        state["edge_count"][row] = place + 1

    def relative(self, first: int, others: Ints) -> Array:
        """The poses (n, 3) of nodes in the frame of another one."""
        poses = self.poses
        return relative(np.repeat(poses[first : first + 1], len(others), axis=0), poses[others])

    def graph(self) -> PoseGraph:
        """The graph, to be solved."""
        state, row = self._state, self._row
        edges = slice(int(state["edge_count"][row]))
        return PoseGraph.of(
            self.poses,
            state["edge_nodes"][row, edges],
            state["edge_measurement"][row, edges],
            state["edge_information"][row, edges],
        )

    def solve(self) -> bool:
        """Move all nodes to their most likely poses; false, without moving any, if there are none.

        Edges that the others contradict, loops or motions, are weighed down. A new one counts in full at first.
        """
        graph = self.graph()
        weights = self._state["edge_weight"][self._row, : len(graph.edges)]
        try:
            found = optimize_robustly(graph, weights=weights, most_rounds=_ROUNDS)
            trusted = weighted(_as_sure_as_it_fits(graph, found), found.weights, found.poses)
            covariance = covariance_of(trusted, found.poses, len(found.poses) - 1)
        except GraphError:
            return False
        weights[:] = found.weights
        self._state["node_pose"][self._row, : self.count] = found.poses
        spread = self._state["spread"][self._row]
        self._state["key_covariance"][self._row] = covariance + spread
        self._state["cross"][self._row] = -spread
        return True

    def moved_since_drawn(self, count: int) -> float:
        """How far the first `count` nodes' scans have moved at most since they were drawn into the map [m]."""
        off = self.poses[:count] - self._state["node_drawn"][self._row, :count]
        far = np.hypot(off[:, 0], off[:, 1]) + _ARM * np.abs(wrap_angle(off[:, 2]))
        return float(far.max(initial=0.0))

    def take_pose(self) -> None:
        """Move the row's robot along with its newest node."""
        state, row = self._state, self._row
        old, newest = state["key_pose"][row].copy(), self.poses[-1]
        for name in ("pose", "last", "scan_pose"):
            state[name][row] = _from(newest, relative(old[None], state[name][row : row + 1])[0])
        state["key_pose"][row] = newest


def _as_sure_as_it_fits(graph: PoseGraph, found: RobustOptimum) -> PoseGraph:
    """The graph with less of `_STD` in its edges: the least share with which they disagree by no more than they may.

    The sum of squared errors of a right graph is, in the mean, three for each edge beyond those that reach every node.
    An edge counts as far as the others believe it: one that they contradict adds next to nothing to the sum.
    """
    expected = 3.0 * (float(found.weights.sum()) - len(graph.poses) + 1)
    own = np.linalg.inv(graph.information) - np.diag(_STD**2)
    for share in _SHARES:
        fitting = attrs.evolve(graph, information=np.linalg.inv(own + share * np.diag(_STD**2)))
        if (found.weights * squared_errors(fitting, found.poses)).sum() <= expected:
            return fitting
    return graph


def _from(pose: Array, moved: Array) -> Array:
    """The pose (3,) after a displacement."""
    return np.asarray(compose(pose[None], moved[None])[0])


def _is_motion(edges: Ints, first: int, last: int) -> Bools:
    """Which edges (m, 2) lead from a node to the next one, between two nodes."""
    return np.asarray((edges[:, 0] >= first) & (edges[:, 1] <= last) & (edges[:, 1] - edges[:, 0] == 1))


def _is_same(pose: Array, other: Array) -> bool:
    """Whether two poses (3,) are the same place, within the accuracy of matches and of the motion between them."""
    off, turn = math.hypot(pose[0] - other[0], pose[1] - other[1]), abs(float(wrap_angle(pose[2] - other[2])))
    return bool(off <= _AGREE[0] and turn <= _AGREE[1])


def near_node(graph: NodeGraph, node: int, gap: int, distance: float) -> int | None:
    """The node nearest to another one among those at least `gap` nodes before it; None if none is that near."""
    poses = graph.poses
    old = poses[: max(0, node + 1 - gap)]
    if not len(old):
        return None
    apart = np.hypot(old[:, 0] - poses[node, 0], old[:, 1] - poses[node, 1])
    apart += _TURN * np.abs(np.sin(0.5 * (old[:, 2] - poses[node, 2])))
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] <= distance else None
