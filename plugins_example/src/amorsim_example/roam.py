"""A task for learners: drive about, and keep away from everything."""

from __future__ import annotations

import attrs
import numpy as np
import numpy.typing as npt

import amorsim as am

__all__ = ["Roam"]

Array = npt.NDArray[np.float64]


@attrs.frozen(kw_only=True)
class Roam(am.Task):
    """Drive as far as possible without touching anything, by the ranges of a laser.

    Parameters
    ----------
    sensor
        Name of the range sensor that is observed.
    longest
        Longer ranges are observed as this [m].
    """

    sensor: str = am.parameter("laser", help="range sensor that is observed")
    longest: float = am.parameter(8.0, unit="m", gt=0, help="longer ranges are observed as this")

    def bounds(self, robot: am.RobotModel) -> tuple[Array, Array]:
        """Ranges from 0 to the longest."""
        beams = robot.sensors[self.sensor].size
        return np.zeros(beams), np.full(beams, self.longest)

    def begin(self, truth: am.TrueState, draws: am.Draws) -> am.State:
        """Nothing is drawn."""
        return {}

    def observe(self, known: am.Observable, episode: am.State) -> Array:
        """The ranges as measured; a beam without a return, or without a reading yet, is the longest."""
        ranges = known.readings[self.sensor].measured
        return np.clip(np.nan_to_num(ranges, nan=self.longest, posinf=self.longest, neginf=0.0), 0.0, self.longest)

    def judge(self, truth: am.TrueState, episode: am.State) -> am.StepOutcome:
        """The way ahead is rewarded [m]; an episode ends where something is touched, and nothing is a success."""
        ahead = truth.twist[:, 0] * self.period
        return am.StepOutcome(ahead, truth.is_touching, np.zeros(len(ahead), dtype=bool))
