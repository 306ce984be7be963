"""A metric: how much longer the way was than it had to be."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am


@attrs.frozen(kw_only=True)
class Detour(am.Metric):
    """Length of the true path, over the straight line from its start to its end: 1 for a straight path.

    Select it in a study with ``detour = { use = "detour" }`` under ``[metrics]``.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"

    least: float = am.parameter(0.1, unit="m", gt=0, help="a robot that ends nearer to its start has no detour: nan")

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
        far = line >= self.least
        return np.where(far, length / np.where(far, line, 1.0), np.nan)
