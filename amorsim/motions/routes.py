"""Along waypoints: once, round and round, or there and back."""

from __future__ import annotations

import abc
from collections.abc import Sequence

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.kernels import elementary
from amorsim.motions.ways import blocked_for, displacement, facing

__all__ = ["Loop", "Oscillate", "Waypoints"]

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@attrs.frozen(kw_only=True)
class _Route(Motion):
    """From waypoint to waypoint on straight lines, at one speed; a step past a waypoint cuts the corner.

    Subclasses define the order: waypoint number `next`, and the direction `way`, 1 or -1, through the list.
    """

    waypoints: tuple[tuple[float, float], ...] = parameter(
        unit="m", frame="world", help="places [x, y] in the world, in order"
    )
    speed: float = parameter(1.0, unit="m/s", ge=0, help="at which it goes")
    pause: float = parameter(0.0, unit="s", ge=0, help="how long it rests at each waypoint")
    blocked: str = parameter(
        "wait",
        choices=("wait", "skip"),
        help="what it does when something is in the way: wait until the way is free, or leave this waypoint out",
    )
    patience: float = parameter(1.0, unit="s", ge=0, help="how long it is blocked before it skips a waypoint")
    faces: str = parameter("ahead", choices=("ahead", "fixed"), help="whether it turns to where it goes")
    turn_rate: float = parameter(3.0, unit="rad/s", ge=0, help="how fast it turns, while it goes on")

    def __attrs_post_init__(self) -> None:
        if not self.waypoints:
            raise ParameterError("waypoints", "expected one waypoint [x, y] at least, got none")

    def goal_points(self) -> Sequence[tuple[str, float, float]]:
        """The waypoints."""
        return [(f"waypoints.{i}", x, y) for i, (x, y) in enumerate(self.waypoints)]

    def default_start(self) -> tuple[float, float, float]:
        """At the first waypoint, looking towards the second."""
        x, y = self.waypoints[0]
        ahead = self.waypoints[min(1, len(self.waypoints) - 1)]
        heading = float(elementary.arctan2(ahead[1] - y, ahead[0] - x))
        return float(x), float(y), heading if self.faces == "ahead" else 0.0

    def start(self, context: Context) -> State:
        """Heads for the first waypoint; `last_next` and its like hold the values before the latest step."""
        rows = context.rows
        state: State = {name: np.zeros((rows, 1), dtype=np.int64) for name in ("next", "last_next")}
        state |= {name: np.ones((rows, 1), dtype=np.int64) for name in ("way", "last_way")}
        state |= {name: np.zeros((rows, 1)) for name in ("rest", "last_rest", "blocked")}
        return state

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """The way of a step, past waypoints if it reaches any; straight from its start to its end."""
        waited = blocked_for(view, dt, state)
        # A body that was stopped before a waypoint has not passed it.
        short = view.free < 1.0
        following, way = (np.where(short, state[f"last_{name}"], state[name]) for name in ("next", "way"))
        rest = np.where(short, state["last_rest"], state["rest"])
        if self.blocked == "skip":
            gives_up = short & (waited >= self.patience - 1e-9)
            after, after_way = self._after(following, way)
            following, way = np.where(gives_up, after, following), np.where(gives_up, after_way, way)
            state["blocked"] = np.where(gives_up, 0.0, waited)
        state.update(last_next=following, last_way=way, last_rest=rest)
        x, y = view.body_pose[:, :1], view.body_pose[:, 1:2]
        left = np.full((view.rows, 1), dt)
        # To the next waypoint, and then less than once around.
        for _ in range(2 * self._count() + 1):
            # First rest, then go, then arrive.
            resting = np.minimum(rest, left)
            rest, left = rest - resting, left - resting
            target_x, target_y = self._place(following)
            dx, dy = target_x - x, target_y - y
            distance = np.sqrt(dx * dx + dy * dy)
            far = self.speed * left
            arrives = (left > 0.0) & (far >= distance) & ~self._is_over(following)
            share = np.where(arrives, 1.0, np.where(distance > far, far / np.where(distance > far, distance, 1.0), 0.0))
            x = np.where(share >= 1.0, target_x, x + share * dx)
            y = np.where(share >= 1.0, target_y, y + share * dy)
            spent = np.where(arrives, distance / np.where(arrives & (self.speed > 0.0), self.speed, 1.0), left)
            left = np.where(arrives, np.maximum(left - spent, 0.0), 0.0)
            rest = np.where(arrives, self.pause, rest)
            after, after_way = self._after(following, way)
            following, way = np.where(arrives, after, following), np.where(arrives, after_way, way)
            if not (left > 0.0).any():
                break
            left = np.fmod(left, self._time_around())
        state.update(next=following, way=way, rest=rest)
        dx, dy = x - view.body_pose[:, :1], y - view.body_pose[:, 1:2]
        turn = (
            facing(view, dx, dy, np.asarray(self.turn_rate * dt)) if self.faces == "ahead" else np.zeros((view.rows, 1))
        )
        return displacement(view, dx, dy, turn)

    def _time_around(self) -> Array:
        """The time from a waypoint to the same one again, with pauses `(N, 1)` [s]; inf if that is never or at once."""
        order = self._around()
        points = np.asarray(self.waypoints)[:, order]
        steps = points - np.roll(points, 1, axis=1)
        length = np.sqrt(steps[:, :, 0] ** 2 + steps[:, :, 1] ** 2).sum(axis=1, keepdims=True)
        moves = (length > 0.0) & (self.speed > 0.0)
        with np.errstate(over="ignore"):  # at next to no speed it never comes back
            under_way = np.where(moves, length / np.where(moves, self.speed, 1.0), np.where(length > 0.0, np.inf, 0.0))
        around = under_way + len(order) * np.asarray(self.pause)
        return np.where(around > 0.0, around, np.inf)

    def _place(self, number: Ints) -> tuple[Array, Array]:
        """Places of the waypoints `(N, 1)`; for a number beyond the last, that of the last."""
        points = np.asarray(self.waypoints)
        index = np.minimum(number, points.shape[1] - 1)
        rows = np.arange(len(points))[:, None]
        return points[rows, index, 0], points[rows, index, 1]

    def _count(self) -> int:
        return int(np.shape(self.waypoints)[1])

    def _is_over(self, number: Ints) -> npt.NDArray[np.bool_]:
        """Whether the last waypoint was passed."""
        return number >= self._count()

    @abc.abstractmethod
    def _after(self, number: Ints, way: Ints) -> tuple[Ints, Ints]:
        """The waypoint after one, and the way through the list from there."""

    @abc.abstractmethod
    def _around(self) -> list[int]:
        """The waypoints of one round, in order; none if it does not come back."""


