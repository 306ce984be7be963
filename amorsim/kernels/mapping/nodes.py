"""Maps drawn from the scans of a graph's nodes."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.kernels.compile import kernel
from amorsim.kernels.kinematics.poses import displaced
from amorsim.kernels.mapping.occupancy import Evidence, add_evidence
from amorsim.kernels.mapping.scan_cells import Area, Window, see

__all__ = ["add_nodes"]


@kernel
def add_nodes(
    area: Area,
    origin: Array,
    poses: Array,
    ranges: Array,
    mount: Array,
    cos_b: Array,
    sin_b: Array,
    range_max: float,
    evidence: Evidence,
    window: Window,
    at: Array,
    log_odds: npt.NDArray[np.float32],
) -> None:
    """Add the scans (n, k) of nodes at `poses` (n, 3) to one map (rows * cols,) of log-odds; `at` is room for a pose.

    Parameters
    ----------
    origin
        x, y [m] of the map's lower left corner, (2,).
    mount
        Of the laser on the robot, (3,).
    """
    for i in range(poses.shape[0]):
        at[0], at[1], at[2] = displaced(poses[i, 0], poses[i, 1], poses[i, 2], mount[0], mount[1], mount[2])
        row, col = see(area, origin, at, ranges[i], cos_b, sin_b, range_max, window)
        add_evidence(area, window, row, col, evidence, log_odds)
