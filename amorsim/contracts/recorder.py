"""The contract of recorders, and what they are shown."""

from __future__ import annotations

import abc
import types
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts.robot import RobotModel
from amorsim.contracts.values import Beliefs, BeliefsByName, Estimate, Measurement
from amorsim.core.display import in_notebook

__all__ = ["Frame", "ObstacleFrame", "Recorder", "RunInfo"]


class Frame(NamedTuple):
    """One step of one group of robots for recorders, truth included. Do not change the arrays."""

    names: Sequence[str]  # of each row
    replica: Ints  # (N,)
    tick: Ints  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    joint_names: Sequence[str]
    joint_rates: Array  # (N, j) true, mean over the step
    estimates: Mapping[str, Estimate]  # the first is the controller's
    readings: Mapping[str, tuple[Array, Measurement]]  # true values, and the robot's measurement
    channels: Sequence[str]
    command: Array  # (N, c)
    robot: RobotModel  # the nominal one
    parts: Sequence[str] = ()  # names of each robot's parts
    part_pose: Array = np.empty((0, 0, 3))  # (N, p, 3) true, if there are parts
    # Of the estimators that have any, by name. Computed when first looked up, which must be in the frame's own step.
    beliefs: Mapping[str, Beliefs] = types.MappingProxyType({})

    def _repr_mimebundle_(self, **options: Any) -> dict[str, Any]:
        return in_notebook(self, **options)

    def some_beliefs(self, name: str, wanted: Iterable[str]) -> Beliefs:
        """Some beliefs of an estimator, without computing those that are not wanted, which may be large."""
        if isinstance(self.beliefs, BeliefsByName):
            return self.beliefs.some(name, wanted)
        return {belief: self.beliefs[name][belief] for belief in wanted}


class ObstacleFrame(NamedTuple):
    """One step of one group of obstacles for recorders. Do not change the arrays."""

    names: Sequence[str]  # of each row
    replica: Ints  # (N,)
    tick: Ints  # (N,)
    time: Array  # (N,) [s]
    true_pose: Array  # (N, 3)
    true_twist: Array  # (N, 3) mean over the step, in the body's frame
    moves: bool  # whether they have a motion


class RunInfo(NamedTuple):
    """The description of a run for recorders, before its first step."""

    folder: Path  # exists, and belongs to this run only
    dt: float  # [s]
    replicas: Sequence[int]
    with_sensors: bool  # whether to write sensors


class Recorder(abc.ABC):
    """Records a run as it goes: an ``attrs.define(kw_only=True)`` class, because it keeps files open."""

    def fresh(self) -> Recorder:
        """A new recorder with the same parameters, not yet opened: each run has its own."""
        again: Recorder = attrs.evolve(cast(Any, self))
        return again

    @abc.abstractmethod
    def open(self, run: RunInfo, frames: Sequence[Frame]) -> None:
        """Begin a run; write `frames` too: they are those of tick 0, with the first readings."""

    @abc.abstractmethod
    def write(self, frames: Sequence[Frame], events: Sequence[Any]) -> None:
        """Record a step: a frame for each group, and the events (`amorsim.simulation.events.Event`) since the last."""

    def write_obstacles(self, frames: Sequence[ObstacleFrame]) -> None:
        """Record the obstacles, a frame for each group; called after `open` and after each `write`."""
        return

    @abc.abstractmethod
    def close(self) -> None:
        """End the run; also called when a run is aborted, or when it could not begin and `open` was never called."""
