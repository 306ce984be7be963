"""Estimators: poses estimated from readings."""

from __future__ import annotations

from amorsim.estimators.dead_reckoning import DeadReckoning
from amorsim.estimators.ekf import Ekf
from amorsim.estimators.monte_carlo import MonteCarlo
from amorsim.estimators.ukf import Ukf

__all__ = ["DeadReckoning", "Ekf", "MonteCarlo", "Ukf"]
