"""The robots' beliefs of their poses when an episode begins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws
from amorsim.kernels.filters.gaussians import draw_around
from amorsim.scenario.spec import Robot

__all__ = ["BELIEF", "first_beliefs"]


BELIEF = ("initial_belief",)
"""The name of the stream that errors of initial beliefs are drawn from."""


def first_beliefs(robots: Sequence[Robot], starts: Array, draws: Draws | None) -> tuple[Array, Array | None]:
    """The poses `(N, 3)` that robots of one group believe to start from, and their covariances; None if exact.

    `starts` `(N, 3)` are where they start. A pose is nan if nothing is known of it. A Gaussian one is drawn about the
    start; without `draws` it is that.
    """
    poses = starts.copy()
    match robots[0].initial_belief.kind:
        case "exact":
            return poses, None
        case "nothing":
            return np.full_like(poses, np.nan), None
    covariances = np.stack([robot.initial_belief.matrix for robot in robots])
    if draws is not None:
        draws.rewind()
        drawn = np.empty_like(poses)
        draw_around(poses, covariances, draws.normal(3), drawn)
        poses = drawn
    return poses, covariances
