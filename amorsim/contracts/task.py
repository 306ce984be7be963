"""What a task is: what a learner observes, what it is rewarded for, and when an episode ends; arrays over rows."""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping
from typing import NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts.robot import RobotModel
from amorsim.contracts.values import Estimate, Measurement, State
from amorsim.core.draws import Draws
from amorsim.core.maps.map import Map
from amorsim.core.parameters import parameter

__all__ = ["Observable", "StepOutcome", "Task", "TrueState"]


class Observable(NamedTuple):
    """What the robots know, a row for each environment. Observations are made of this alone."""

    robot: RobotModel  # nominal parameters, and the map if the robots know one
    readings: Mapping[str, Measurement]  # by sensor, as measured
    estimate: Estimate  # of the pose, by the robot's own estimator
    action: Array  # (N, a) the last one; 0 at the start


class TrueState(NamedTuple):
    """What is true, a row for each environment. Rewards and ends of episodes are made of this."""

    pose: Array  # (N, 3) [m, m, rad]
    twist: Array  # (N, 3) [m/s, m/s, rad/s], in the robot's frame
    is_touching: Bools  # (N,) whether it touched something in the last step
    map_of: Callable[[int], Map]  # of a row
    pose_of: Callable[[str], Array]  # (N, 3) of the robot or obstacle of a name, in each row's world
    part_pose: Array  # (N, p, 3) of the robot's parts, such as trailers
    lines: tuple[Array, ...]  # the lines on the floor, each (M, 2) [m], a closed one with its first point again


class StepOutcome(NamedTuple):
    """The judgement of a step, a row for each environment."""

    reward: Array  # (N,)
    is_terminated: Bools  # (N,) whether the episode ends by what happened: the goal reached, a collision
    is_success: Bools  # (N,) whether the task is done


@attrs.frozen(kw_only=True)
class Task(abc.ABC):
    """A task for a learner. Its fields are its parameters.

    Rows are environments. A row's results must depend on that row alone: then environment k has the same bits whether
    it runs alone or among a thousand.
    """

    speed: float = parameter(0.5, unit="m/s", gt=0, help="forward speed of the action 1")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="turn rate of the action 1")
    horizon: float = parameter(30.0, unit="s", gt=0, help="after this time an episode is truncated")
    period: float = parameter(0.1, unit="s", gt=0, help="time from one action to the next, whole steps of the scenario")

    @property
    def action_bounds(self) -> tuple[Array, Array]:
        """The least and greatest actions `(a,)`."""
        return np.array([-1.0, -1.0]), np.array([1.0, 1.0])

    def velocities(self, actions: Array) -> tuple[Array, Array, Array]:
        """Velocities for actions `(N, a)` within the bounds: forward [m/s], turn [rad/s], left [m/s], each `(N,)`."""
        return self.speed * actions[:, 0], self.turn_rate * actions[:, 1], np.zeros(len(actions))

    @abc.abstractmethod
    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """The least and greatest observations `(k,)`."""

    @abc.abstractmethod
    def begin(self, truth: TrueState, draws: Draws) -> State:
        """The state that the task keeps for new episodes of these rows; `draws` are of environment and episode."""

    def episode_for(self, goals: Array) -> State:
        """The state that `observe` needs for given goals `(N, 2)` [m], where a policy drives in a scenario.

        A task without goals leaves it as it is.
        """
        return {"goal": goals}

    @abc.abstractmethod
    def observe(self, known: Observable, episode: State) -> Array:
        """The observations `(N, k)`."""

    @abc.abstractmethod
    def judge(self, truth: TrueState, episode: State) -> StepOutcome:
        """The outcome of the last step; it may change the arrays of `episode`, row by row."""

    def privileged(self, truth: TrueState, episode: State) -> Array:
        """True quantities for a critic `(N, p)`: by default the true pose and twist."""
        return np.concatenate((truth.pose, truth.twist), axis=1)
