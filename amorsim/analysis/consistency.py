"""NEES and NIS of a run, over time and replicas, from its files."""

from __future__ import annotations

import os
from typing import NamedTuple

import numpy as np

from amorsim.algorithms.consistency import Consistency, nees, verdict
from amorsim.analysis.measuring import episode_of
from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import Array
from amorsim.core.poses import wrap_angle

__all__ = ["OverTime", "run_nees", "run_nis"]


class OverTime(NamedTuple):
    """NEES or NIS of a run: `time` (S,) [s], `values` (S, R) or (S, R, slots), nan where there is none; a verdict.

    The verdict on NEES is over the replicas at the last time, which are independent; that on NIS over all innovations.
    """

    time: Array
    values: Array
    degrees: int
    verdict: Consistency

    def at(self, time: float, *, confidence: float = 0.95) -> Consistency:
        """The verdict over the values of the step nearest to a time [s]."""
        return verdict(self.values[int(np.argmin(np.abs(self.time - time)))], self.degrees, confidence=confidence)


def run_nees(
    run: str | os.PathLike[str] | RunFiles,
    *,
    robot: str | None = None,
    estimator: str | None = None,
    confidence: float = 0.95,
) -> OverTime:
    """The NEES of a pose estimate in each replica of a run.

    Parameters
    ----------
    robot, estimator
        Whose; without them, the first robot's, and the one that its controller received.

    Raises
    ------
    RunError
        If the folder is not a run's, or a file in it is damaged.
    AnalysisError
        If there is no such estimator.
    """
    files = run if isinstance(run, RunFiles) else RunFiles(run)
    names = ("estimated_pose", "covariance") if estimator is None else _names(estimator)
    episode = episode_of(files, ("true_pose", *names), robot=robot)
    errors = episode.kept[names[0]] - episode.kept["true_pose"]
    errors[..., 2] = wrap_angle(errors[..., 2])
    values = nees(errors, episode.kept[names[1]])
    return OverTime(episode.time, values, 3, verdict(values[-1], 3, confidence=confidence))


def _names(estimator: str) -> tuple[str, str]:
    return f"estimates.{estimator}.pose", f"estimates.{estimator}.covariance"


def run_nis(
    run: str | os.PathLike[str] | RunFiles,
    source: str = "landmarks",
    *,
    robot: str | None = None,
    estimator: str = "ekf",
    confidence: float = 0.95,
) -> OverTime:
    """The NIS of one of an estimator's sources in each replica of a run, from its beliefs ``SOURCE_nis``.

    Raises
    ------
    RunError
        If the folder is not a run's, or a file in it is damaged.
    AnalysisError
        If there is no such estimator, or it has no such belief.
    """
    files = run if isinstance(run, RunFiles) else RunFiles(run)
    names = [f"beliefs.{estimator}.{source}_{what}" for what in ("nis", "innovation")]
    episode = episode_of(files, names, robot=robot)
    values, innovations = (episode.kept[name] for name in names)
    degrees = innovations.shape[-1] if innovations.ndim > values.ndim else 1
    return OverTime(episode.time, values, degrees, verdict(values, degrees, confidence=confidence))
