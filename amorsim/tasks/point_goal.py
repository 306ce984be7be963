"""A goal in a building: drive there by odometry and a laser, without touching anything."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Observable, RobotModel, State, StepOutcome, Task, TrueState, parameter
from amorsim.kernels.sensing.readings import range_and_bearing
from amorsim.tasks.goals import goal_within
from amorsim.tasks.observed import beams_of, with_ranges

__all__ = ["PointGoal"]


@attrs.frozen(kw_only=True)
class PointGoal(Task):
    """Reach a place in the world, drawn for each episode, without touching anything.

    It observes the goal in the robot's frame **by its own estimate**: distance, cosine and sine of the bearing; the
    last action; and the ranges of a laser as measured, divided by the laser's range. So a robot whose wheels are not
    what it believes is led astray, as a real one is.

    It is rewarded with the metres by which it came nearer to the goal, `success_reward` at the goal, and with
    `collision_reward` if it touches anything, which ends the episode; and with `time_reward` for each second.

    Parameters
    ----------
    sensor
        Name of the range sensor that is observed.
    tolerance
        True distance from the goal at which it is reached [m].
    distance
        Least and greatest length of the way from the start to the goal [m].
    clearance, way_clearance
        Distance of goals, and of the ways to them, from walls, at least [m].
    """

    sensor: str = parameter("laser", help="range sensor that is observed")
    tolerance: float = parameter(0.4, unit="m", gt=0, help="true distance at which the goal is reached")
    distance: tuple[float, float] = parameter(
        (1.0, 4.0), unit="m", help="least and greatest length of the way to the goal"
    )
    clearance: float = parameter(0.5, unit="m", ge=0, help="distance of goals from walls, at least")
    way_clearance: float = parameter(0.3, unit="m", ge=0, help="distance from walls of the way to a goal, at least")
    success_reward: float = parameter(10.0, help="at the goal")
    collision_reward: float = parameter(-10.0, help="for touching anything")
    time_reward: float = parameter(-0.1, unit="1/s", help="for each second")

    @property
    def _farthest(self) -> float:
        """Distance [m] that is observed at most."""
        return 3.0 * self.distance[1]

    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """Distance [m], cosine and sine of the bearing, the last action, ranges from 0 to 1."""
        beams = beams_of("point_goal", robot, self.sensor)
        low = np.concatenate(([0.0, -1.0, -1.0, -1.0, -1.0], np.zeros(beams)))
        return low, np.concatenate(([self._farthest, 1.0, 1.0, 1.0, 1.0], np.ones(beams)))

    def begin(self, truth: TrueState, draws: Draws) -> State:
        """Goals, drawn among the free places of each world by the length of the way there."""
        uniform = draws.uniform(1)[:, 0]
        goals = np.array(
            [
                goal_within(
                    truth.map_of(row),
                    truth.pose[row, :2],
                    *self.distance,
                    float(uniform[row]),
                    clearance=self.clearance,
                    way_clearance=self.way_clearance,
                )
                for row in range(len(uniform))
            ]
        )
        return {"goal": goals, "distance": np.hypot(*(goals - truth.pose[:, :2]).T)}

    def observe(self, known: Observable, episode: State) -> Array:
        """The observations `(N, 5 + beams)`."""
        found = with_ranges(5, known, self.sensor)
        range_and_bearing(known.estimate.pose, episode["goal"], self._farthest, found)
        found[:, 3:5] = known.action
        return found

    def judge(self, truth: TrueState, episode: State) -> StepOutcome:
        """Reward for coming nearer, for the goal, and for touching something."""
        before = episode["distance"]
        east, north = (episode["goal"] - truth.pose[:, :2]).T
        distance = np.hypot(east, north)
        episode["distance"] = distance
        reached = (distance <= self.tolerance) & ~truth.is_touching
        reward = before - distance + self.time_reward * self.period
        reward += self.success_reward * reached
        reward += self.collision_reward * truth.is_touching
        return StepOutcome(reward, reached | truth.is_touching, reached)
