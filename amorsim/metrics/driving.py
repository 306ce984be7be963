"""Metrics of driving: distance, smoothness, collisions, and whether and when the robot arrived."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import Episode, Metric, parameter
from amorsim.core.poses import wrap_angle
from amorsim.metrics.jumps import before_steps
from amorsim.metrics.series import total
from amorsim.planners.theta_star import ThetaStar

__all__ = ["ArrivalTime", "Collisions", "PathLength", "Spl", "Success", "Turning"]


def _lengths(episode: Episode) -> Array:
    """The length of the true path that each replica drove [m]."""
    steps = episode.kept["true_pose"][1:, :, :2] - before_steps(episode)[..., :2]
    return total(np.sqrt(steps[..., 0] ** 2 + steps[..., 1] ** 2))


def _counts(episode: Episode, kind: str) -> Array:
    """How many events of a kind each replica has."""
    places = {replica: row for row, replica in enumerate(episode.replicas)}
    found = np.zeros(len(episode.replicas))
    for event in episode.events:
        if event.kind == kind:
            found[places[event.replica]] += 1.0
    return found


@attrs.frozen(kw_only=True)
class PathLength(Metric):
    """Length of the true path that the robot drove, without jumps where it was put elsewhere or kidnapped."""

    unit: ClassVar[str] = "m"
    better: ClassVar[str] = "lower"

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        return _lengths(episode)


@attrs.frozen(kw_only=True)
class Turning(Metric):
    """Turning per path driven, to either side: the lower, the smoother. nan for a robot that did not move.

    Where it was put elsewhere or kidnapped, it did not turn.
    """

    unit: ClassVar[str] = "rad/m"
    better: ClassVar[str] = "lower"

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        turned = total(np.abs(wrap_angle(episode.kept["true_pose"][1:, :, 2] - before_steps(episode)[..., 2])))
        lengths = _lengths(episode)
        return np.where(lengths > 0.0, turned / np.where(lengths > 0.0, lengths, 1.0), np.nan)


@attrs.frozen(kw_only=True)
class ArrivalTime(Metric):
    """Time until the robot is first truly near the goal; nan if it never is."""

    unit: ClassVar[str] = "s"
    better: ClassVar[str] = "lower"

    goal: tuple[float, float] = parameter(unit="m", frame="world", help="where it is to go")
    tolerance: float = parameter(0.5, unit="m", gt=0, help="how near the goal counts as arrived")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        near = _near(episode, self.goal, self.tolerance)
        first = episode.time[np.argmax(near, axis=0)] - episode.time[0]
        return np.where(near.any(axis=0), first, np.nan)


@attrs.frozen(kw_only=True)
class Collisions(Metric):
    """How often the robot ran into something, or something into it."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "lower"

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ()

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        return _counts(episode, "collision")


@attrs.frozen(kw_only=True)
class Success(Metric):
    """1 if the robot was truly near the goal at some time and did not collide, else 0.

    Without a goal, it need not be anywhere.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    goal: tuple[float, float] | None = parameter(
        None, unit="m", frame="world", help="where it is to go; none: anywhere"
    )
    tolerance: float = parameter(0.5, unit="m", gt=0, help="how near the goal counts as arrived")
    collisions: int = parameter(0, ge=0, help="how many collisions are forgiven")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        is_safe = _counts(episode, "collision") <= self.collisions
        if self.goal is None:
            return np.where(is_safe, 1.0, 0.0)
        return np.where(is_safe & _near(episode, self.goal, self.tolerance).any(axis=0), 1.0, 0.0)


@attrs.frozen(kw_only=True)
class Spl(Metric):
    """Success weighted by path length: the shortest way to the goal over the way driven until there; 0 without success.

    The shortest way is that of a circle as large as the robot's footprint reaches, by Theta* on cells of `cell`, up to
    `tolerance` before the goal. A robot that drives a shorter way has 1. nan where there is no such way. After
    P. Anderson and others, "On evaluation of embodied navigation agents", 2018.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    goal: tuple[float, float] = parameter(unit="m", frame="world", help="where it is to go")
    tolerance: float = parameter(0.5, unit="m", gt=0, help="how near the goal counts as arrived")
    collisions: int = parameter(0, ge=0, help="how many collisions are forgiven")
    cell: float = parameter(0.05, unit="m", gt=0, help="side of the cells on which the shortest way is planned")

    def needs(self) -> Sequence[str]:
        """See `Metric`."""
        return ("true_pose",)

    def measure(self, episode: Episode) -> Array:
        """See `Metric`."""
        poses, planner = episode.kept["true_pose"], ThetaStar(cell=self.cell)
        near = _near(episode, self.goal, self.tolerance)
        is_safe = _counts(episode, "collision") <= self.collisions
        steps = poses[1:, :, :2] - before_steps(episode)[..., :2]
        driven = np.add.accumulate(np.sqrt(steps[..., 0] ** 2 + steps[..., 1] ** 2), axis=0)
        found = np.zeros(len(episode.replicas))
        for row in range(len(found)):
            start = poses[0, row, :2].tolist()
            shortest = planner.plan(episode.map_of(row), start, self.goal, footprint=episode.shape).length
            if not np.isfinite(shortest):
                found[row] = np.nan
            elif is_safe[row] and near[:, row].any():
                first = int(np.argmax(near[:, row]))
                least = max(shortest - self.tolerance, 0.0)
                way = driven[first - 1, row] if first else 0.0
                found[row] = least / max(way, least) if way > 0.0 else 1.0
        return found


def _near(episode: Episode, goal: tuple[float, float], within: float) -> Bools:
    """Whether the robot is truly near a place, at every time `(S, R)`."""
    apart = episode.kept["true_pose"][..., :2] - np.array(goal)
    return np.asarray(np.sqrt(apart[..., 0] ** 2 + apart[..., 1] ** 2) <= within)
