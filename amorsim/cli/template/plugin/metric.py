"""A metric: how straight the way was."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Straightness"]


@attrs.frozen(kw_only=True)
class Straightness(am.Metric):
    """The straight line from start to end over the length of the true path: 1 for a straight path, nan for none."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def needs(self) -> Sequence[str]:
        """Only the true path."""
        return ("true_pose",)

    def measure(self, episode: am.Episode) -> npt.NDArray[np.float64]:
        """One number for each replica."""
        places = episode.kept["true_pose"][..., :2]  # (S, R, 2)
        steps = np.diff(places, axis=0)
        # One step after another: np.sum may add in another order where there are fewer replicas.
        length = np.cumsum(np.sqrt(steps[..., 0] ** 2 + steps[..., 1] ** 2), axis=0)[-1]
        apart = places[-1] - places[0]
        line = np.sqrt(apart[:, 0] ** 2 + apart[:, 1] ** 2)
        return np.where(length > 0.0, line / np.where(length > 0.0, length, 1.0), np.nan)
