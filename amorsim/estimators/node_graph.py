"""The pose graph of one robot, as an estimator's state holds it: arrays of a fixed size over rows."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.algorithms.pose_graph import PoseGraph, covariance_of, optimize
from amorsim.contracts import State
from amorsim.core.errors import GraphError
from amorsim.core.poses import relative

__all__ = ["NodeGraph", "empty_nodes", "loops_of", "near_nodes"]

Array = npt.NDArray[np.float64]

_STD = np.array([0.005, 0.005, 0.002])  # [m, m, rad] added to each edge: matches share errors that they do not know of


def empty_nodes(rows: int, most: int, beams: int) -> State:
    """Graphs without a node, with room for a number of them and for twice as many edges."""
    return {
        "node_count": np.zeros(rows, np.int64),
        "node_pose": np.full((rows, most, 3), np.nan),
        "node_ranges": np.full((rows, most, beams), np.nan),
        "edge_count": np.zeros(rows, np.int64),
        "edge_nodes": np.full((rows, 2 * most, 2), -1, np.int64),
        "edge_measurement": np.full((rows, 2 * most, 3), np.nan),
        "edge_information": np.full((rows, 2 * most, 3, 3), np.nan),
    }


def loops_of(state: State) -> npt.NDArray[np.int64]:
    """How many edges of each row's graph close a loop `(N,)`."""
    edges = state["edge_nodes"]
    return np.asarray(((edges[:, :, 1] - edges[:, :, 0]) > 1).sum(axis=1))


class NodeGraph:
    """The graph of one row of a state, which it changes."""

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
        """Add a node where the row's robot is, linked to its key; False if there is no more room."""
        state, row, count = self._state, self._row, self.count
        if count == state["node_pose"].shape[1]:
            return False
        state["node_pose"][row, count] = state["pose"][row]
        state["node_ranges"][row, count] = ranges
        state["node_count"][row] = count + 1
        if count:
            c, s = np.cos(state["key_pose"][row, 2]), np.sin(state["key_pose"][row, 2])
            turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
            spread = turn @ state["spread"][row] @ turn.T
            moved = relative(state["key_pose"][row : row + 1], state["pose"][row : row + 1])[0]
            self._link(count - 1, count, moved, spread)
        return True

    def link(self, first: int, second: int, measured: Array, information: Array) -> bool:
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

    def relative(self, first: int, second: int) -> Array:
        """The pose of a node in the frame of another one."""
        poses = self.poses
        return np.asarray(relative(poses[first : first + 1], poses[second : second + 1])[0])

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
        """Move all nodes to their most likely poses; False, and none is moved, if there are no such poses."""
        graph = self.graph()
        try:
            found = optimize(graph, most_iterations=20)
            covariance = covariance_of(graph, found.poses, len(found.poses) - 1)
        except GraphError:
            return False
        self._state["node_pose"][self._row, : self.count] = found.poses
        self._state["key_covariance"][self._row] = covariance
        return True

    def take_pose(self) -> None:
        """Put the row's robot, which is at its newest node, to where that node is now."""
        state, row = self._state, self._row
        newest = self.poses[-1]
        for name in ("pose", "key_pose", "last", "scan_pose"):
            state[name][row] = newest


def near_nodes(graph: NodeGraph, gap: int, distance: float) -> int | None:
    """The node nearest to the newest one among those at least `gap` nodes before it; None if none is that near."""
    poses = graph.poses
    old = poses[: max(0, len(poses) - gap)]
    if not len(old):
        return None
    apart = (old[:, 0] - poses[-1, 0]) ** 2 + (old[:, 1] - poses[-1, 1]) ** 2
    nearest = int(np.argmin(apart))
    return nearest if apart[nearest] <= distance * distance else None
