"""Avoiders that choose a direction from what they see: VFH+, nearness diagram, potential field, and the bugs."""

from __future__ import annotations

import abc
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Beliefs, Context, Draws, State, parameter
from amorsim.controllers.avoider import Avoider, SteeringInput, body_of, guarded, sight_of
from amorsim.kernels.avoidance.histogram import choose_openings
from amorsim.kernels.avoidance.potential import push_away
from amorsim.kernels.avoidance.steering import aims, bearing_twists, points_seen

__all__ = ["Headed", "PotentialField", "VfhPlus"]


_WORK = 40  # cost of one decision for a robot, in rays


@attrs.frozen(kw_only=True)
class Headed(Avoider):
    """The base of avoiders that choose a direction: they turn to it, and drive where nothing is in the way.

    Whatever they choose, they drive no twist from which they could not brake before their footprint meets something
    seen; they stop instead.
    """

    look_ahead: float = parameter(1.0, unit="m", gt=0, help="how far ahead on its path it is led")
    turn_time: float = parameter(0.5, unit="s", gt=0, help="in which it turns to the direction that it chose")
    slow_within: float = parameter(0.5, unit="m", gt=0, help="distance of things ahead from which on it drives slower")

    @abc.abstractmethod
    def bearing(self, points: Array, room: Array, target: Array, pose: Array, state: State, draws: Draws) -> Array:
        """The directions `(N, 1)` [rad] in the robots' frames, nan for none.

        `points` `(N, 3, p)` [m] are seen (the first two rows count, inf for none), `room` `(N, 1)` [m] is the radius of
        the robot with its clearance, `target` `(N, 2)` [m] where it is led; all in the robot's frame. `pose` `(N, 3)`
        is the estimated one.
        """

    def start_steering(self, context: Context) -> State:
        """The sensor's beams, the drive's limits, and the direction taken last."""
        return {**super().start_steering(context), "bearing": np.full((context.rows, 1), np.nan)}

    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active brake."""
        robot, course, state = given.course.robot, given.course, given.state
        rows = robot.rows
        reading = given.readings[self.sensor]
        sight = sight_of(robot, reading, self.sensor, course.joints, state)
        points = np.empty((rows, 3, sight.ranges.shape[1] * sight.samples))
        seen = sight, reading.age, state["moving"]
        given.draws.share(_WORK, lambda first, end: points_seen(*seen, first, end, points))
        target = np.empty((rows, 2))
        aims(course.poses, given.guide, self.look_ahead, target)
        room: Any = np.zeros((rows, 1)) + robot.shape.reach + self.clearance
        state["bearing"] = self.bearing(points, room, target, course.poses, state, given.draws)
        wanted = np.empty((rows, 2))
        bearing_twists(
            points,
            state["bearing"],
            target,
            self.speed,
            self.turn_rate,
            self.turn_time,
            room,
            self.slow_within,
            wanted,
        )
        wanted = np.where(given.active, wanted, 0.0)
        return guarded(wanted, sight, reading.age, course, body_of(robot, self.clearance), state, given.clock.dt)

    def beliefs(self, state: State) -> Beliefs:
        """The twist that it has by its own account, and the direction that it took."""
        return {"twist": state["moving"].copy(), "bearing": state["bearing"].copy()}


@attrs.frozen(kw_only=True)
class VfhPlus(Headed):
    """Drives to goals through openings between what it sees, by the vector field histogram (VFH+).

    It marks the directions in which the circle around its footprint would meet something within `range_max`, and
    takes, of the openings that are left, the direction that is least off the goal, its heading and its last choice.
    After I. Ulrich and J. Borenstein, "VFH+: reliable obstacle avoidance for fast mobile robots", ICRA 1998; without
    its certainty grid, as the sensor sees all that counts at once.

    Parameters
    ----------
    sectors
        How many directions there are.
    range_max
        How far it looks [m].
    goal_weight, heading_weight, last_weight
        What the angles from the goal, from its heading, and from its last choice count. If the first is larger than the
        sum of the others, it does not swing between equal openings.
    """

    sectors: int = parameter(72, ge=8, le=100_000, static=True, help="how many directions there are")
    range_max: float = parameter(1.5, unit="m", gt=0, help="how far it looks")
    goal_weight: float = parameter(5.0, ge=0, help="of the angle from the goal")
    heading_weight: float = parameter(2.0, ge=0, help="of the angle from its heading")
    last_weight: float = parameter(2.0, ge=0, help="of the angle from its last choice")

    def start_steering(self, context: Context) -> State:
        """State: that of all avoiders that choose a direction, and the histogram."""
        return {**super().start_steering(context), "histogram": np.zeros((context.rows, self.sectors), dtype=bool)}

    def bearing(self, points: Array, room: Array, target: Array, pose: Array, state: State, draws: Draws) -> Array:
        """The direction of the best opening."""
        rows = len(target)
        weights = np.empty((rows, 3))
        for column, value in enumerate((self.goal_weight, self.heading_weight, self.last_weight)):
            weights[:, column : column + 1] = value
        chosen = state["bearing"].copy()
        asked = points, room, self.range_max, target, weights
        draws.share(_WORK, lambda first, end: choose_openings(*asked, first, end, state["histogram"], chosen))
        return chosen

    def beliefs(self, state: State) -> Beliefs:
        """Also the histogram: which directions are blocked, the first one behind the robot, anticlockwise."""
        return {**super().beliefs(state), "histogram": state["histogram"].copy()}


@attrs.frozen(kw_only=True)
class PotentialField(Headed):
    """Drives to goals down an artificial potential: the goal attracts, and what is seen repels.

    After O. Khatib, "Real-time obstacle avoidance for manipulators and mobile robots", IJRR 5 (1), 1986. It shows the
    traps that such fields have: where attraction and repulsion cancel it stops, for ever, and reports that it is
    blocked.

    Parameters
    ----------
    strength
        Of the repulsion, where the attraction is 1: at the distance d [m] from the circle around the footprint it is
        ``strength * (1 / d - 1 / far)``, over all that is seen in equal shares of the full angle.
    influence_distance
        Distance beyond which nothing repels [m].
    """

    strength: float = parameter(0.3, unit="m", ge=0, help="of the repulsion")
    influence_distance: float = parameter(1.0, unit="m", gt=0, help="distance beyond which nothing repels")

    def start_steering(self, context: Context) -> State:
        """State: that of all avoiders that choose a direction, and the force."""
        return {**super().start_steering(context), "force": np.zeros((context.rows, 2))}

    def bearing(self, points: Array, room: Array, target: Array, pose: Array, state: State, draws: Draws) -> Array:
        """The direction of the force."""
        bearing = np.empty((len(target), 1))
        push_away(points, room, target, self.strength, self.influence_distance, state["force"], bearing)
        return bearing

    def beliefs(self, state: State) -> Beliefs:
        """Also the force, in the robot's frame."""
        return {**super().beliefs(state), "force": state["force"].copy()}
