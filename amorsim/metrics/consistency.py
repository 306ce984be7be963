"""How an estimator's errors compare with its own covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.algorithms.consistency import nees
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.poses import wrap_angle
from amorsim.metrics.series import AT, at, total

__all__ = ["Nees", "Nis"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Nees(Metric):
    """The normalised estimation error squared of the pose: 3 on the mean for a consistent estimator.

    Its mean over replicas is to be compared with the band of `am.analysis.verdict`. nan while the covariance is not
    positive definite, as at the start.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "neither"

    at: str = parameter("end", choices=AT, help="of all times at which it has a value")
    estimator: str | None = parameter(
        None, refers="estimators", help="whose; none: the one that the controller receives"
    )

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", *self._names())

    def _names(self) -> tuple[str, str]:
        if not self.estimator:
            return "estimated_pose", "covariance"
        return f"estimates.{self.estimator}.pose", f"estimates.{self.estimator}.covariance"

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        pose, covariance = (episode.kept[name] for name in self._names())
        errors = pose - episode.kept["true_pose"]
        errors[..., 2] = wrap_angle(errors[..., 2])
        return _of_those_there(nees(errors, covariance), self.at)


@attrs.frozen(kw_only=True)
class Nis(Metric):
    """The mean normalised innovation squared of one of an estimator's sources, over all its updates.

    A consistent estimator's is as large as the number of values of a measurement, such as 2 for a landmark's range and
    bearing.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "neither"

    estimator: str = parameter("ekf", refers="estimators", help="which estimator; it must have such a belief")
    source: str = parameter("landmarks", help="which of its sources: the belief SOURCE_nis")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return (self._name(),)

    def _name(self) -> str:
        return f"beliefs.{self.estimator}.{self.source}_nis"

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        values = episode.kept[self._name()]
        by_slot = values.reshape(*values.shape[:2], -1)
        there = ~np.isnan(by_slot)
        sums = total(np.moveaxis(np.where(there, by_slot, 0.0), 2, 0).reshape(-1, by_slot.shape[1]))
        counts = there.sum(axis=(0, 2))
        return np.where(counts > 0, sums / np.maximum(counts, 1), np.nan)


def _of_those_there(values: Array, what: str) -> Array:
    """As `at`, of the values of each row that are not nan; nan for a row without any."""
    found = np.full(values.shape[1], np.nan)
    for row in range(values.shape[1]):
        there = values[~np.isnan(values[:, row]), row]
        if what == "end" and not np.isnan(values[-1, row]):
            found[row] = values[-1, row]
        elif what != "end" and len(there):
            found[row] = at(there[:, None], what)[0]
    return found
