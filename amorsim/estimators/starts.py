"""What an estimator begins with: the pose that the robot knows, and how well."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context
from amorsim.core.errors import ComponentError

__all__ = ["covariance_at_start", "refuse_lost"]


def covariance_at_start(context: Context) -> npt.NDArray[np.float64]:
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
