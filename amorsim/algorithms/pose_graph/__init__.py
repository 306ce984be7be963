"""Graphs of poses in the plane and what was measured between them: read, written and solved."""

from amorsim.algorithms.pose_graph.g2o import read_g2o, write_g2o
from amorsim.algorithms.pose_graph.graph import PoseGraph
from amorsim.algorithms.pose_graph.solve import Optimum, chi2_of, covariance_of, linear_start, optimize

__all__ = ["Optimum", "PoseGraph", "chi2_of", "covariance_of", "linear_start", "optimize", "read_g2o", "write_g2o"]
