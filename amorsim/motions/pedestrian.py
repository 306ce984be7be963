"""People on foot, by the social force model of D. Helbing and P. Molnár."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np

from amorsim.array_types import Array, Ints
from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.kernels import elementary
from amorsim.kernels.behaviours.social_force import NEGLIGIBLE, Passers, Walls, range_of, social_forces
from amorsim.motions.ways import STANDS, blocked_for, displacement, facing

__all__ = ["Pedestrian"]


_RAYS = 24
_WORK = 60  # cost of the forces on a pedestrian, in rays
_BEARINGS: Array = np.array([2.0 * math.pi * ray / _RAYS for ray in range(_RAYS)])
_TABLE: Array = np.column_stack((np.cos(_BEARINGS), np.sin(_BEARINGS)))


@attrs.frozen(kw_only=True)
class Pedestrian(Motion):
    """Walks from goal to goal, kept away from others and from walls by social forces.

    A pedestrian accelerates towards the goal within `relaxation_time`. Other bodies repel along ellipses that span
    their next step, walls from their nearest points; things behind count less. The numbers are those of D. Helbing and
    P. Molnár, Social force model for pedestrian dynamics, Physical Review E 51 (1995) 4282-4286. Distances here go to
    the other's outline, so that the size of robots counts. With `relative`, ellipses span steps relative to the
    pedestrian's own (A. Johansson, D. Helbing and P. Shukla, Advances in Complex Systems 10, 2007): the pedestrian then
    also steps aside for standing things.
    """

    goals: tuple[tuple[float, float], ...] = parameter(
        (),
        unit="m",
        frame="world",
        help="places [x, y] in the world; none: on and on in the direction he looks at the start",
    )
    order: str = parameter(
        "loop",
        choices=("loop", "random", "once"),
        help="which goal is next: in turn, any other, or none after the last",
    )
    tolerance: float = parameter(0.5, unit="m", gt=0, help="how near to a goal he has reached it")
    speed: float = parameter(1.34, unit="m/s", ge=0, help="desired speed, mean over pedestrians")
    speed_std: float = parameter(0.26, unit="m/s", ge=0, help="its standard deviation over pedestrians")
    relaxation_time: float = parameter(0.5, unit="s", gt=0, help="in which he takes up his speed")
    strength: float = parameter(2.1, unit="m^2/s^2", ge=0, help="of the repulsion by others")
    range: float = parameter(0.3, unit="m", gt=0, help="of the repulsion by others")
    step_time: float = parameter(2.0, unit="s", ge=0, help="how far ahead others' ways are seen")
    relative: bool = parameter(False, help="whether others' ways are taken relative to his own, not over the ground")
    wall_strength: float = parameter(10.0, unit="m^2/s^2", ge=0, help="of the repulsion by walls")
    wall_range: float = parameter(0.2, unit="m", gt=0, help="of the repulsion by walls")
    field_of_view: float = parameter(
        math.radians(200.0), unit="rad", ge=0, le=2.0 * math.pi, help="angle of sight, half of it to either side"
    )
    behind_weight: float = parameter(0.5, ge=0, le=1, help="weight of who is out of sight")
    velocity_noise: float = parameter(0.1, unit="m/s/sqrt(s)", ge=0, help="random changes of his velocity, in a second")
    avoid_robots: bool = parameter(True, help="whether robots repel him; if not, he walks as if there were none")
    blocked: str = parameter(
        "wait",
        choices=("wait", "skip"),
        help="what to do when the way is blocked: go on trying, or take the next goal",
    )
    patience: float = parameter(5.0, unit="s", ge=0, help="how long he is blocked before he takes the next goal")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The goals."""
        return [(f"goals.{i}", x, y) for i, (x, y) in enumerate(self.goals)]

    def start(self, context: Context) -> State:
        """Velocity, desired speed and first goal; random ones are drawn in the first step."""
        rows = context.rows
        return {
            "velocity": np.zeros((rows, 2)),
            "force": np.zeros((rows, 2)),
            "speed": np.zeros((rows, 1)),
            "goal": np.zeros((rows, 1), dtype=np.int64),
            "ahead": np.concatenate((np.cos(context.pose[:, 2:]), np.sin(context.pose[:, 2:])), axis=1),
            "blocked": np.zeros((rows, 1)),
        }

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """A step of the model, in closed form for the forces at its middle."""
        normal, uniform = draws.normal(5), draws.uniform(1)
        is_first = view.tick == 0
        speed = np.maximum(self.speed + self.speed_std * normal[:, :1], 0.0)
        state["speed"] = np.where(is_first, speed, state["speed"])
        if self.order == "random" and self._count:
            drawn = np.minimum((uniform * self._count).astype(np.int64), self._count - 1)
            state["goal"] = np.where(is_first, drawn, state["goal"])
        # A blocked step has taken that part of the speed.
        velocity = state["velocity"] * view.free
        # The velocity in the middle of the step, from the force of the previous step; then the force there.
        wanted = self._towards(view.body_pose[:, :2], state)
        target = state["speed"] * wanted + self.relaxation_time * state["force"]
        middle = target + (velocity - target) * elementary.exp(-0.5 * dt / self.relaxation_time)
        mean, last = self._wanted(view, middle * dt, dt, state, uniform)
        ends = np.concatenate((wanted, last), axis=1)
        force = state["force"] = self._forces(view, middle, ends, 0.5 * dt, draws)
        target = state["speed"] * mean + self.relaxation_time * force
        after, way = self._relaxed(velocity, target, dt, normal[:, 1:])
        most = 1.3 * state["speed"]
        state["velocity"] = _no_faster(after, most)
        way = _no_faster(way, most * dt)
        dx, dy = way[:, :1], way[:, 1:]
        return displacement(view, dx, dy, facing(view, dx, dy, np.full((view.rows, 1), 4.0 * dt)))

    def _relaxed(self, velocity: Array, target: Array, dt: float, normal: Array) -> tuple[Array, Array]:
        """The velocity `(N, 2)` a step later, and the way [m] `(N, 2)`, of v' = (target - v) / tau + waver noise.

        Both are normal with a common part (an Ornstein-Uhlenbeck process and its integral); `normal` is `(N, 4)`.
        """
        tau: Any = self.relaxation_time
        part = dt / tau
        gone = -elementary.expm1(-part)
        # Variances and covariance of velocity and way, for noise of density 1.
        of_velocity = -0.5 * tau * elementary.expm1(-2.0 * part)
        common = 0.5 * (tau * gone) ** 2
        short = elementary.power(part, 3.0) * (1.0 / 3.0 - 0.25 * part)
        of_way = elementary.power(tau, 3.0) * np.where(part > 1e-2, part - gone - 0.5 * gone**2, short)
        along = common / np.sqrt(of_velocity)
        aside = np.sqrt(np.maximum(of_way - along**2, 0.0))
        after = target + (velocity - target) * (1.0 - gone) + self.velocity_noise * np.sqrt(of_velocity) * normal[:, :2]
        way = target * dt + (velocity - target) * (tau * gone)
        return after, way + self.velocity_noise * (along * normal[:, :2] + aside * normal[:, 2:])

    @property
    def _count(self) -> int:
        """The number of goals."""
        shape = np.shape(self.goals)
        return shape[1] if len(shape) > 1 else 0

    def _wanted(self, view: View, way: Array, dt: float, state: State, uniform: Array) -> tuple[Array, Array]:
        """The mean of the wanted direction `(N, 2)` in a step that goes `way` `(N, 2)`, and the direction at its end.

        From the instant at which he reaches a goal, or gives it up, he wants to go to the next one.
        """
        place = view.body_pose[:, :2]
        part = self._part_to_goal(view, way, dt, state)
        to_goal = self._towards(place + 0.5 * part * way, state)
        state["goal"] = np.where(part < 1.0, self._next_goal(state["goal"], uniform), state["goal"])
        to_next = self._towards(place + 0.5 * (1.0 + part) * way, state)
        return part * to_goal + (1.0 - part) * to_next, self._towards(place + way, state)

    def _part_to_goal(self, view: View, way: Array, dt: float, state: State) -> Array:
        """The part `(N, 1)` of a step after which he reaches or gives up his goal; 1 if he does neither."""
        if not self._count:
            return np.ones((view.rows, 1))
        place = view.body_pose[:, :2]
        before, after = self._way_to_goal(place, state)[2], self._way_to_goal(place + way, state)[2]
        entered = (before - self.tolerance) / np.maximum(before - after, STANDS)
        part = np.where(before < self.tolerance, 0.0, np.where(after < self.tolerance, entered, 1.0))
        if self.blocked == "skip":
            waited = blocked_for(view, dt, state)
            gives_up = waited >= self.patience - 1e-9
            state["blocked"] = np.where(gives_up, 0.0, waited)
            part = np.where(gives_up & (view.free < 1.0), 0.0, part)
        return np.where(view.tick == 0, 1.0, part)

    def _next_goal(self, goal: Ints, uniform: Array) -> Ints:
        """The goals `(N, 1)` after these."""
        count = max(self._count, 1)
        if self.order == "once":
            return np.minimum(goal + 1, count - 1)
        if self.order == "random":  # any but this one
            others = max(count - 1, 1)
            return np.asarray((goal + 1 + np.minimum((uniform * others).astype(np.int64), others - 1)) % count)
        return np.asarray((goal + 1) % count)

    def _towards(self, place: Array, state: State) -> Array:
        """The wanted direction `(N, 2)` at a place `(N, 2)`; zero for those that have arrived at their last goal."""
        if not self._count:
            return np.asarray(state["ahead"])
        dx, dy, distance = self._way_to_goal(place, state)
        is_last = np.asarray(self._count == 1 or self.order == "once") & (state["goal"] == self._count - 1)
        stays = (distance < self.tolerance) & is_last
        scale = np.where(stays, 0.0, 1.0 / np.where(distance > STANDS, distance, 1.0))
        return np.concatenate((dx * scale, dy * scale), axis=1)

    def _way_to_goal(self, place: Array, state: State) -> tuple[Array, Array, Array]:
        """The way [m] from a place `(N, 2)` to the goal: along x, along y, and its length, `(N, 1)` each."""
        goals = np.asarray(self.goals)
        goal = goals[np.arange(len(goals)), state["goal"][:, 0]]
        dx, dy = goal[:, :1] - place[:, :1], goal[:, 1:] - place[:, 1:]
        return dx, dy, np.sqrt(dx * dx + dy * dy)

    def _forces(self, view: View, velocity: Array, wanted: Array, ahead: float, draws: Draws) -> Array:
        """Accelerations by others and walls [m/s^2] `(N, 2)`, `ahead` [s] from now."""
        level: Array = np.zeros((view.rows, 3))  # glances count from the world's x axis
        level[:, :2] = view.body_pose[:, :2]
        look: Array = np.empty((view.rows, 1))
        # The distance at which a wall still pushes, plus the approach in the meantime.
        push = np.maximum(self.wall_strength / self.wall_range / NEGLIGIBLE, 2.0)
        look[:] = self.wall_range * elementary.log(push) + 2.0 * ahead * self.speed
        walls = view.cast(level, _BEARINGS[None, :], look, bodies=False)
        half = np.cos(0.5 * self.field_of_view)
        relative, later = np.full((view.rows, 1), float(self.relative)), np.full((view.rows, 1), ahead)
        heeds_robots = np.full((view.rows, 1), float(self.avoid_robots))
        strength, width, step = np.asarray(self.strength), np.asarray(self.range), np.asarray(self.step_time)
        by_walls = (self.wall_strength, self.wall_range)
        parts = (strength, width, step, *by_walls, half, self.behind_weight, relative, later, heeds_robots)
        numbers = np.concatenate([np.asarray(part) for part in parts], axis=1)
        pace = np.sqrt(velocity[:, :1] ** 2 + velocity[:, 1:] ** 2)
        near = view.neighbours(range_of(strength, width, step, relative, later, pace), step + later)
        passers = Passers(near.poses, near.twists, near.reach, near.is_robot)
        mine = np.ascontiguousarray(velocity), np.ascontiguousarray(wanted), Walls(walls, _TABLE), numbers
        out = np.empty((view.rows, 2))
        draws.share(
            _WORK,
            lambda begin, end: social_forces(passers, near.own, near.first, near.body, *mine, begin, end, out),
        )
        return out


def _no_faster(vectors: Array, most: Array) -> Array:
    """The same vectors `(N, 2)`, none longer than `most` `(N, 1)`."""
    size = np.sqrt(vectors[:, :1] ** 2 + vectors[:, 1:] ** 2)
    return np.asarray(vectors * np.where(size > most, most / np.where(size > most, size, 1.0), 1.0))
