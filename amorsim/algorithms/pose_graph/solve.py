"""The most likely poses of a graph: Gauss-Newton on a sparse matrix, from the solution of a linear problem.

The error of an edge is the displacement from the measured to the expected pose, ``z^-1 (a^-1 b)``, and chi2 the sum of
``e' I e``. Source: G. Grisetti, R. Kümmerle, C. Stachniss, W. Burgard, "A Tutorial on Graph-Based SLAM" (2010). The
start follows L. Carlone et al., "A linear approximation for graph-based simultaneous localization and mapping" (2011):
headings are linear once the whole turns of each loop are known, and places are linear once headings are.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from amorsim.algorithms.pose_graph.graph import PoseGraph
from amorsim.array_types import Array
from amorsim.core.arguments import checked
from amorsim.core.errors import GraphError
from amorsim.core.poses import wrap_angle

__all__ = ["Optimum", "chi2_of", "covariance_of", "linear_start", "optimize", "squared_errors"]


_MOST_HALVINGS = 20
_ROUNDING = 1e-12  # of chi2, relative


class Optimum(NamedTuple):
    """The most likely poses `(n, 3)` of a graph, their chi2, and how many steps of Gauss-Newton it took."""

    poses: Array
    chi2: float
    iterations: int


@checked
def chi2_of(graph: PoseGraph, poses: Array | None = None) -> float:
    """The sum of the squared errors of all edges at some poses `(n, 3)`, those of the graph if not given."""
    return float(squared_errors(graph, graph.poses if poses is None else poses).sum())


def squared_errors(graph: PoseGraph, poses: Array) -> Array:
    """The squared error `(m,)` of each edge at some poses `(n, 3)`, measured by its information."""
    errors = _errors(graph, poses)
    return np.asarray(np.einsum("ni,nij,nj->n", errors, graph.information, errors))


def _errors(graph: PoseGraph, poses: Array) -> Array:
    """The poses' value of each edge less its measured one `(m, 3)`, in the frame of the measured pose."""
    first, second = poses[graph.edges[:, 0]], poses[graph.edges[:, 1]]
    apart = _turned(second[:, :2] - first[:, :2], -first[:, 2]) - graph.measurements[:, :2]
    turn = wrap_angle(second[:, 2] - first[:, 2] - graph.measurements[:, 2])
    return np.concatenate((_turned(apart, -graph.measurements[:, 2]), turn[:, None]), axis=1)


