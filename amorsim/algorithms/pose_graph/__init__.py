"""Graphs of poses in the plane, and measurements between them: read, written and solved."""

from amorsim.algorithms.pose_graph.g2o import read_g2o, write_g2o
from amorsim.algorithms.pose_graph.graph import PoseGraph
from amorsim.algorithms.pose_graph.robust import RobustOptimum, optimize_robustly
from amorsim.algorithms.pose_graph.solve import Optimum, chi2_of, covariance_of, linear_start, optimize

__all__ = [
    "Optimum",
    "PoseGraph",
    "RobustOptimum",
    "chi2_of",
    "covariance_of",
    "linear_start",
    "optimize",
    "optimize_robustly",
    "read_g2o",
    "write_g2o",
]
