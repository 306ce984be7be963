"""Doors that open and close on a timetable: on a hinge, or sliding."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np

from amorsim.array_types import Array, Bools, Ints
from amorsim.contracts import Context, Draws, Motion, State, View, parameter
from amorsim.core.parameters import ParameterError
from amorsim.core.poses import wrap_angle
from amorsim.motions.ways import blocked_for, displacement

__all__ = ["SlidingDoor", "SwingDoor"]


@attrs.frozen(kw_only=True)
class _Door(Motion):
    """Decides when the door should be open; subclasses decide how it moves."""

    timetable: tuple[tuple[float, float], ...] = parameter(
        unit="s", help="when it opens and when it closes again, [[OPENS, CLOSES], ...], in order"
    )
    period: float | None = parameter(None, unit="s", gt=0, help="after which the timetable repeats; none: never")
    blocked: str = parameter(
        "wait",
        choices=("wait", "skip"),
        help="what it does when blocked: press on until the way is free, or go back and leave this time out",
    )
    patience: float = parameter(1.0, unit="s", ge=0, help="how long it is blocked before it goes back")

    def __attrs_post_init__(self) -> None:
        times = list(itertools.chain.from_iterable(self.timetable))
        if not times or times[0] < 0.0 or any(b <= a for a, b in itertools.pairwise(times)):
            raise ParameterError(
                "timetable", f"expected [[OPENS, CLOSES], ...] with times that increase from 0 s on, got {times}"
            )
        if self.period is not None and times[-1] - times[0] >= self.period:
            raise ParameterError(
                "period",
                f"expected more than the {times[-1] - times[0]:g} s from the first opening to the last closing, "
                f"got {self.period!r}",
            )

    def start(self, context: Context) -> State:
        """The initial pose is the closed one; no change of the timetable has been skipped."""
        rows = context.rows
        return {
            "closed": context.pose.copy(),
            "blocked": np.zeros((rows, 1)),
            "left_out": np.full((rows, 1), -1, dtype=np.int64),
        }

    def _wants_open(self, view: View, dt: float, state: State) -> Bools:
        """Whether each should be open now `(N, 1)`; a door that gives up reverses until the timetable's next change."""
        changes = self._changes(np.asarray(view.tick * dt, dtype=np.float64))
        if self.blocked == "skip":
            waited = blocked_for(view, dt, state)
            gives_up = (view.free < 1.0) & (waited >= self.patience - 1e-9) & (changes > 0)
            state["left_out"] = np.where(gives_up, changes, state["left_out"])
        wants = changes % 2 == 1
        return np.asarray(np.where(state["left_out"] == changes, ~wants, wants))

    def _changes(self, time: Array) -> Ints:
        """Number of timetable changes due by a time [s] `(N, 1)`; odd while the door should be open."""
        times = np.asarray(self.timetable).reshape(len(time), -1)
        # A time that is missed only by rounding counts as reached.
        time = time + 1e-9
        rounds = np.zeros_like(time)
        if self.period is not None:
            since = time - times[:, :1]
            rounds = np.maximum(np.floor(since / self.period), 0.0)
            time = time - rounds * self.period
        passed = np.zeros(time.shape, dtype=np.int64)
        for i in range(times.shape[1]):
            passed += time >= times[:, i : i + 1]
        return np.asarray(passed + times.shape[1] * rounds.astype(np.int64))


@attrs.frozen(kw_only=True)
class SwingDoor(_Door):
    """A door that turns about its hinge, the origin of the obstacle's frame; its pose is where it is closed.

    Its leaf is a shape next to the origin, such as ``{ rectangle = [0.9, 0.04], x = 0.46 }``.
    """

    angle: float = parameter(
        math.pi / 2, unit="rad", gt=-math.pi, lt=math.pi, help="how far it opens; anticlockwise if > 0"
    )
    rate: float = parameter(1.0, unit="rad/s", gt=0, help="how fast it turns")

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """A turn from its true angle towards the wanted one."""
        wanted = state["closed"][:, 2:] + np.where(self._wants_open(view, dt, state), self.angle, 0.0)
        turn = wrap_angle(wanted - view.body_pose[:, 2:])
        most = self.rate * dt
        turn = np.clip(turn, -most, most)
        return np.concatenate((np.zeros((view.rows, 2)), turn), axis=1)


@attrs.frozen(kw_only=True)
class SlidingDoor(_Door):
    """A door that slides along a straight line; its pose is where it is closed."""

    way: tuple[float, float] = parameter(
        (1.0, 0.0), unit="m", frame="body", help="how far it opens, ahead and to the left of where it looks"
    )
    speed: float = parameter(0.5, unit="m/s", gt=0, help="how fast it slides")

    def propose(self, view: View, dt: float, state: State, draws: Draws) -> Array:
        """A way from its true place towards the wanted one."""
        closed = state["closed"]
        c, s = np.cos(closed[:, 2:]), np.sin(closed[:, 2:])
        way = np.asarray(self.way)
        ahead, left = way[:, :1], way[:, 1:]
        is_open = self._wants_open(view, dt, state)
        dx = closed[:, :1] + np.where(is_open, c * ahead - s * left, 0.0) - view.body_pose[:, :1]
        dy = closed[:, 1:2] + np.where(is_open, s * ahead + c * left, 0.0) - view.body_pose[:, 1:2]
        distance = np.sqrt(dx * dx + dy * dy)
        far = self.speed * dt
        share = np.where(distance > far, far / np.where(distance > far, distance, 1.0), 1.0)
        return displacement(view, share * dx, share * dy, np.zeros((view.rows, 1)))
