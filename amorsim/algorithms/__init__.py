"""Methods of the field as plain mathematics over arrays: nothing here knows of a simulation or of a file of a run."""

from __future__ import annotations

from amorsim.algorithms import pose_graph
from amorsim.algorithms.curves import Curve, dubins, reeds_shepp
from amorsim.algorithms.speed_profile import SpeedProfile, speed_profile

__all__ = ["Curve", "SpeedProfile", "dubins", "pose_graph", "reeds_shepp", "speed_profile"]