@attrs.frozen(kw_only=True)
class Waypoints(_Route):
    """Goes from waypoint to waypoint, once, and stays at the last.

    An obstacle without a pose starts at the first one.
    """

    def _after(self, number: Ints, way: Ints) -> tuple[Ints, Ints]:
        return np.minimum(number + 1, self._count()), way

    def _around(self) -> list[int]:
        return []


@attrs.frozen(kw_only=True)
class Loop(_Route):
    """Goes from waypoint to waypoint, and from the last to the first, round and round.

    An obstacle without a pose starts at the first one.
    """

    def _after(self, number: Ints, way: Ints) -> tuple[Ints, Ints]:
        return (number + 1) % self._count(), way

    def _around(self) -> list[int]:
        return list(range(self._count()))


@attrs.frozen(kw_only=True)
class Oscillate(_Route):
    """Goes from waypoint to waypoint, at the last turns back, at the first again, there and back.

    An obstacle without a pose starts at the first one.
    """

    def _after(self, number: Ints, way: Ints) -> tuple[Ints, Ints]:
        last = self._count() - 1
        way = np.where(number >= last, -1, np.where(number <= 0, 1, way))
        return np.clip(number + way, 0, last), way

    def _around(self) -> list[int]:
        count = self._count()
        return [*range(count), *range(count - 2, 0, -1)]
