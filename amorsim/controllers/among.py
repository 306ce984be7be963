"""Avoiders among robots whose places are known: by what these send, or by the marks that they carry."""

from __future__ import annotations

import abc
import math
from typing import Any, ClassVar, NamedTuple

import attrs
import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Beliefs, Context, Draws, State, parameter
from amorsim.controllers.avoider import Avoider, SteeringInput, start_moving
from amorsim.controllers.others import know_others, start_others
from amorsim.kernels import elementary
from amorsim.kernels.avoidance.human_like import human_velocities
from amorsim.kernels.avoidance.hybrid import hybrid_velocities
from amorsim.kernels.avoidance.reciprocal import reciprocal_velocities
from amorsim.kernels.avoidance.steering import aims, twists_towards
from amorsim.kernels.behaviours.social_force import Passers, Walls, social_forces

__all__ = ["Among", "Hrvo", "HumanLike", "Orca", "SocialForce"]


_WORK = 60  # cost of one decision for a robot, in rays


@attrs.frozen(kw_only=True)
class Among(Avoider):
    """The base of avoiders that know where others are: they choose a velocity, and turn towards it.

    They know nothing of walls, and of the others what their sensor gives. A `neighbours` sensor gives places,
    velocities and radii. A `fiducial` gives the places of marks; the robot estimates their velocities from one reading
    to the next, and takes their radius to be `others_radius`.
    """

    blocked_word: ClassVar[str] = "deadlock"

    sensor: str = parameter(
        "neighbours", refers="sensors", help="name of the sensor that finds the others, a 'neighbours' or a 'fiducial'"
    )
    others_radius: float | None = parameter(
        None, unit="m", ge=0, static=True, help="of others that a 'fiducial' finds; the robot's own if not given"
    )
    look_ahead: float = parameter(1.0, unit="m", gt=0, help="how far ahead on its path it looks")
    rotation_time: float = parameter(0.5, unit="s", gt=0, help="in which it turns towards the velocity that it chose")

    @property
    def slowness(self) -> Any:
        """The time constant [s] with which its twist follows the wanted one, a number or `(N, 1)`."""
        return 0.0

    @abc.abstractmethod
    def choose(
        self, others: Array, own: Array, target: Array, radius: Array, dt: float, state: State, draws: Draws
    ) -> Array:
        """The velocities `(N, 2)` [m/s] of the robots in their own frames.

        `others` `(N, M, 5)` are x, y [m], vx, vy [m/s] and radius [m] from each robot, inf for none; `own` `(N, 2)` is
        its velocity, `target` `(N, 2)` [m] where it is led, `radius` `(N, 1)` [m] its own with its clearance.
        """

    def start_steering(self, context: Context) -> State:
        """State: the robot's account of its twist, and its knowledge of the others.

        Raises
        ------
        ComponentError
            If the robot has no such sensor.
        """
        return {**start_moving(context), **start_others(context, self.sensor, type(self).__name__.lower())}

    def steer(self, given: SteeringInput) -> Array:
        """The twists `(N, 3)` along the paths of the guide; robots that are not active brake."""
        robot, course, state = given.course.robot, given.course, given.state
        rows = robot.rows
        reach = np.zeros((rows, 1)) + robot.shape.reach
        size = reach if self.others_radius is None else np.full((rows, 1), self.others_radius)
        others = know_others(robot, given.readings[self.sensor], self.sensor, course, size, given.clock.time, state)
        own = np.zeros((rows, 2))
        own[:, 0] = state["moving"][:, 0]
        target = np.empty((rows, 2))
        aims(course.poses, given.guide, self.look_ahead, target)
        radius: Any = reach + self.clearance
        chosen = self.choose(others, own, target, radius, given.clock.dt, state, given.draws)
        twist = np.empty((rows, 3))
        twists_towards(
            np.ascontiguousarray(np.where(given.active, chosen, 0.0)),
            self.speed,
            self.turn_rate,
            self.rotation_time,
            np.zeros((rows, 1)) + self.slowness,
            state["limits"],
            given.clock.dt,
            state["moving"],
            twist,
        )
        return twist

    def beliefs(self, state: State) -> Beliefs:
        """The others as the robot knows them, in its own frame: x, y, vx, vy and radius of each."""
        return {"twist": state["moving"].copy(), "others": state["others"].copy()}


class Encounter(NamedTuple):
    """What robots know of a meeting when they choose a velocity; see `Among.choose`."""

    others: Array
    own: Array
    wanted: Array
    radius: Array


