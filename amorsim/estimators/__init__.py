"""Estimators: poses estimated from readings."""

from __future__ import annotations

from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.estimators.ekf import Ekf

__all__ = ["DeadReckoning", "Ekf"]
