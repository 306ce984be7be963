"""Shared by noise of the body's motion: the motion that wheel travels make, and the travels that make a motion."""

from __future__ import annotations

from typing import Any

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Context, State
from amorsim.core.errors import ComponentError

__all__ = ["acts_on_wheels", "motion_squares", "per_interval", "slide_along", "start_motion", "with_motion_error"]


def per_interval(interval: float | None, elapsed: Array) -> Array:
    """Factor `(N, 1)` on a variance per step, for a step of `elapsed` [s] and numbers meant for steps of `interval`.

    The squares of way and turn fall with the square of the step, and the number of steps rises with its inverse.
    The factor must therefore rise with the inverse too, so that all steps add up to the same variance.
    """
    if interval is None:
        return np.ones_like(elapsed)
    return np.where(elapsed > 0.0, interval / np.where(elapsed > 0.0, elapsed, 1.0), 1.0)


def start_motion(element: str, context: Context) -> State:
    """How wheel travel moves the body: the nominal track of a pair of wheels, or the wheels' Jacobian.

    Empty for a drive that steers: its wheels cannot turn the body by their travel, so the body slides.

    Raises
    ------
    ComponentError
        If the values are not travels of wheels, or the drive steers and has parts.
    """
    drive: Any = context.robot.drive
    rolling = sum(joint.rolls for joint in drive.joints)
    if rolling != context.size:
        raise ComponentError(
            f"{element}: expected the ground of a robot or a zone, with {rolling} joints that roll, got "
            f"{context.size} values"
        )
    offered = getattr(drive, "jacobian", None)
    if offered is None and drive.parts:
        raise ComponentError(
            f"{element}: expected a drive without parts, or one whose wheels turn the body by what they travel, got "
            f"{type(drive).__name__}; take diffusion, slip or bump, which act wheel by wheel"
        )
    if offered is None:
        return {}
    if context.size == 2:
        return {"track": np.array(np.broadcast_to(drive.track, (context.rows, 1)), dtype=np.float64)}
    at = np.zeros((context.rows, len(drive.joints)))
    found = offered(at, at)
    return {"jacobian": np.array(np.broadcast_to(found, (context.rows, 3, context.size)), dtype=np.float64)}


def acts_on_wheels(state: State) -> bool:
    """Whether errors of the motion go into the wheels' travel; if not, the body slides."""
    return bool(state)


def slide_along(motion: Array, way: Array, aside: Array, turn: Array) -> Array:
    """Slide `(N, 3)` of bodies that go `way` farther along their way, `aside` to its left, and turn by `turn` more.

    All are `(N, 1)`. The way is the direction of `motion` `(N, 3)`, or ahead if the body stands.
    """
    size = np.sqrt(motion[:, :1] ** 2 + motion[:, 1:2] ** 2)
    goes = size > 0.0
    over = np.where(goes, size, 1.0)
    c, s = np.where(goes, motion[:, :1] / over, 1.0), np.where(goes, motion[:, 1:2] / over, 0.0)
    return np.concatenate((c * way - s * aside, s * way + c * aside, turn), axis=1)


def motion_squares(travel: Array, state: State) -> tuple[Array, Array]:
    """Squares of the body's way [m^2] and turn [rad^2], `(N, 1)` each, for wheel travels `(N, r)`."""
    if "track" in state:
        left, right = travel[:, :1], travel[:, 1:]
        return (0.5 * (left + right)) ** 2, ((right - left) / state["track"]) ** 2
    ahead, aside, turn = (_along(state["jacobian"], axis, travel) for axis in range(3))
    return ahead**2 + aside**2, turn**2


def with_motion_error(travel: Array, way: Array, turn: Array, state: State) -> Array:
    """Travels `(N, r)` [m] of wheels that move the body `way` [m] farther and turn it by `turn` [rad] more, `(N, 1)`.

    The body goes farther in its direction of motion, or ahead if it stands. Where `way` and `turn` are 0 the travels
    keep their bits.
    """
    if "track" in state:
        half = 0.5 * state["track"] * turn
        # Subtracting +0.0 keeps the sign of a zero; adding it would not.
        return travel - (0.0 - np.concatenate((way - half, way + half), axis=1))
    jacobian = state["jacobian"]
    ahead, aside = _along(jacobian, 0, travel), _along(jacobian, 1, travel)
    size = np.sqrt(ahead**2 + aside**2)
    goes = size > 0.0
    over = np.where(goes, size, 1.0)
    parts = (np.where(goes, ahead / over, 1.0) * way, np.where(goes, aside / over, 0.0) * way, turn)
    more = np.zeros_like(travel)
    for axis, part in enumerate(parts):
        row = jacobian[:, axis]
        # The smallest travels that make the motion: the wheels of one part add nothing to the others.
        more = more + row / _summed(row * row) * part
    return travel - (0.0 - more)


def _along(jacobian: Array, axis: int, travel: Array) -> Array:
    return _summed(jacobian[:, axis] * travel)


def _summed(parts: Array) -> Array:
    """Sums over the wheels `(N, 1)`, in the same order for every row."""
    total = parts[:, :1]
    for i in range(1, parts.shape[1]):
        total = total + parts[:, i : i + 1]
    return total
