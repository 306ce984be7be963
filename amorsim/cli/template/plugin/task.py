"""A task for learners: drive as far as possible, and touch nothing."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["DriveOn"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class DriveOn(am.Task):
    """Drive as far as possible without touching anything.

    It observes the ranges of a laser as measured, over the laser's range, and the last action. It is rewarded with the
    metres that it drives forward, and ends where it touches anything.
    """

    sensor: str = am.parameter("laser", help="range sensor that is observed")
    collision_reward: float = am.parameter(-5.0, help="for touching anything")

    def bounds(self, robot: am.RobotModel) -> tuple[Array, Array]:
        """Ranges from 0 to 1, and the last action."""
        beams = robot.sensors[self.sensor].size
        return np.concatenate((np.zeros(beams), [-1.0, -1.0])), np.ones(beams + 2)

    def begin(self, truth: am.TrueState, draws: am.Draws) -> am.State:
        """Nothing is kept of an episode; a task with a goal draws it here."""
        return {}

    def observe(self, known: am.Observable, episode: am.State) -> Array:
        """Of what the robot knows alone: never of the truth."""
        sensor = known.robot.sensors[self.sensor].sensor
        longest = np.asarray(getattr(sensor, "range_max")).reshape(-1, 1)  # noqa: B009 - of range sensors alone
        ranges = known.readings[self.sensor].measured / longest
        ranges = np.where(ranges < 1.0, ranges, 1.0)  # no return is the longest, too
        return np.concatenate((np.maximum(ranges, 0.0), known.action), axis=1)

    def judge(self, truth: am.TrueState, episode: am.State) -> am.StepOutcome:
        """Rewards and ends are made of what is true; nothing counts as done, as the way has no end."""
        reward = np.maximum(truth.twist[:, 0], 0.0) * self.period
        reward = reward + np.where(truth.is_touching, self.collision_reward, 0.0)
        return am.StepOutcome(reward, truth.is_touching, np.zeros(len(reward), dtype=bool))
