"""What noise of the body's motion needs: the motion that wheels make by their travel, and travels for a motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Context, State
from amorsim.core.errors import ComponentError

__all__ = ["acts_on_wheels", "motion_squares", "per_interval", "slide_along", "start_motion", "with_motion_error"]

Array = npt.NDArray[np.float64]


def per_interval(interval: float | None, elapsed: Array) -> Array:
    """What a variance per step is multiplied by `(N, 1)` in a step of `elapsed` [s], if it is meant for `interval`.

    The squares of way and turn in it fall with the square of the step, the number of steps rises with its
    inverse: the share of a step must rise with the inverse too, for all of them to add up to the same.
    """
    if interval is None:
        return np.ones_like(elapsed)
    return np.where(elapsed > 0.0, interval / np.where(elapsed > 0.0, elapsed, 1.0), 1.0)


def start_motion(element: str, context: Context) -> State:
    """How the body's motion comes of the wheels' travel: the nominal track of a pair of wheels, or their Jacobian.

    Nothing for a drive that steers: its wheels cannot turn the body by what they travel, and so the body slides.

    Raises
    ------
    ComponentError
        For values that are no travels of wheels, and for a drive that steers and has parts.
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
    """The slide `(N, 3)` of bodies that go `way` farther and `aside` to the left of their way, and turn by `turn` more.

    All are `(N, 1)`. The way is that of `motion` `(N, 3)`; ahead, where it goes nowhere.
    """
    size = np.sqrt(motion[:, :1] ** 2 + motion[:, 1:2] ** 2)
    goes = size > 0.0
    over = np.where(goes, size, 1.0)
    c, s = np.where(goes, motion[:, :1] / over, 1.0), np.where(goes, motion[:, 1:2] / over, 0.0)
    return np.concatenate((c * way - s * aside, s * way + c * aside, turn), axis=1)


def motion_squares(travel: Array, state: State) -> tuple[Array, Array]:
    """The squares of the way [m^2] and of the turn [rad^2], `(N, 1)` each, that the body makes of travels `(N, r)`."""
    if "track" in state:
        left, right = travel[:, :1], travel[:, 1:]
        return (0.5 * (left + right)) ** 2, ((right - left) / state["track"]) ** 2
    ahead, aside, turn = (_along(state["jacobian"], axis, travel) for axis in range(3))
    return ahead**2 + aside**2, turn**2


def with_motion_error(travel: Array, way: Array, turn: Array, state: State) -> Array:
    """Travels `(N, r)` [m] of wheels whose body goes `way` [m] farther and turns by `turn` [rad] more, `(N, 1)` each.

    Farther in the direction in which it goes; ahead, where it goes nowhere. Where both are 0 the travels keep their
    bits.
    """
    if "track" in state:
        half = 0.5 * state["track"] * turn
        # Taking +0.0 away keeps even the sign of a zero, which adding it would not.
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
        # The least travels that make the motion: its parts are made by wheels that do nothing for one another.
        more = more + row / _summed(row * row) * part
    return travel - (0.0 - more)


def _along(jacobian: Array, axis: int, travel: Array) -> Array:
    return _summed(jacobian[:, axis] * travel)


def _summed(parts: Array) -> Array:
    """Sums over the wheels `(N, 1)`, in one order for every row."""
    total = parts[:, :1]
    for i in range(1, parts.shape[1]):
        total = total + parts[:, i : i + 1]
    return total
