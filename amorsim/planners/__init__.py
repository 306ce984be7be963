"""Planners: paths on a map from a start to a goal."""

from __future__ import annotations

from amorsim.planners.a_star import AStar
from amorsim.planners.dijkstra import Dijkstra
from amorsim.planners.wavefront import Wavefront

__all__ = ["AStar", "Dijkstra", "Wavefront"]