def _turned(points: Array, angle: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack((c * points[:, 0] - s * points[:, 1], s * points[:, 0] + c * points[:, 1]), axis=1)


@checked
def optimize(
    graph: PoseGraph, *, start: str = "linear", most_iterations: int = 100, tolerance: float = 1e-9
) -> Optimum:
    """The poses with the least chi2 near the start; the first pose stays where the graph has it.

    Parameters
    ----------
    start
        Where Gauss-Newton begins: ``"linear"``, at the solution of a linear problem, which needs no guess; or
        ``"poses"``, at the poses of the graph.
    most_iterations
        The largest number of steps.
    tolerance
        It ends when a step makes chi2 smaller by no more than this part of it.

    Raises
    ------
    GraphError
        If the graph is not connected, its edges do not determine the poses, or the start is of another name.
    """
    _check_connected(graph)
    if start not in ("linear", "poses"):
        raise GraphError(f"start: expected 'linear' or 'poses', got {start!r}")
    poses = linear_start(graph) if start == "linear" else graph.poses.copy()
    chi2 = chi2_of(graph, poses)
    for count in range(most_iterations):
        change = _least_squares(graph, _slopes(graph, poses), _errors(graph, poses), graph.information)
        # A step that overshoots is halved; near the optimum none is.
        for _ in range(_MOST_HALVINGS):
            there = poses + change
            there[:, 2] = wrap_angle(there[:, 2])
            reached = chi2_of(graph, there)
            if reached <= chi2 * (1.0 + _ROUNDING):
                break
            change = 0.5 * change
        else:
            return Optimum(poses, chi2, count)
        gained, poses, chi2 = chi2 - reached, there, reached
        if gained <= tolerance * chi2:
            return Optimum(poses, chi2, count + 1)
    return Optimum(poses, chi2, most_iterations)


@checked
def covariance_of(graph: PoseGraph, poses: Array, place: int) -> Array:
    """The covariance (3, 3) of the pose at a place of `poses` `(n, 3)`, given the first pose; to first order.

    Raises
    ------
    GraphError
        If the graph is not connected, or its edges do not determine the poses.
    """
    _check_connected(graph)
    if place == 0:
        return np.zeros((3, 3))
    system = _System(graph, _slopes(graph, poses), graph.information)
    right = np.zeros((system.size, 3))
    right[3 * place - 3 : 3 * place] = np.eye(3)
    found = system.solve(right)[3 * place - 3 : 3 * place]
    return np.asarray(0.5 * (found + found.T))


def _slopes(graph: PoseGraph, poses: Array) -> Array:
    """Slopes `(m, 3, 6)` of the errors by the first pose of each edge, then by the second."""
    heading, measured = poses[graph.edges[:, 0], 2], graph.measurements[:, 2]
    apart = poses[graph.edges[:, 1], :2] - poses[graph.edges[:, 0], :2]
    c, s = np.cos(heading + measured), np.sin(heading + measured)
    slopes = np.zeros((len(heading), 3, 6))
    slopes[:, 0, 3], slopes[:, 0, 4] = c, s
    slopes[:, 1, 3], slopes[:, 1, 4] = -s, c
    slopes[:, :2, :2] = -slopes[:, :2, 3:5]
    slopes[:, 0, 2] = -s * apart[:, 0] + c * apart[:, 1]
    slopes[:, 1, 2] = -c * apart[:, 0] - s * apart[:, 1]
    slopes[:, 2, 2], slopes[:, 2, 5] = -1.0, 1.0
    return slopes


@checked
def linear_start(graph: PoseGraph) -> Array:
    """Poses `(n, 3)` near the optimum: headings from a linear problem, then places from another one.

    Raises
    ------
    GraphError
        If the graph is not connected, or its edges do not determine the poses.
    """
    _check_connected(graph)
    guess = _along_tree(graph)
    first, second = graph.edges[:, 0], graph.edges[:, 1]
    # With whole turns counted along the tree, what is left of a heading's error around each loop is small.
    off = wrap_angle(guess[second] - guess[first] - graph.measurements[:, 2])
    slopes = np.zeros((len(off), 1, 2))
    slopes[:, 0, 0], slopes[:, 0, 1] = -1.0, 1.0
    headings = guess + _least_squares(graph, slopes, off[:, None], graph.information[:, 2:, 2:])[:, 0]
    poses = np.zeros((len(headings), 3))
    poses[:, 2] = wrap_angle(headings)
    poses[0] = graph.poses[0]
    c, s = (f(headings[first] + graph.measurements[:, 2]) for f in (np.cos, np.sin))
    slopes = np.zeros((len(off), 2, 4))
    slopes[:, 0, 2], slopes[:, 0, 3] = c, s
    slopes[:, 1, 2], slopes[:, 1, 3] = -s, c
    slopes[:, :, :2] = -slopes[:, :, 2:]
    poses[1:, :2] = poses[0, :2]
    poses[:, :2] += _least_squares(graph, slopes, _errors(graph, poses)[:, :2], graph.information[:, :2, :2])
    return poses


def _along_tree(graph: PoseGraph) -> Array:
    """Headings `(n,)` added up along a tree of the edges, whole turns included."""
    from scipy.sparse.csgraph import breadth_first_order

    order, before = breadth_first_order(_links(graph), 0, directed=False)
    first, second = graph.edges.T.tolist()
    turn = dict(zip(zip(first, second, strict=True), graph.measurements[:, 2].tolist(), strict=True))
    found = [float(graph.poses[0, 2])] * len(graph.poses)
    for node in order[1:].tolist():
        parent = int(before[node])
        step = turn.get((parent, node))
        found[node] = found[parent] + (step if step is not None else -turn[node, parent])
    return np.array(found)


def _links(graph: PoseGraph) -> Any:
    from scipy.sparse import csr_matrix

    n = len(graph.poses)
    return csr_matrix((np.ones(len(graph.edges)), (graph.edges[:, 0], graph.edges[:, 1])), shape=(n, n))


def _check_connected(graph: PoseGraph) -> None:
    from scipy.sparse.csgraph import connected_components

    count, part = connected_components(_links(graph), directed=False)
    if count > 1:
        apart = int(graph.ids[np.flatnonzero(part != part[0])[0]])
        raise GraphError(
            f"the graph falls into {count} parts: no edges lead from pose {graph.ids[0]} to pose {apart}; "
            "add an edge, or solve each part for itself"
        )


def _least_squares(graph: PoseGraph, slopes: Array, errors: Array, weights: Array) -> Array:
    """The change `(n, d)` of all poses but the first that makes linear errors least.

    `slopes` `(m, r, 2 d)` are those of the errors `(m, r)` by both poses of each edge; `weights` are `(m, r, r)`.
    """
    size = slopes.shape[2] // 2
    if len(graph.poses) == 1:
        return np.zeros((1, size))
    system = _System(graph, slopes, weights)
    pull = np.einsum("nij,ni->nj", system.weighted, errors)
    sums = np.bincount(system.unknowns.ravel() + size, -pull.ravel(), minlength=len(graph.poses) * size)
    right = sums[size:].astype(np.float64)
    return np.concatenate((np.zeros(size), system.solve(right))).reshape(-1, size)


class _System:
    """The normal equations of a linear problem, whose unknowns are d numbers of all poses but the first."""

    def __init__(self, graph: PoseGraph, slopes: Array, weights: Array) -> None:
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        d = slopes.shape[2] // 2
        self.size = (len(graph.poses) - 1) * d
        self.weighted = np.einsum("nij,nik->njk", weights, slopes)
        blocks = np.einsum("nij,nik->njk", slopes, self.weighted)
        # Unknowns are counted without the first pose's; those are negative and left out.
        self.unknowns = (graph.edges[:, :, None] * d + np.arange(d)).reshape(-1, 2 * d) - d
        rows = np.repeat(self.unknowns, 2 * d, axis=1).ravel()
        cols = np.tile(self.unknowns, (1, 2 * d)).ravel()
        kept = (rows >= 0) & (cols >= 0)
        matrix = csc_matrix((blocks.ravel()[kept], (rows[kept], cols[kept])), shape=(self.size, self.size))
        try:
            self._solver = splu(
                matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
            )
        except RuntimeError as error:
            raise GraphError(
                f"the edges do not determine the poses ({error}); look for information matrices of 0"
            ) from None

    def solve(self, right: Array) -> Array:
        """The unknowns for a right side, or for each of its columns."""
        found = self._solver.solve(right)
        if not np.isfinite(found).all():
            raise GraphError("the edges do not determine the poses; look for information matrices of 0")
        return np.asarray(found)
