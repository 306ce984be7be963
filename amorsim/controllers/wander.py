"""Wandering without touching anything."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import (
    Clock,
    Context,
    Controller,
    ControllerBinding,
    Draws,
    Estimate,
    Measurement,
    RobotModel,
    State,
    parameter,
)
from amorsim.contracts.joints import at_rest, joints_of
from amorsim.controllers.abilities import (
    command_along,
    curvature_max,
    heading_poses,
    twist_limits,
)
from amorsim.controllers.beams import beams_of, range_sensor, turned_beams
from amorsim.core.errors import ComponentError
from amorsim.core.poses import wrap_angle
from amorsim.kernels.behaviours import wandering, wandering_car
from amorsim.kernels.behaviours.free_space import Sight
from amorsim.kernels.random.philox import fill_uniform

__all__ = ["Wander"]


_PLACES = 32  # that the robot remembers, 0.7 m apart
_SWAY_MAX = math.radians(2.0)
_GAP_MAX = math.radians(30.0)  # largest blind angle of a robot that counts as seeing all around
_WORK = 40  # cost of one decision for a robot, in rays
_CAR_WORK = 400  # the same for a car
_WAY = 256  # places on its way that a car remembers
_SEEN = 512  # seen points that a car remembers
_ARC_SAMPLES = 7  # points that stand for the arc on which a cone's return lies


@attrs.frozen(kw_only=True)
class Wander(Controller):
    """Roams for ever: straight on while the way is free, then in place to another direction, and on.

    The robot treats itself as a disc about its base point that holds its whole footprint and a margin of `clearance`.
    Its way so far was free for that disc, so turning in place is always safe. Straight ahead it drives no faster than
    it can stop within the free distance that it sees. It draws a new direction at random. Directions with much room
    weigh more, and places where it was lately (by its own estimate) weigh little, so it finds its way through doors,
    and out of rooms again. It also turns where a door seems to come abeam.

    A drive that cannot turn in place takes the feasible arc with most room for its footprint; the arcs take turns in
    being preferred. The robot remembers what it passes. Where no arc has room, it reverses along its own path and tries
    another.

    For range sensors with a field of view of at least the half circle ahead. A drive whose body does not turn with its
    wheels needs the full circle.

    Parameters
    ----------
    speed
        Speed where there is room [m/s].
    sensor
        Name of the range sensor that it uses, a scanner or a ring.
    clearance
        Margin around the turning footprint [m]; at least three times the sensor's noise.
    turn_rate
        Rate of turns in place [rad/s].
    """

    speed: float = parameter(0.4, unit="m/s", gt=0, help="at which it drives where there is room")
    sensor: str = parameter("laser", refers="sensors", help="name of the range sensor by which it goes")
    clearance: float = parameter(0.05, unit="m", ge=0, help="what it keeps free around its footprint as that turns")
    turn_rate: float = parameter(1.0, unit="rad/s", gt=0, help="at which it turns in place")

    def start(self, context: Context) -> State:
        """The robot's knowledge of itself, and its memory.

        Raises
        ------
        ComponentError
            If the robot has no such sensor, or the sensor does not give the directions of its values; if its body does
            not turn with its wheels and the sensor does not see all around.
        """
        robot = context.robot
        model = range_sensor(robot, self.sensor, "wander")
        beams = beams_of(model, context.rows)
        half_angle: Any = getattr(model.sensor, "half_angle", 0.0)
        body = np.zeros((context.rows, wandering.BODY_COLUMNS))
        body[:, 0] = robot.shape.reach
        body[:, 1] = np.abs(robot.shape.outline[:, 1]).max()
        body[:, 2:6] = twist_limits(robot)
        body[:, 6] = np.maximum(beams[:, 2].min(axis=1), -math.pi)
        body[:, 7] = np.minimum(beams[:, 2].max(axis=1), math.pi)
        if robot.drive.heading_offset(at_rest(robot)) is not None:
            _check_all_round(robot, self.sensor, beams, float(np.max(half_angle)))
            body[:, 6], body[:, 7] = -math.pi, math.pi
        elif not hasattr(model.sensor, "half_angle") and beams.shape[2] > 1:
            body[:, 8] = np.minimum((body[:, 7] - body[:, 6]) / (beams.shape[2] - 1), _SWAY_MAX)
        curvature = np.array(curvature_max(robot))
        cars = np.isfinite(curvature).any()
        return {
            "curvature": curvature,
            "car": np.zeros((context.rows, wandering_car.CAR_COLUMNS)),
            "way": np.zeros((context.rows, _WAY if cars else 0, 2)),
            "seen": np.zeros((context.rows, _SEEN if cars else 0, 2)),
            "beams": beams,
            "half_angle": np.array(np.broadcast_to(half_angle, (context.rows, 1)), dtype=np.float64),
            "body": body,
            "memory": np.zeros((context.rows, wandering.MEMORY_COLUMNS)),
            "trail": np.zeros((context.rows, _PLACES, 2)),
        }

    def bind(self, at: ControllerBinding) -> Callable[[], None]:
        """Decide by a kernel on the engine's own arrays, for robots that turn in place with their bodies."""
        robot, state, draws = at.robot, at.state, at.draws
        joints = at_rest(robot)
        if robot.drive.heading_offset(joints) is not None or not np.isinf(state["curvature"]).all():
            return super().bind(at)
        reading, twist = at.readings[self.sensor], np.empty((robot.rows, 3))
        sight = Sight(reading.measured, state["beams"], state["half_angle"], self._samples(robot))
        chance = wandering.Chance(draws.keys, draws.counter, 0)  # the first draws of each tick
        given = *sight, reading.age, at.estimate.pose, state["body"], *self._wish(), *chance, at.dt
        kept = state["memory"], state["trail"]
        decide = draws.bind_share(
            _WORK, lambda first, end: functools.partial(wandering.wander, *given, *kept, first, end, twist)
        )

        def command() -> None:
            decide()
            at.out[:, : len(robot.drive.channels)] = robot.drive.command_for(twist, joints)

        return command

    def _samples(self, robot: RobotModel) -> int:
        """The number of points for one return of the sensor."""
        return _ARC_SAMPLES if hasattr(robot.sensors[self.sensor].sensor, "half_angle") else 1

    def _wish(self) -> wandering.Wish:
        return wandering.Wish(self.speed, self.turn_rate, self.clearance)

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
        reading = readings[self.sensor]
        joints = joints_of(robot, readings)
        twist = np.empty((robot.rows, 3))
        sight = Sight(
            reading.measured,
            turned_beams(robot, state["beams"], joints),
            state["half_angle"],
            self._samples(robot),
        )
        poses = heading_poses(robot, estimate.pose, joints)
        wish = self._wish()
        chance = wandering.Chance(*draws.reserve(2))
        turns = np.isinf(state["curvature"])
        if turns.any():
            mine = *sight, reading.age, poses, state["body"], *wish, *chance, clock.dt, state["memory"], state["trail"]
            draws.share(_WORK, lambda first, end: wandering.wander(*mine, first, end, twist))
        if not turns.all():
            cars = self._as_cars(robot, sight, poses, wish, chance, clock.dt, state, draws)
            twist = np.where(turns, twist, cars)
        return command_along(robot, twist, joints)

    def _as_cars(
        self,
        robot: RobotModel,
        sight: Sight,
        poses: Array,
        wish: wandering.Wish,
        chance: wandering.Chance,
        dt: float,
        state: State,
        draws: Draws,
    ) -> Array:
        """The twists `(N, 3)` of robots that cannot turn in place."""
        outline, twist, uniform = robot.shape.outline, np.empty((robot.rows, 3)), np.empty((robot.rows, 2))
        fill_uniform(*chance, uniform)
        body = wandering_car.CarBody(
            float(outline[:, 0].max()),
            float(outline[:, 0].min()),
            float(np.abs(outline[:, 1]).max()),
            np.ascontiguousarray(state["body"][:, 2:6]),
            np.minimum(state["curvature"], 1e3),
        )
        mine = poses, body, wish, uniform, dt, state["car"], state["way"], state["seen"]
        draws.share(_CAR_WORK, lambda first, end: wandering_car.wander_car(sight, *mine, first, end, twist))
        return twist


def _check_all_round(robot: RobotModel, name: str, beams: Array, half_angle: float) -> None:
    headings = np.sort(wrap_angle(beams[0, 2]))
    gaps = np.diff(np.append(headings, headings[0] + 2.0 * math.pi)) - 2.0 * half_angle
    if gaps.max() > _GAP_MAX:
        raise ComponentError(
            f"wander: the body of {robot.who(0)} does not turn with its wheels, so it drives any way it looks, and the "
            f"sensor {name!r} does not see all around: it leaves out {math.degrees(gaps.max()):.0f} degrees. Name one "
            "that does in the field 'sensor'"
        )