@attrs.frozen(kw_only=True)
class _ByVelocity(Among):
    """The base of those that choose the velocity nearest to the wanted one among those that the others permit."""

    leaves: ClassVar[tuple[str, int]]
    """The name of the belief of what each of the others leaves it, and how many numbers that is."""

    @abc.abstractmethod
    def nearest(self, known: Encounter, dt: float, first: int, end: int, left: Array, out: Array) -> None:
        """Write the velocities `(N, 2)` of rows `first` to `end` into `out`, and what the others permit into `left`."""

    def start_steering(self, context: Context) -> State:
        """State: the robot's account of its twist, the others, and room for what they permit."""
        state = super().start_steering(context)
        name, numbers = self.leaves
        return {**state, name: np.full((*state["others"].shape[:2], numbers), np.nan)}

    def choose(
        self, others: Array, own: Array, target: Array, radius: Array, dt: float, state: State, draws: Draws
    ) -> Array:
        """The velocities nearest to those that are wanted."""
        wanted = _wanted(target, self.speed)
        out = np.empty_like(wanted)
        known, left = Encounter(others, own, wanted, radius), state[self.leaves[0]]
        draws.share(_WORK, lambda first, end: self.nearest(known, dt, first, end, left, out))
        return out

    def beliefs(self, state: State) -> Beliefs:
        """The others, and what each of them permits."""
        name = self.leaves[0]
        return {**super().beliefs(state), name: state[name].copy()}


@attrs.frozen(kw_only=True)
class Orca(_ByVelocity):
    """Drives to goals among robots that do the same, by optimal reciprocal collision avoidance (ORCA).

    Two robots share the work of keeping apart for `horizon`: each does half. Of the velocities that this permits, the
    robot takes the one nearest to the velocity towards its goal. If none is permitted, it takes the one that violates
    the worst limit least. After J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision
    avoidance", ISRR 2009.

    It assumes that a robot can change its velocity at once, in any direction. A robot on wheels cannot, so give it a
    `clearance`. Robots may block one another for ever; they then report a ``deadlock``.

    Parameters
    ----------
    horizon
        Time for which it keeps apart from others [s].
    """

    horizon: float = parameter(5.0, unit="s", gt=0, help="for which it keeps apart from others")

    leaves: ClassVar[tuple[str, int]] = ("borders", 4)

    def nearest(self, known: Encounter, dt: float, first: int, end: int, left: Array, out: Array) -> None:
        """By ORCA. Of each of the others, `left` is the border of what it permits: a point and a direction [m/s]."""
        mine: Any = self
        reciprocal_velocities(*known, mine.speed, mine.horizon, dt, first, end, left, out)


@attrs.frozen(kw_only=True)
class HumanLike(Among):
    """Drives to goals among others as people do: where the free way ahead leads nearest to the goal.

    It looks in all directions up to about a right angle from the goal's, and computes how far it could go in each
    before it meets another robot that keeps its velocity. It takes the direction that leads nearest to the goal, at a
    speed at which the free way ahead lasts for `reaction_time`. After J. Guzzi and others, "Human-friendly robot
    navigation in dynamic environments", ICRA 2013. Robots may block one another for ever; they then report a
    ``deadlock``.

    Parameters
    ----------
    horizon
        How far ahead it looks [m].
    reaction_time
        Time in which it could cover the free way ahead [s].
    relaxation_time
        Time constant with which its speeds follow what it wants [s].
    directions
        How many directions there are in a full circle.
    """

    horizon: float = parameter(5.0, unit="m", gt=0, help="how far ahead it looks")
    reaction_time: float = parameter(0.5, unit="s", gt=0, help="in which it could cover the free way ahead")
    relaxation_time: float = parameter(0.125, unit="s", ge=0, help="with which its speeds follow what it wants")
    directions: int = parameter(101, ge=8, le=10_000, static=True, help="how many there are in a full circle")

    @property
    def slowness(self) -> Any:
        """Its relaxation."""
        return self.relaxation_time

    def start_steering(self, context: Context) -> State:
        """State: the robot's account of its twist, the free ways, and the bearing of the target."""
        count = 2 * int(1.6 / (2.0 * math.pi / self.directions)) + 1
        return {
            **super().start_steering(context),
            "ways": np.full((context.rows, count, 2), np.nan),
            "towards": np.zeros((context.rows, 1)),
        }

    def choose(
        self, others: Array, own: Array, target: Array, radius: Array, dt: float, state: State, draws: Draws
    ) -> Array:
        """The velocities towards the best directions."""
        out = np.empty((len(own), 2))
        mine: Any = self
        asked = others, target, radius, mine.speed, mine.reaction_time, mine.horizon, self.directions
        draws.share(_WORK, lambda first, end: human_velocities(*asked, first, end, state["ways"], out))
        state["towards"] = elementary.arctan2(target[:, 1:], target[:, :1])
        return out

    def beliefs(self, state: State) -> Beliefs:
        """The others, and directions [rad] in the robot's frame with the free way in each [m]."""
        ways = state["ways"].copy()
        ways[:, :, 0] += state["towards"]
        return {**super().beliefs(state), "ways": ways}


