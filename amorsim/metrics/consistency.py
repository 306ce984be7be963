"""How an estimator's errors compare with its own covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.algorithms.consistency import nees
from amorsim.array_types import Array
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.kernels import elementary
from amorsim.metrics.series import AT, at, total

__all__ = ["Nees", "Nis"]


@attrs.frozen(kw_only=True)
class Nees(Metric):
    """The normalised estimation error squared of the pose: 3 on the mean for a consistent estimator.

    Its mean over replicas is to be compared with the band of `am.analysis.verdict`. nan while the covariance is not
    positive definite, as at the start. With `particles`, it is of the mean and the covariance of the estimator's
    particles.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "neither"

    at: str = parameter("end", choices=AT, help="of all times at which it has a value")
    estimator: str | None = parameter(
        None, refers="estimators", help="whose; none: the one that the controller receives"
    )
    particles: bool = parameter(False, help="whether of its particles, in place of its pose and covariance")

    def __attrs_post_init__(self) -> None:
        if self.particles and not self.estimator:
            raise ParameterError("estimator", "expected the name of the estimator whose particles are judged, got none")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", *self._names())

    def _names(self) -> tuple[str, str]:
        if self.particles:
            return f"beliefs.{self.estimator}.particles", f"beliefs.{self.estimator}.weights"
        if not self.estimator:
            return "estimated_pose", "covariance"
        return f"estimates.{self.estimator}.pose", f"estimates.{self.estimator}.covariance"

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        pose, covariance = (episode.kept[name] for name in self._names())
        if self.particles:
            pose, covariance = _moments(pose, covariance)
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


def _moments(particles: Array, weights: Array) -> tuple[Array, Array]:
    """Means `(S, R, 3)` and covariances `(S, R, 3, 3)` of particles `(S, R, P, 3)` with weights `(S, R, P)`."""
    found = [_moments_of_row(particles[:, row], weights[:, row]) for row in range(particles.shape[1])]
    mean, covariance = (np.stack(parts, axis=1) for parts in zip(*found, strict=True))
    return mean, covariance


def _moments_of_row(particles: Array, weights: Array) -> tuple[Array, Array]:
    share = np.nan_to_num(weights)  # of a cloud that has shrunk
    sums = share.sum(axis=-1, keepdims=True)
    share = share / np.where(sums > 0.0, sums, np.nan)
    poses = np.nan_to_num(particles)
    mean = np.einsum("sp,spi->si", share, poses)
    c, s = (np.einsum("sp,sp->s", share, turn(poses[..., 2])) for turn in (np.cos, np.sin))
    mean[:, 2] = elementary.arctan2(s, c)
    apart = poses - mean[:, None]
    apart[..., 2] = wrap_angle(apart[..., 2])
    return mean, np.einsum("sp,spi,spj->sij", share, apart, apart)


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
