"""Pushing a trailer backwards along a path: the hitch angle that bends its way as wanted, and the twist for that.

An inner loop controls the hitch angle, so that the trailer's axle drives like a robot of its own; an outer loop leads
that axle along its path, as pure pursuit leads a robot. After C. Pradalier and K. Usher, "Robust trajectory tracking
for a reversing tractor trailer", Journal of Field Robotics 25 (6-7), 2008, and N. Evestedt, O. Ljungqvist and D.
Axehill, "Path tracking and stabilization for a reversing general 2-trailer configuration using a cascaded control
approach", IEEE Intelligent Vehicles Symposium, 2016.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import RobotModel

__all__ = ["Trailer"]


_SETTLES = 0.5  # trailer's lengths of way within which an error of the hitch angle falls to a third
_LOOKS = 1.0  # trailer's lengths that it looks ahead at least; with an inner loop of `_SETTLES` stable above 0.5
_PART = 0.8  # of the hitch's range that is used on purpose; the rest is for errors
_WIDEST = 1.2  # [rad] as if the hitch's range were no larger
_PHASE = 0.5  # of the way within which the hitch settles that may be driven in the time that the motors lag


class Trailer(NamedTuple):
    """A trailer by its nominal measures, on a hitch whose angle is known."""

    length: float
    """[m] from the hitch to the trailer's axle."""
    offset: float
    """[m] of the hitch behind the robot's base point."""
    hitch: float
    """[rad] the robot's heading less the trailer's."""
    hitch_max: float
    """[rad]"""

    @classmethod
    def column(cls, robot: RobotModel) -> int | None:
        """The index of the joint that is the hitch, for drives that draw a trailer; None for all others."""
        if getattr(robot.drive, "trailer_length", None) is None:
            return None
        names = [joint.name for joint in robot.drive.joints]
        return names.index("hitch") if "hitch" in names else None

    @classmethod
    def of(cls, robot: RobotModel, joints: Array, row: int, column: int) -> Trailer:
        """The trailer of a robot with these joints `(N, j)` [rad]; `column` is that of the hitch."""
        drive: Any = robot.drive
        numbers = (drive.trailer_length, drive.hitch_offset, joints[:, column : column + 1], drive.hitch_max)
        return cls(*(float(np.broadcast_to(number, (robot.rows, 1))[row, 0]) for number in numbers))

    def axle(self, pose: Array) -> Array:
        """The pose (1, 3) of its axle behind a robot at `pose` (1, 3)."""
        x, y, heading = pose[0].tolist()
        back = heading - self.hitch
        return np.array(
            [
                [
                    x - self.offset * math.cos(heading) - self.length * math.cos(back),
                    y - self.offset * math.sin(heading) - self.length * math.sin(back),
                    back,
                ]
            ]
        )

    @property
    def curvature_max(self) -> float:
        """The sharpest bend [1/m] that its axle drives on purpose."""
        widest = _PART * min(self.hitch_max, _WIDEST)
        return math.sin(widest) / max(self.length * math.cos(widest) + self.offset, 1e-3)

    @property
    def looks(self) -> float:
        """[m] how far ahead on its path it looks at least."""
        return _LOOKS * self.length

    def speed_max(self, delay: float) -> float:
        """The top speed [m/s] at which the hitch still settles, if commands act `delay` [s] late."""
        return _PHASE * _SETTLES * self.length / delay

    def twist(self, speed: float, bend: float, turn_rate: float) -> tuple[float, float]:
        """The robot's twist, v [m/s] and w [rad/s], that lets the axle drive at `speed` [m/s] along `bend` [1/m].

        In a steady bend the hitch angle b holds sin b = bend (l cos b + c). From there it is off by an error, which
        falls with the way driven. Robots slow down where they would turn faster than `turn_rate` [rad/s].
        """
        flat = bend * self.length
        wanted = math.atan(flat) + math.asin(min(max(bend * self.offset / math.hypot(1.0, flat), -1.0), 1.0))
        fold = (wanted - self.hitch) * abs(speed) / (_SETTLES * self.length)  # [rad/s] of the hitch
        # b' = w - (v / l) sin b + (c w / l) cos b, as in the drive.
        lever = 1.0 + self.offset / self.length * math.cos(self.hitch)
        turn = (fold + speed / self.length * math.sin(self.hitch)) / max(lever, 0.1)
        slower = min(1.0, turn_rate / abs(turn)) if turn != 0.0 else 1.0
        return slower * speed, slower * turn
