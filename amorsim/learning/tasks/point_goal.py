"""A goal in a building: drive there by odometry and a laser, without touching anything."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Draws, RobotModel, parameter
from amorsim.core.free_places import free_places
from amorsim.core.map import Map
from amorsim.learning.contracts import Episode, Known, Outcome, Task, Truth

__all__ = ["PointGoal"]

Array = npt.NDArray[np.float64]

_TRIES = 64  # places that are drawn for a goal: the first one that is far and near enough is taken


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
        Least and greatest distance of the goal from the start [m].
    clearance
        Distance of goals from walls, at least [m].
    """

    sensor: str = parameter("laser", help="range sensor that is observed")
    tolerance: float = parameter(0.4, unit="m", gt=0, help="true distance at which the goal is reached")
    distance: Sequence[float] = parameter((1.0, 4.0), unit="m", help="least and greatest distance of goals")
    clearance: float = parameter(0.5, unit="m", ge=0, help="distance of goals from walls, at least")
    success_reward: float = parameter(10.0, help="at the goal")
    collision_reward: float = parameter(-10.0, help="for touching anything")
    time_reward: float = parameter(-0.1, unit="1/s", help="for each second")

    @property
    def _farthest(self) -> float:
        """Distance [m] that is observed at most."""
        return 3.0 * self.distance[1]

    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """Distance [m], cosine and sine of the bearing, the last action, ranges from 0 to 1."""
        beams = robot.sensors[self.sensor].size
        low = np.concatenate(([0.0, -1.0, -1.0, -1.0, -1.0], np.zeros(beams)))
        return low, np.concatenate(([self._farthest, 1.0, 1.0, 1.0, 1.0], np.ones(beams)))

    def begin(self, truth: Truth, draws: Draws) -> Episode:
        """Goals, drawn from the free places of each world."""
        uniform = draws.uniform(_TRIES)
        rows = np.arange(len(uniform))
        worlds = [truth.map_of(row) for row in rows.tolist()]
        tried = np.empty((len(rows), _TRIES, 2))
        for world in {id(one): one for one in worlds}.values():
            here = np.array([one is world for one in worlds])
            places = _goals_in(world, self.clearance)
            tried[here] = places[np.minimum((uniform[here] * len(places)).astype(np.int64), len(places) - 1)]
        near, far = self.distance
        away = np.hypot(*np.moveaxis(tried - truth.pose[:, None, :2], 2, 0))
        outside = np.maximum(np.maximum(near - away, away - far), 0.0)
        goals = tried[rows, np.argmin(outside, axis=1)]  # the first within, or else the one that is nearest to that
        return {"goal": goals, "distance": np.hypot(*(goals - truth.pose[:, :2]).T)}

    def observe(self, known: Known, episode: Episode) -> Array:
        """The observations `(N, 5 + beams)`."""
        model = known.robot.sensors[self.sensor]
        longest = np.asarray(getattr(model.sensor, "range_max")).reshape(-1, 1)  # noqa: B009 - of range sensors alone
        ranges = known.readings[self.sensor].measured / longest
        pose = known.estimate.pose
        east, north = (episode["goal"] - pose[:, :2]).T
        bearing = np.arctan2(north, east) - pose[:, 2]
        away = np.minimum(np.hypot(east, north), self._farthest)
        goal = np.column_stack((away, np.cos(bearing), np.sin(bearing)))
        ranges = np.where(ranges < 1.0, ranges, 1.0)  # no return, and no reading yet, are the longest too
        return np.concatenate((goal, known.action, np.maximum(ranges, 0.0)), axis=1)

    def judge(self, truth: Truth, episode: Episode) -> Outcome:
        """Reward for coming nearer, for the goal, and for touching something."""
        before = episode["distance"]
        distance = np.hypot(*(episode["goal"] - truth.pose[:, :2]).T)
        episode["distance"] = distance
        reached = (distance <= self.tolerance) & ~truth.is_touching
        reward = before - distance + self.time_reward * self.period
        reward += np.where(reached, self.success_reward, 0.0)
        reward += np.where(truth.is_touching, self.collision_reward, 0.0)
        return Outcome(reward, reached | truth.is_touching, reached)


@functools.lru_cache(maxsize=256)
def _goals_in(world: Map, clearance: float) -> Array:
    """Free places `(M, 2)` [m] that far from all walls."""
    return free_places(world, clearance)[0]
