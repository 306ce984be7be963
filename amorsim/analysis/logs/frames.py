"""The frames of a robot as ROS has them, each in its parent's, and where one is in another."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from amorsim.array_types import Array
from amorsim.core.errors import AnalysisError
from amorsim.core.poses import Mount

__all__ = ["Frames"]


class Frames:
    """A tree of frames that do not move against one another."""

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Array]] = {}

    def add(self, parent: str, child: str, transform: Any) -> None:
        """Put a frame into its parent's, by a ``geometry_msgs/Transform``."""
        place, turned = transform.translation, transform.rotation
        matrix = np.eye(4)
        matrix[:3, 3] = place.x, place.y, getattr(place, "z", 0.0)
        quaternion = np.array([turned.x, turned.y, turned.z, turned.w], dtype=np.float64)
        if np.isfinite(matrix).all() and np.linalg.norm(quaternion) > 0.0:
            matrix[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
            self._parents[_name(child)] = _name(parent), matrix

    def mount(self, frame: str, base: str, where: str) -> Mount | None:
        """Where a frame is in that of the base, in the plane; None if the tree does not have both.

        Without a name of the base it is the frame at the tree's root.

        Raises
        ------
        AnalysisError
            If it is upside down: then its scans go the other way round.
        """
        frame, base = _name(frame), _name(base)
        if frame not in self._parents:
            return None
        root, placed = self._in_root(frame)
        other, of_base = self._in_root(base) if base else (root, np.eye(4))
        if root != other:
            return None
        matrix = np.linalg.inv(of_base) @ placed
        if matrix[2, 2] < 0.0:
            raise AnalysisError(
                f"{where}: by /tf_static the laser, {frame!r}, hangs upside down, which is not read; expected scans "
                "that go anticlockwise as seen from above"
            )
        return Mount(
            x=float(matrix[0, 3]), y=float(matrix[1, 3]), heading=math.atan2(float(matrix[1, 0]), float(matrix[0, 0]))
        )

    def _in_root(self, frame: str) -> tuple[str, Array]:
        """The root above a frame, and where the frame is in it."""
        matrix = np.eye(4)
        for _ in self._parents:  # not in a circle for ever
            if frame not in self._parents:
                break
            frame, above = self._parents[frame]
            matrix = above @ matrix
        return frame, matrix


def _name(frame: str) -> str:
    return frame.removeprefix("/")  # as ROS 1 may have it
