"""Odometry from scans: each is matched with a key scan before it."""

from __future__ import annotations

from collections.abc import Mapping

import attrs

from amorsim.array_types import Array
from amorsim.contracts import Context, Draws, Estimate, Measurement, RobotModel, State
from amorsim.estimators.scan_tracking import ScanTracker

__all__ = ["ScanMatching"]


@attrs.frozen(kw_only=True)
class ScanMatching(ScanTracker):
    """Follows the robot by its wheels, and corrects the pose by matching each scan with a key scan.

    Two stages: the correlative one weighs all poses of a window around the wheels' pose; from the best of them,
    iterative closest points lay the scan's points onto the key scan's lines. The result is put together with what the
    wheels give, each by its information. Where a scan does not determine the pose, as in a corridor or a round room, it
    reports that (`match_degenerate`), and the wheels alone count in that direction.

    Its errors add up from key to key, slowly: nothing recognises a place that was seen before. The fields are those of
    every estimator that follows scans.
    """

    def start(self, context: Context) -> State:
        """The pose and covariance, the joints, and room for the last key scan.

        Raises
        ------
        ComponentError
            If a sensor is missing or of another kind.
        """
        return self._begin("scan_matching", context)

    def update(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        command: Array,
        elapsed: Array,
        state: State,
        draws: Draws,
    ) -> Estimate:
        """The estimate after this step's motion and scan."""
        self._follow("scan_matching", robot, readings, state)
        return self._estimate(state)
