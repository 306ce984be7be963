"""What robots make of their readings."""

from __future__ import annotations

from amorsim.estimators.dead_reckoning import DeadReckoning

__all__ = ["DeadReckoning"]
