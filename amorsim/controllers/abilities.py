"""Shared by controllers: the abilities of a drive, and the direction in which it goes ahead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Bools
from amorsim.contracts import Estimate, Measurement, RobotModel, State
from amorsim.contracts.joints import at_rest, joints_of
from amorsim.core.errors import ComponentError
from amorsim.core.poses import compose
from amorsim.kernels.behaviours.go_to_pose import head_for

__all__ = [
    "Course",
    "abilities",
    "command_along",
    "curvature_max",
    "heading_poses",
    "needs_turning_in_place",
    "twist_limits",
]


def heading_poses(robot: RobotModel, poses: Array, joints: Array) -> Array:
    """The same poses `(N, 3)`, with the heading in which the drive goes ahead (`Drive.heading_offset`)."""
    course = robot.drive.heading_offset(joints)
    if course is None:
        return poses
    turned = np.zeros((robot.rows, 3))
    turned[:, 2:3] = course
    return compose(poses, turned)


def command_along(robot: RobotModel, twists: Array, joints: Array) -> Array:
    """The command `(N, c)` for `twists` `(N, 3)` given along the drive's course."""
    course = robot.drive.heading_offset(joints)
    if course is not None:
        turned, way = np.zeros((robot.rows, 3)), twists.copy()
        turned[:, 2:3] = course
        way[:, 2] = 0.0
        twists = np.concatenate((compose(turned, way)[:, :2], twists[:, 2:]), axis=1)
    return robot.drive.command_for(np.ascontiguousarray(twists), joints)


@attrs.frozen
class Course:
    """The course of robots that drive by their estimate, for one step: heading and poses, and commands along it."""

    robot: RobotModel
    joints: Array  # (N, j) from `joints_of`
    poses: Array  # (N, 3) estimated, with the heading in which the drive goes

    @classmethod
    def of(cls, robot: RobotModel, readings: Mapping[str, Measurement], estimate: Estimate) -> Course:
        """The course of this step."""
        joints = joints_of(robot, readings)
        return cls(robot, joints, heading_poses(robot, estimate.pose, joints))

    def head_for(
        self, goal: Array, speed: Any, turn_rate: Any, tolerance: Sequence[Any], dt: float, state: State
    ) -> tuple[Array, Bools]:
        """Twists `(N, 3)` towards poses `goal` `(N, 3)`, whose heading may be nan, and which robots arrived `(N, 1)`.

        `tolerance` is of the position [m], of the heading [rad], and of the bearing [rad]: a larger error of the
        bearing is corrected in place. Each is a number or `(N, 1)`. ``state`` is from `abilities`.
        """
        near = np.empty((self.robot.rows, 3))
        for column, value in enumerate(tolerance):
            near[:, column : column + 1] = value
        out = np.empty((self.robot.rows, 4))
        head_for(
            self.poses,
            np.ascontiguousarray(goal),
            speed,
            turn_rate,
            near,
            state["limits"],
            state["lag"],
            dt,
            state["moving"],
            state["turning"],
            out,
        )
        return np.ascontiguousarray(out[:, :3]), out[:, 3:] > 0.0

    def command(self, twists: Array) -> Array:
        """The command `(N, c)` for `twists` `(N, 3)` along it."""
        return command_along(self.robot, twists, self.joints)


def abilities(robot: RobotModel) -> State:
    """State that a driving controller keeps: the limits of the drive, and its motion by the controller's own account.

    ``"limits"`` as `twist_limits`, ``"curvature"`` as `curvature_max`, ``"lag"`` `(N, 1)` [s] of its motors;
    ``"moving"`` `(N, 2)`, the speed [m/s] and whether it turns in place, and ``"turning"`` `(N, 1)` [rad/s], at rest.
    """
    return {
        "limits": twist_limits(robot),
        "curvature": np.array(curvature_max(robot)),
        "lag": np.zeros((robot.rows, 1)) + getattr(robot.drive, "lag", 0.0),
        "moving": np.zeros((robot.rows, 2)),
        "turning": np.zeros((robot.rows, 1)),
    }


def curvature_max(robot: RobotModel) -> Array:
    """Largest curvature that the drive can follow `(N, 1)` [1/m]; inf where it turns in place."""
    sharpest = robot.drive.curvature_max()
    return np.full((robot.rows, 1), np.inf) if sharpest is None else sharpest


def needs_turning_in_place(robot: RobotModel, name: str) -> None:
    """Raise `ComponentError` for robots that cannot turn in place, on behalf of the controller `name`."""
    stiff = np.flatnonzero(np.isfinite(curvature_max(robot)[:, 0]))
    if len(stiff):
        raise ComponentError(
            f"{name} turns in place, which {robot.who(int(stiff[0]))} cannot: its drive, "
            f"{type(robot.drive).__name__}, has a smallest radius of "
            f"{1.0 / float(curvature_max(robot)[stiff[0], 0]):.3g} m. Take 'pursuit' along waypoints"
        )


def twist_limits(robot: RobotModel) -> Array:
    """Top speed [m/s] and turning rate [rad/s], and the largest change of each [m/s^2, rad/s^2], `(N, 4)`.

    They come from the drive, or from its `rate_max` and `acceleration_max`; inf where it has none.
    """
    speeds = robot.drive.top_speeds()
    if speeds is not None:
        return np.array(speeds)
    joints = at_rest(robot)
    out = np.full((robot.rows, 4), np.inf)
    for column, axis in ((0, 0), (1, 2)):
        twist = np.zeros((robot.rows, 3))
        twist[:, axis] = 1.0
        rates = np.abs(robot.drive.command_for(twist, joints)).max(axis=1)
        for offset, name in ((0, "rate_max"), (2, "acceleration_max")):
            limit = getattr(robot.drive, name, None)
            if limit is not None:
                out[:, column + offset] = limit[:, 0] / rates
    return out
