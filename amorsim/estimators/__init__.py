"""Estimators: poses estimated from readings."""

from __future__ import annotations

from amorsim.estimators.dead_reckoning import DeadReckoning

__all__ = ["DeadReckoning"]
