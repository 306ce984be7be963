"""Tasks for learners: what is observed and rewarded, and when an episode ends."""

from __future__ import annotations

from amorsim.tasks.point_goal import PointGoal

__all__ = ["PointGoal"]