@attrs.frozen(kw_only=True)
class Hrvo(_ByVelocity):
    """Drives to goals among robots that do the same, by hybrid reciprocal velocity obstacles (HRVO).

    The velocities that lead into another robot make a cone. Its apex is placed so that both robots do half of the
    avoiding, and stay on the side on which they already pass. The robot takes the velocity nearest to the one that
    leads to the goal that is in no cone; if there is none, one that is in none of the nearest robots'. After J. Snape
    and others, "The hybrid reciprocal velocity obstacle", IEEE Transactions on Robotics 27 (4), 2011. Its horizon is
    infinite, so it is timid in crowds. Robots may block one another for ever; they then report a ``deadlock``.
    """

    leaves: ClassVar[tuple[str, int]] = ("cones", 6)

    def nearest(self, known: Encounter, dt: float, first: int, end: int, left: Array, out: Array) -> None:
        """By HRVO. Of each of the others, `left` is the cone that leads into it: apex, right and left side [m/s]."""
        mine: Any = self
        hybrid_velocities(*known, mine.speed, first, end, left, out)


@attrs.frozen(kw_only=True)
class SocialForce(Among):
    """Drives to goals among others as pedestrians do, by the social force model.

    It speeds up towards the goal within `relaxation_time`, and is pushed away by the others, the more the nearer
    their next step leads them. After D. Helbing and P. Molnar, "Social force model for pedestrian dynamics", Physical
    Review E 51, 1995; as the motion `pedestrian` does. It guarantees nothing: robots may touch.

    Parameters
    ----------
    relaxation_time
        Time in which it gets to the speed that it wants [s].
    strength, range
        Of the repulsion by others [m^2/s^2] and [m].
    step_time
        How far ahead it sees the others' steps [s].
    field_of_view
        Angle of sight [rad]; what is out of it counts `behind_weight`.
    """

    relaxation_time: float = parameter(0.5, unit="s", gt=0, help="in which it gets to the speed that it wants")
    strength: float = parameter(2.1, unit="m^2/s^2", ge=0, help="of the repulsion by others")
    range: float = parameter(0.3, unit="m", gt=0, help="of the repulsion by others")
    step_time: float = parameter(2.0, unit="s", gt=0, help="for which it sees the others' steps")
    field_of_view: float = parameter(
        200.0 / 180.0 * math.pi, unit="rad", gt=0, le=2.0 * math.pi, help="its angle of sight"
    )
    behind_weight: float = parameter(0.5, ge=0, le=1, help="what counts that is out of sight")

    def choose(
        self, others: Array, own: Array, target: Array, radius: Array, dt: float, state: State, draws: Draws
    ) -> Array:
        """The velocities after this step's acceleration."""
        rows, slots = others.shape[:2]
        away = np.sqrt(target[:, :1] ** 2 + target[:, 1:] ** 2)
        towards = target / np.maximum(away, 1e-9)
        there = np.isfinite(others[:, :, 0])
        # All bodies in a line: the others of each robot, then the robots, each at its own origin.
        known = np.where(there[:, :, None], others, 0.0).reshape(-1, 5)
        poses, twists = np.zeros((2, rows * slots + rows, 3))
        poses[: rows * slots, :2], twists[: rows * slots, :2] = known[:, :2], known[:, 2:4]
        twists[rows * slots :, :2] = own
        reach = np.concatenate((known[:, 4], np.zeros(rows))) + np.concatenate(
            (np.repeat(radius[:, 0], slots), np.zeros(rows))
        )
        first = np.zeros(rows + 1, dtype=np.int64)
        first[1:] = np.cumsum(np.count_nonzero(there, axis=1))
        body = np.flatnonzero(there)
        numbers = np.zeros((rows, 10))
        cosine = np.cos(0.5 * np.asarray(self.field_of_view))
        for column, value in (
            (0, self.strength),
            (1, self.range),
            (2, self.step_time),
            (5, cosine),
            (6, self.behind_weight),
        ):
            numbers[:, column : column + 1] = value
        numbers[:, 4] = 1.0
        numbers[:, 9] = 1.0
        force = np.empty((rows, 2))
        social_forces(
            Passers(poses, twists, reach, np.ones(len(reach), dtype=bool)),
            np.arange(rows) + rows * slots,
            first,
            body,
            own,
            np.concatenate((towards, towards), axis=1),
            Walls(np.full((rows, 1), np.inf), np.array([[1.0, 0.0]])),
            numbers,
            0,
            rows,
            force,
        )
        wanted = _wanted(target, self.speed)
        found = own + dt * ((wanted - own) / self.relaxation_time + force)
        size = np.sqrt(found[:, :1] ** 2 + found[:, 1:] ** 2)
        speed: Any = self.speed
        return np.asarray(found * np.minimum(1.0, speed / np.maximum(size, 1e-9)))


def _wanted(target: Array, speed: Any) -> Array:
    """The velocities `(N, 2)` [m/s] straight to the targets, slower within a second of them."""
    away = np.sqrt(target[:, :1] ** 2 + target[:, 1:] ** 2)
    return np.ascontiguousarray(target * (speed / np.maximum(away, speed)))
