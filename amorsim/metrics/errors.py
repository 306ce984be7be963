"""How far the estimated pose is from the true one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.poses import wrap_angle
from amorsim.metrics.jumps import jumps
from amorsim.metrics.series import AT, at

__all__ = ["HeadingError", "PositionError", "RecoveryTime"]


_HELP = "of all times: the last, the mean, the root mean square, the largest, the median"


_WHOSE = "whose estimate; none: the one that the controller receives"


def _estimate_of(estimator: str | None) -> str:
    """The quantity that an estimator's poses are."""
    return f"estimates.{estimator}.pose" if estimator else "estimated_pose"


def _distances(episode: Episode, estimator: str | None) -> Array:
    """Between estimated and true position at every time, `(S, R)` [m]."""
    apart = episode.kept[_estimate_of(estimator)][..., :2] - episode.kept["true_pose"][..., :2]
    return np.asarray(np.sqrt(apart[..., 0] ** 2 + apart[..., 1] ** 2))


@attrs.frozen(kw_only=True)
class PositionError(Metric):
    """Distance between the estimated and the true position."""

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    at: str = parameter("end", choices=AT, help=_HELP)
    estimator: str | None = parameter(None, refers="estimators", help=_WHOSE)

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", _estimate_of(self.estimator))

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        return at(_distances(episode, self.estimator), self.at)


@attrs.frozen(kw_only=True)
class HeadingError(Metric):
    """Difference between the estimated and the true heading, without its sign."""

    unit: ClassVar[str] = "rad"
    better: ClassVar[str] = "lower"

    at: str = parameter("end", choices=AT, help=_HELP)
    estimator: str | None = parameter(None, refers="estimators", help=_WHOSE)

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", _estimate_of(self.estimator))

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        apart = episode.kept[_estimate_of(self.estimator)][..., 2] - episode.kept["true_pose"][..., 2]
        return at(np.abs(wrap_angle(apart)), self.at)


@attrs.frozen(kw_only=True)
class RecoveryTime(Metric):
    """Time until the estimated position is near the true one, and stays so for a while.

    It counts from the last time that the robot was put elsewhere (`Simulation.set_pose`) or kidnapped, or else from the
    start. A replica that never recovers has none: nan.
    """

    unit: ClassVar[str] = "s"
    better: ClassVar[str] = "lower"

    tolerance: float = parameter(0.5, unit="m", gt=0, help="how near counts as recovered")
    hold_time: float = parameter(0.0, unit="s", ge=0, help="how long it must stay so")
    estimator: str | None = parameter(None, refers="estimators", help=_WHOSE)

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose", _estimate_of(self.estimator))

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        near = _distances(episode, self.estimator) <= self.tolerance
        found = np.full(near.shape[1], np.nan)
        since, first = np.zeros((2, near.shape[1]), dtype=np.int64)
        for jump in jumps(episode):
            # At that time itself it was still where it had been.
            since[jump.row], first[jump.row] = jump.place, jump.place + 1
        # Times are sums of steps; a hold of three of them is three.
        hold = self.hold_time * (1.0 - 1e-9)
        for row in range(near.shape[1]):
            begun = None
            for step in range(first[row], len(near)):
                if not near[step, row]:
                    begun = None
                    continue
                begun = step if begun is None else begun
                if episode.time[step] - episode.time[begun] >= hold:
                    found[row] = episode.time[begun] - episode.time[since[row]]
                    break
        return found
