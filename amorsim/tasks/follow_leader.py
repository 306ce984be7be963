"""A leader to follow: keep at a distance from somebody who carries a mark."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Observable, RobotModel, State, StepOutcome, Task, TrueState, parameter
from amorsim.core.errors import ComponentError
from amorsim.tasks.observed import beams_of, sensor_of, with_ranges

__all__ = ["FollowLeader"]


@attrs.frozen(kw_only=True)
class FollowLeader(Task):
    """Keep at a distance from a leader, another robot or an obstacle that moves, without touching anything.

    It observes whether the leader's mark is seen, its range as a share of the longest, cosine and sine of its bearing,
    all as measured by a finder of marks; the last action; and the ranges of a laser, divided by the laser's range.

    For each second it is rewarded with 1 at the distance `gap`, less where it is nearer or farther, down to -1; and
    with `failure_reward` if it touches anything or is farther than `farthest`, which ends the episode. It has succeeded
    if it is within `tolerance` of the gap when its time is over.

    Parameters
    ----------
    leader
        Name of the robot or obstacle that is followed.
    mark
        What is written on the leader's mark.
    finder
        Name of the sensor that finds marks.
    sensor
        Name of the range sensor that is observed, or "" for none.
    gap
        Distance to the leader's base point that is kept [m].
    tolerance
        How far from that the distance may be at the end [m].
    farthest
        Distance at which the leader is lost [m].
    """

    leader: str = parameter("leader", help="robot or obstacle that is followed")
    mark: int = parameter(1, ge=1, help="what is written on the leader's mark")
    finder: str = parameter("fiducial", help="sensor that finds marks")
    sensor: str = parameter("laser", help="range sensor that is observed, or none")
    gap: float = parameter(1.2, unit="m", gt=0, help="distance to the leader that is kept")
    tolerance: float = parameter(0.5, unit="m", gt=0, help="how far from the gap the distance may be at the end")
    farthest: float = parameter(4.0, unit="m", gt=0, help="distance at which the leader is lost")
    failure_reward: float = parameter(-10.0, help="for touching anything, and for losing the leader")

    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """Seen or not, share of the range, cosine and sine of the bearing, the last action, ranges from 0 to 1."""
        finder = sensor_of("follow_leader", robot, self.finder, "fiducial")
        if list(finder.columns() or ()) != ["range", "bearing", "id"]:
            raise ComponentError(
                f"follow_leader: finder: a {type(finder).__name__} does not tell range, bearing and identity of marks; "
                "a 'fiducial' does"
            )
        beams = beams_of("follow_leader", robot, self.sensor)
        low = np.concatenate(([0.0, 0.0, -1.0, -1.0, -1.0, -1.0], np.zeros(beams)))
        return low, np.ones(6 + beams)

    def begin(self, truth: TrueState, draws: Draws) -> State:
        """Nothing is drawn; the leader is where the scenario has it."""
        truth.pose_of(self.leader)  # refuses a name that there is not
        return {}

    def observe(self, known: Observable, episode: State) -> Array:
        """The observations `(N, 6 + beams)`."""
        rows = len(known.action)
        table = known.readings[self.finder].measured.reshape(rows, -1, 3)
        is_leader = (table[:, :, 2] == self.mark) & np.isfinite(table[:, :, 0])
        found = table[np.arange(rows), np.argmax(is_leader, axis=1)]
        longest = np.asarray(getattr(known.robot.sensors[self.finder].sensor, "range_max")).reshape(-1)  # noqa: B009
        seen = is_leader.any(axis=1)
        away = np.where(seen, found[:, 0] / longest, 0.0).clip(0.0, 1.0)
        bearing = np.where(seen, found[:, 1], 0.0)
        observed = with_ranges(6, known, self.sensor)
        observed[:, 0], observed[:, 1] = seen, away
        observed[:, 2], observed[:, 3] = seen * np.cos(bearing), seen * np.sin(bearing)
        observed[:, 4:6] = known.action
        return observed

    def judge(self, truth: TrueState, episode: State) -> StepOutcome:
        """Reward for the distance to the leader, and for losing it or touching something."""
        away = np.hypot(*(truth.pose_of(self.leader) - truth.pose)[:, :2].T)
        off = np.abs(away - self.gap)
        failed = truth.is_touching | (away > self.farthest)
        reward = np.maximum(1.0 - off / self.gap, -1.0) * self.period
        reward += np.where(failed, self.failure_reward, 0.0)
        return StepOutcome(reward, failed, (off <= self.tolerance) & ~failed)
