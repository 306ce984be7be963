"""Methods of the field as mathematics over arrays, independent of simulations and files."""

from __future__ import annotations

from amorsim.algorithms import pose_graph
from amorsim.algorithms.curves import Curve, dubins, reeds_shepp
from amorsim.algorithms.speed_profile import SpeedProfile, speed_profile

__all__ = ["Curve", "SpeedProfile", "dubins", "pose_graph", "reeds_shepp", "speed_profile"]
