"""Pose graphs with some wrong edges: each edge is weighted by its agreement with the others.

Dynamic covariance scaling: an edge with the squared error χ² has its information multiplied by s², where
s = 2Φ / (Φ + χ²), at most 1. Poses and weights are found in turn. Source: P. Agarwal, G. D. Tipaldi, L. Spinello,
C. Stachniss, W. Burgard, "Robust map optimization using dynamic covariance scaling" (2013).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.algorithms.pose_graph.graph import PoseGraph
from amorsim.algorithms.pose_graph.solve import optimize, squared_errors
from amorsim.array_types import Array
from amorsim.core.arguments import checked
from amorsim.core.errors import GraphError

__all__ = ["RobustOptimum", "optimize_robustly", "weighted"]


_ITERATIONS = 3  # of Gauss-Newton between two sets of weights
_SETTLED = 1e-4  # change of a weight that is none


class RobustOptimum(NamedTuple):
    """Poses `(n, 3)`, the weights `(m,)` of the edges from 0 to 1, and the sum of the weighted squared errors."""

    poses: Array
    weights: Array
    chi2: float


@checked
def optimize_robustly(
    graph: PoseGraph, *, weights: Array | None = None, scale: float = 5.0, most_rounds: int = 50
) -> RobustOptimum:
    """The most likely poses near those of the graph if some of its edges may be wrong; the first pose stays.

    Parameters
    ----------
    weights
        Weights `(m,)` of the edges to begin with, 1 if not given: so an edge is believed until others contradict it.
    scale
        Φ: an edge with a squared error up to this counts in full.
    most_rounds
        The largest number of times that poses and weights are found.

    Raises
    ------
    GraphError
        If the graph is not connected, its edges do not determine the poses, a weight is not a positive number, or the
        scale is not.
    """
    found = np.ones(len(graph.edges)) if weights is None else np.array(weights, dtype=np.float64)
    if found.shape != (len(graph.edges),) or not (np.isfinite(found) & (found > 0.0)).all():
        raise GraphError(f"weights: expected a positive number for each of {len(graph.edges)} edges")
    if not (math.isfinite(scale) and scale > 0.0):
        raise GraphError(f"scale: expected a positive number, got {scale:g}")
    poses = graph.poses
    for _ in range(most_rounds):
        poses = optimize(weighted(graph, found, poses), start="poses", most_iterations=_ITERATIONS).poses
        before, found = found, _scaled(squared_errors(graph, poses), scale)
        if np.abs(found - before).max(initial=0.0) <= _SETTLED:
            break
    return RobustOptimum(poses, found, float((found * squared_errors(graph, poses)).sum()))


def weighted(graph: PoseGraph, weights: Array, poses: Array) -> PoseGraph:
    """The graph at other poses, with the information of each edge multiplied by its weight."""
    return attrs.evolve(graph, poses=poses, information=graph.information * weights[:, None, None])


def _scaled(squares: Array, scale: float) -> Array:
    """Weights of edges with these squared errors."""
    return np.asarray(np.minimum(1.0, 2.0 * scale / (scale + squares)) ** 2)
