"""A line on the floor to follow, by sensors that look down."""

from __future__ import annotations

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Draws, Observable, RobotModel, State, StepOutcome, Task, TrueState, parameter
from amorsim.core.errors import ComponentError
from amorsim.tasks.observed import sensor_of

__all__ = ["FollowLine"]


@attrs.frozen(kw_only=True)
class FollowLine(Task):
    """Drive along a line on the floor, as far as it goes or once round.

    It observes the reflectances that a sensor measures of the floor, from 0 to 1, and the last action.

    It is rewarded with the share of the line that it went along, times `success_reward`, less where it went back; and
    with `lost_reward` if it is farther than `width` from the line, which ends the episode. It has succeeded, and the
    episode ends, when it has gone along as much as the line is long. A shorter way across, to another piece of the
    line, counts for nothing.

    Parameters
    ----------
    sensor
        Name of the sensor that looks at the floor.
    line
        Which of the floor's lines, from 0.
    width
        True distance from the line at which it is lost [m].
    """

    sensor: str = parameter("line", help="sensor that looks at the floor")
    line: int = parameter(0, ge=0, help="which of the floor's lines")
    width: float = parameter(0.06, unit="m", gt=0, help="true distance from the line at which it is lost")
    success_reward: float = parameter(10.0, help="for the whole of the line")
    lost_reward: float = parameter(-1.0, help="for losing the line")

    def bounds(self, robot: RobotModel) -> tuple[Array, Array]:
        """Reflectances from 0 to 1, and the last action."""
        sensor_of("follow_line", robot, self.sensor, "line")
        elements = robot.sensors[self.sensor].size
        return np.concatenate((np.zeros(elements), [-1.0, -1.0])), np.ones(elements + 2)

    def begin(self, truth: TrueState, draws: Draws) -> State:
        """State: where along the line the robot begins [m], and how far it has come."""
        if self.line >= len(truth.lines):
            raise ComponentError(
                f"follow_line: line: expected one of the {len(truth.lines)} lines on the floor, from 0, "
                f"got {self.line}; a line is one of [[floor.markings]] with points"
            )
        _, along = _place_on(truth.lines[self.line], truth.pose[:, :2])
        return {"along": along, "way": np.zeros(len(along))}

    def observe(self, known: Observable, episode: State) -> Array:
        """The observations `(N, elements + 2)`; no reading yet is 0."""
        floor = np.nan_to_num(known.readings[self.sensor].measured, nan=0.0, posinf=1.0, neginf=0.0)
        return np.concatenate((floor.clip(0.0, 1.0), known.action), axis=1)

    def judge(self, truth: TrueState, episode: State) -> StepOutcome:
        """Reward for the way along the line, and for losing it."""
        line = truth.lines[self.line]
        length = float(np.hypot(*np.diff(line, axis=0).T).sum())
        off, along = _place_on(line, truth.pose[:, :2])
        way = along - episode["along"]
        if (line[0] == line[-1]).all():
            way -= length * np.round(way / length)
        way = np.where(np.abs(way) <= 4.0 * self.speed * self.period, way, 0.0)
        episode["along"] = along
        episode["way"] += way
        lost = (off > self.width) | truth.is_touching
        done = (episode["way"] >= length - 1e-9) & ~lost
        reward = self.success_reward * way / length + np.where(lost, self.lost_reward, 0.0)
        return StepOutcome(reward, lost | done, done)


def _place_on(line: Array, places: Array) -> tuple[Array, Array]:
    """How far places `(N, 2)` are from a line `(M, 2)`, and how far along it their nearest point is [m]."""
    start, piece = line[:-1], np.diff(line, axis=0)
    length = np.hypot(*piece.T)
    to_place = places[:, None] - start
    share = np.clip((to_place * piece).sum(axis=2) / length**2, 0.0, 1.0)
    off = np.hypot(*np.moveaxis(to_place - share[:, :, None] * piece, 2, 0))
    nearest = off.argmin(axis=1)
    row = np.arange(len(places))
    before = np.concatenate(([0.0], np.cumsum(length)[:-1]))
    return off[row, nearest], (before + share * length)[row, nearest]
