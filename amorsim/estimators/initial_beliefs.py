"""The start of an estimator: the pose that the robot knows, and its covariance."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, Estimate, State
from amorsim.core.errors import ComponentError

__all__ = ["covariance_at_start", "refuse_lost", "start_state", "with_start"]


def covariance_at_start(context: Context) -> Array:
    """The covariance `(N, 3, 3)` of the poses that the robots know, zeros if they are exact; a new array."""
    return np.zeros((context.rows, 3, 3)) if context.covariance is None else context.covariance.copy()


def refuse_lost(who: str, context: Context) -> None:
    """Raise a `ComponentError` if a robot knows nothing of its start."""
    lost = np.isnan(context.pose).any(axis=1)
    if lost.any():
        raise ComponentError(
            f"{context.robot.who(int(np.argmax(lost)))}: {who} starts from a pose, but the robot knows nothing of its "
            "start (initial_belief.kind = 'nothing'); use an estimator that finds it, such as monte_carlo, or give it "
            "an initial belief"
        )


def start_state(context: Context) -> State:
    """The part of a state that `with_start` needs; empty for robots that know their start exactly."""
    if context.covariance is None:
        return {}
    return {"start_pose": np.array(context.pose), "start_covariance": context.covariance.copy()}


def with_start(estimate: Estimate, state: State) -> Estimate:
    """An estimate whose covariance is relative to the start, with the covariance of the start added.

    An error of the first pose moves and turns the whole way from there.
    """
    if "start_covariance" not in state:
        return estimate
    first, off = state["start_covariance"], estimate.pose - state["start_pose"]
    moves = np.zeros_like(first)  # the estimate's derivatives by the first pose
    moves[:, 0, 0] = moves[:, 1, 1] = moves[:, 2, 2] = 1.0
    moves[:, 0, 2], moves[:, 1, 2] = -off[:, 1], off[:, 0]
    covariance = estimate.covariance.copy()
    for j in range(3):
        for k in range(3):
            covariance += moves[:, :, j, None] * moves[:, None, :, k] * first[:, None, None, j, k]
    return Estimate(estimate.pose, covariance)
