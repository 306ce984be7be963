"""A bay to park in: a pose that a car, or a trailer, is to be brought to."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Observable, RobotModel, State, StepOutcome, Task, TrueState, parameter
from amorsim.contracts.joints import joints_of
from amorsim.core.errors import ComponentError
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import compose
from amorsim.kernels import elementary
from amorsim.tasks.observed import beams_of, from_robot, with_ranges

__all__ = ["Park"]


_FARTHEST = 40.0  # [m] that is observed


@attrs.frozen(kw_only=True)
class Park(Task):
    """Bring the robot, or its trailer, to one of some poses, without touching anything.

    Its actions are the speed and the bend of the way, so they fit a car: the turn rate is the speed times the
    curvature. It observes the goal from the robot or its trailer **by its own estimate**: how far ahead and to the
    left, cosine and sine of the heading to be reached; of a robot with a trailer also cosine and sine of the hitch as
    measured; the last action; and the ranges of a laser, divided by the laser's range.

    It is rewarded with the metres by which it came nearer, where a radian of the heading counts as `turn_weight`
    metres; with `success_reward` within the tolerances, and with `collision_reward` for touching anything, both of
    which end the episode; and with `time_reward` for each second.

    Parameters
    ----------
    goals
        Places of the bays [m], for the robot's base point or the middle of the trailer's axle. One is drawn for each
        episode.
    headings
        The heading in each [rad].
    towed
        Whether it is the trailer that is to be parked.
    sensor
        Name of the range sensor that is observed, or "" for none.
    curvature
        The bend of the way [1/m] of the action 1.
    tolerance, heading_tolerance
        True distance [m] and angle [rad] from the goal within which the bay is reached.
    """

    goals: tuple[tuple[float, float], ...] = parameter(
        ((0.0, 0.0),), unit="m", frame="world", help="places of the bays, one drawn for each episode"
    )
    headings: tuple[float, ...] = parameter((0.0,), unit="rad", frame="world", help="heading in each bay")
    towed: bool = parameter(False, help="whether the trailer is to be parked")
    sensor: str = parameter("laser", help="range sensor that is observed, or none")
    curvature: float = parameter(0.2, unit="1/m", gt=0, help="bend of the way of the action 1")
    tolerance: float = parameter(0.3, unit="m", gt=0, help="true distance within which the bay is reached")
    heading_tolerance: float = parameter(0.175, unit="rad", gt=0, help="true angle within which it is reached")
    turn_weight: float = parameter(1.0, unit="m/rad", ge=0, help="metres that a radian of the heading counts for")
    success_reward: float = parameter(10.0, help="in the bay")
    collision_reward: float = parameter(-10.0, help="for touching anything")
    time_reward: float = parameter(-0.1, unit="1/s", help="for each second")

    def __attrs_post_init__(self) -> None:
        if not self.goals or len(self.headings) != len(self.goals):
            raise ParameterError("headings", f"expected one for each of {len(self.goals)} goals, at least one")

    def velocities(self, actions: Array) -> tuple[Array, Array, Array]:
        """Forward [m/s], turn [rad/s] and left [m/s]: the speed, and the speed times the curvature."""
        forward = self.speed * actions[:, 0]
        return forward, forward * self.curvature * actions[:, 1], np.zeros(len(actions))

    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """Ahead and left [m], cosine and sine of the heading, of the hitch, the last action, ranges from 0 to 1."""
        beams = beams_of("park", robot, self.sensor)
        goal = [_FARTHEST, _FARTHEST, 1.0, 1.0, *([1.0, 1.0] if self.towed else []), 1.0, 1.0]
        return np.concatenate((-np.array(goal), np.zeros(beams))), np.concatenate((goal, np.ones(beams)))

    def begin(self, truth: TrueState, draws: Draws) -> State:
        """The bay, drawn among those given."""
        if self.towed and truth.part_pose.shape[1] == 0:
            raise ComponentError("park: towed: the robot has no trailer; the drive 'tractor' has one")
        uniform = draws.uniform(1)[:, 0]
        chosen = np.minimum((uniform * len(self.goals)).astype(np.int64), len(self.goals) - 1)
        goal = self._bays[chosen]
        return {"goal": goal, "away": self._away(truth, goal)[2]}

    def episode_for(self, goals: Array) -> State:
        """The first bay, for a policy that drives in a scenario."""
        return {"goal": np.repeat(self._bays[:1], len(goals), axis=0)}

    @property
    def _bays(self) -> Array:
        return np.column_stack((np.array(self.goals), np.array(self.headings)))

    def observe(self, known: Observable, episode: State) -> Array:
        """The observations `(N, 6 + beams)`, of a trailer `(N, 8 + beams)`."""
        pose, parts = known.estimate.pose, []
        if self.towed:
            joints = joints_of(known.robot, known.readings)
            trailer = known.robot.drive.part_poses(joints)[:, 0]
            pose = compose(pose, trailer)
            parts = [np.cos(trailer[:, 2:]), np.sin(trailer[:, 2:])]
        goal = from_robot(pose, episode["goal"])
        goal[:, :2] = goal[:, :2].clip(-_FARTHEST, _FARTHEST)
        columns = np.concatenate((goal, *parts, known.action), axis=1)
        observed = with_ranges(columns.shape[1], known, self.sensor)
        observed[:, : columns.shape[1]] = columns
        return observed

    def judge(self, truth: TrueState, episode: State) -> StepOutcome:
        """Reward for coming nearer, for the bay, and for touching something."""
        distance, angle, away = self._away(truth, episode["goal"])
        reward = episode["away"] - away + self.time_reward * self.period
        episode["away"] = away
        parked = (distance <= self.tolerance) & (angle <= self.heading_tolerance) & ~truth.is_touching
        reward += np.where(parked, self.success_reward, 0.0)
        reward += np.where(truth.is_touching, self.collision_reward, 0.0)
        return StepOutcome(reward, parked | truth.is_touching, parked)

    def _away(self, truth: TrueState, goal: Array) -> tuple[Array, Array, Array]:
        """How far from the goal [m], how much turned from it [rad], and both together [m]."""
        pose = truth.part_pose[:, 0] if self.towed else truth.pose
        ahead, left, cosine, sine = from_robot(pose, goal).T
        distance, angle = np.hypot(ahead, left), np.abs(elementary.arctan2(sine, cosine))
        return distance, angle, distance + self.turn_weight * angle
