"""Following a leader."""

from __future__ import annotations

from collections.abc import Mapping

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.controllers.abilities import Course, abilities
from amorsim.core.errors import ComponentError, did_you_mean
from amorsim.core.poses import compose
from amorsim.kernels.behaviours.pure_pursuit import Pace, follow_trail
from amorsim.kernels.kinematics.poses import directions

__all__ = ["Follow"]


_PLACES = 256  # of the leader's trail that it remembers
_SPACING = 0.05  # [m] between them


@attrs.frozen(kw_only=True)
class Follow(Controller):
    """Follows a leader that carries a mark, along the leader's own trail, at a distance.

    A sensor gives range, bearing and identity of the mark. The robot keeps the places where it saw the mark, by its own
    estimate; it does not know the leader's true pose. It drives along these places by pure pursuit, faster the farther
    behind it is: behind a leader of speed v it settles at `gap` + v / `gain`. Without sight of the leader it drives to
    where it saw it last, and stops after `patience`.

    Parameters
    ----------
    leader
        Identity of the leader's mark.
    sensor
        Name of the sensor that finds marks.
    gap
        Distance that it keeps from the base point of a standing leader [m].
    gain
        Increase of its speed per metre that it is farther behind [1/s].
    speed, turn_rate
        Top speed [m/s] and turning rate [rad/s].
    lookahead
        Distance along the trail to the point that it steers to [m].
    patience
        Time that it goes on without seeing the leader [s].
    """

    leader: int = parameter(1, ge=1, help="what is written on the leader's mark")
    sensor: str = parameter("fiducial", refers="sensors", help="name of the sensor that finds marks")
    gap: float = parameter(0.8, unit="m", gt=0, help="distance that it keeps from the leader when that stands")
    gain: float = parameter(1.0, unit="1/s", gt=0, help="how much faster it drives for each metre farther behind")
    speed: float = parameter(0.6, unit="m/s", gt=0, help="fastest that it drives")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="fastest that it turns")
    lookahead: float = parameter(0.4, unit="m", gt=0, help="how far ahead on the trail it looks")
    patience: float = parameter(5.0, unit="s", gt=0, help="how long it goes on without seeing the leader")

    def start(self, context: Context) -> State:
        """An empty trail, and the robot's knowledge of its drive.

        Raises
        ------
        ComponentError
            If the robot has no such sensor, or it does not measure range, bearing and identity.
        """
        robot = context.robot
        if self.sensor not in robot.sensors:
            names = ", ".join(repr(name) for name in robot.sensors) or "none"
            raise ComponentError(
                f"follow uses the sensor {self.sensor!r}, which {robot.who(0)} does not have; its sensors: {names}."
                f"{did_you_mean(self.sensor, robot.sensors)} Give it a sensor 'fiducial', and name that in the field "
                "'sensor'."
            )
        sensor = robot.sensors[self.sensor].sensor
        columns = list(sensor.columns() or ()) if hasattr(sensor, "columns") else []
        if columns != ["range", "bearing", "id"]:
            raise ComponentError(
                f"follow uses the sensor {self.sensor!r}, but a {type(sensor).__name__} does not tell range, "
                "bearing and identity of marks; a 'fiducial' does."
            )
        rows = context.rows
        return {
            "trail": np.zeros((rows, _PLACES, 2)),
            "memory": np.zeros((rows, 3)),
            **abilities(robot),
        }

    def command(
        self,
        robot: RobotModel,
        readings: Mapping[str, Measurement],
        estimate: Estimate,
        clock: Clock,
        state: State,
        draws: Draws,
    ) -> Array:
        """The command `(N, c)` of this step."""
        course = Course.of(robot, readings, estimate)
        twist = np.empty((robot.rows, 3))
        follow_trail(
            course.poses,
            self._seen(robot, readings[self.sensor], estimate.pose),
            self.gap,
            self.gain,
            self.lookahead,
            Pace(self.speed, self.turn_rate, state["limits"], state["curvature"]),
            self.patience,
            _SPACING,
            clock.dt,
            state["trail"],
            state["memory"],
            state["moving"],
            twist,
        )
        return course.command(twist)

    def _seen(self, robot: RobotModel, reading: Measurement, pose: Array) -> Array:
        """Position of the seen leader `(N, 2)` [m] by the robot's estimate; nan where it is not seen."""
        table = reading.measured.reshape(robot.rows, -1, 3)
        is_leader = (table[:, :, 2] == self.leader) & np.isfinite(table[:, :, 0])
        slot = np.argmax(is_leader, axis=1)
        found = table[np.arange(robot.rows), slot]
        seen = is_leader.any(axis=1, keepdims=True) & (reading.age <= 0.5)
        bearing = np.where(seen, found[:, 1:2], 0.0)
        cos, sin = np.empty_like(bearing), np.empty_like(bearing)
        directions(bearing, cos, sin)
        way = np.where(seen, found[:, 0:1], 0.0)
        mount = robot.sensors[self.sensor].mount
        base = np.empty((robot.rows, 3))
        for column, value in enumerate((mount.x, mount.y, mount.heading)):
            base[:, column : column + 1] = value
        place = compose(compose(pose, base), np.concatenate((way * cos, way * sin, np.zeros_like(way)), axis=1))
        return np.where(seen, place[:, :2], np.nan)
