"""The data of a run's pictures: a robot's true poses, and the estimates of each of its estimators, step by step."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np

from amorsim.analysis.plots.figures import ESTIMATED, OTHERS
from amorsim.analysis.run_files import RunFiles
from amorsim.array_types import AnyArray
from amorsim.core.errors import RunError

__all__ = ["Estimates", "Trace", "read_trace"]


@attrs.frozen(kw_only=True)
class Estimates:
    """The estimates of one estimator in S steps of N replicas, and their style in pictures."""

    name: str
    pose: AnyArray  # (S, N, 3) [m, m, rad]
    covariance: AnyArray  # (S, N, 3, 3)
    error: AnyArray  # (S, N, 3): estimated less true, the heading within half a turn
    style: dict[str, Any]

    @property
    def distance(self) -> AnyArray:
        """How far estimated and true position are apart [m] `(S, N)`."""
        distance: AnyArray = np.hypot(self.error[..., 0], self.error[..., 1])
        return distance

    @property
    def sigma(self) -> AnyArray:
        """The standard deviations of x [m], y [m] and heading [rad] that the estimator believes `(S, N, 3)`."""
        with np.errstate(invalid="ignore"):
            sigma: AnyArray = np.sqrt(np.diagonal(self.covariance, axis1=-2, axis2=-1))
        return sigma

    @property
    def has_sigma(self) -> bool:
        """Whether it believes any."""
        return bool(np.nansum(self.sigma) > 0.0)


@attrs.frozen(kw_only=True)
class Trace:
    """A robot in S steps of N replicas."""

    time: AnyArray  # (S,) [s]
    true: AnyArray  # (S, N, 3) [m, m, rad]
    estimates: list[Estimates]  # the first is the one that the controller is given


def read_trace(files: RunFiles, robot: str, replica: int | None) -> Trace:
    """The trace of a robot in one replica of a run, or with None in all of them.

    Raises
    ------
    RunError
        If a file is damaged, or the times of two files disagree.
    """
    chosen = slice(None) if replica is None else [files.replicas.index(replica)]
    poses = files.arrays("poses", robot=robot)
    specified = next(each for each in files.scenario.robots if each.name == robot)
    written = [name for name in (*specified.estimators, "none") if name in files.estimators]
    tables = {name: files.arrays(f"estimates/{name}", robot=robot) for name in written}
    tables = {name: table for name, table in tables.items() if np.isfinite(table["pose"]).any()}
    # Of a run that was killed, one file may be a step ahead.
    steps = min([len(poses["time"]), *(len(table["time"]) for table in tables.values())])
    time, true = poses["time"][:steps], poses["true_pose"][:steps, chosen]
    found = []
    for place, (name, table) in enumerate(tables.items()):
        if (table["time"][:steps] != time).any():
            raise RunError(f"{files.folder / 'estimates' / name}.csv: its times are not those of poses.csv")
        style = ESTIMATED if place == 0 else OTHERS[(place - 1) % len(OTHERS)]
        label = f"estimated: {name}" if len(tables) > 1 else "estimated"
        pose = table["pose"][:steps, chosen]
        found.append(
            Estimates(
                name=name,
                pose=pose,
                covariance=table["covariance"][:steps, chosen],
                error=_less(pose, true),
                style=style | {"label": label},
            )
        )
    if not found:  # they were not written, or were removed
        pose = poses["estimated_pose"][:steps, chosen]
        nothing = np.full((*pose.shape, 3), np.nan)
        found = [Estimates(name="", pose=pose, covariance=nothing, error=_less(pose, true), style=ESTIMATED)]
    return Trace(time=time, true=true, estimates=found)


def _less(pose: AnyArray, true: AnyArray) -> AnyArray:
    error = pose - true
    error[..., 2] = (error[..., 2] + np.pi) % (2.0 * np.pi) - np.pi
    return error
