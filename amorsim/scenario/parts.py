"""Where the parts of a robot are before it moves (`amorsim.contracts.Drive.parts`)."""

from __future__ import annotations

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Drive, Part
from amorsim.core.poses import compose
from amorsim.core.rows import stack
from amorsim.scenario.spec import Pose

__all__ = ["at_start", "parts_at"]


def at_start(drive: Drive) -> Array:
    """Poses `(p, 3)` of the parts of one robot's drive at the start, in the robot's frame: all joints at 0."""
    if not drive.parts:
        return np.empty((0, 3))
    return np.asarray(stack([drive]).part_poses(np.zeros((1, len(drive.joints))))[0])


def parts_at(drive: Drive, pose: Pose) -> list[tuple[Part, Pose]]:
    """The parts of a robot that starts at a pose, and where they are in the world, by its drive's parameters."""
    inside = at_start(drive)
    own = np.repeat([[pose.x, pose.y, pose.heading]], len(inside), axis=0)
    found = compose(own, inside).tolist() if len(inside) else []
    return [(part, Pose(x=x, y=y, heading=h)) for part, (x, y, h) in zip(drive.parts, found, strict=True)]
