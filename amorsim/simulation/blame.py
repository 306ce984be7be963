"""Whose component failed, and when: the message for what it raised, or for what it must not return."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from typing import Any, Concatenate, NoReturn, ParamSpec, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from amorsim.contracts import Controller
from amorsim.core.errors import AmorsimError, ComponentError, ControllerError
from amorsim.core.trouble import RAISED, error_in_words
from amorsim.simulation.row_clock import RowClock

__all__ = ["Whose", "array_problem", "is_finite", "of_drive"]

_FEW = 16  # numbers
_NAMED = 3  # robots in a message


class Whose:
    """The robots or obstacles that a group's components belong to, and what time it is for them.

    Parameters
    ----------
    kind
        ``"robot"`` or ``"obstacle"``.
    names
        Of each row.
    row_clock
        Of the group.
    """

    def __init__(self, kind: str, names: Sequence[str], row_clock: RowClock) -> None:
        self._kind = kind
        self._names = names
        self._row_clock = row_clock

    def blame(self, what: str, component: Any, error: BaseException) -> NoReturn:
        """Raise what a component raised as an error that says whose it is, and when.

        Errors of amorsim are raised as they are: they say it already.

        Parameters
        ----------
        what
            What the component is to its robots: ``"estimator 'ekf'"``.
        """
        if isinstance(error, AmorsimError):
            raise error
        message = f"{_named(what, component)} of {self._all()} at {self._time()} raised {error_in_words(error)}"
        if isinstance(component, Controller):
            names = set(self._names)
            raise ControllerError(message, robot=names.pop() if len(names) == 1 else "") from error
        raise ComponentError(message) from error

    def wrong(self, what: str, component: Any, problem: str) -> ComponentError:
        """The error for something that a component must not return; `problem` says what it is, and what to return."""
        return ComponentError(f"{_named(what, component)} of {self._all()} at {self._time()}: {problem}")

    def not_finite(self, what: str, component: Any, told: str, values: npt.NDArray[np.float64]) -> ComponentError:
        """The error for numbers `(N, ...)` of which some row has nan or inf; `told` is what they are."""
        rows = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        row = int(np.flatnonzero(~rows)[0])
        return ComponentError(
            f"{_named(what, component)} of {self.row(row)}: expected finite numbers for {told}, got "
            f"{values[row].tolist()}"
        )

    def row(self, row: int) -> str:
        """The robot of a row, its replica where that is not the first, and when."""
        row_clock = self._row_clock
        replica, tick = int(row_clock.replica[row]), int(row_clock.tick[row, 0])
        of = f" in replica {replica}" if replica else ""
        return f"{self._kind} {self._names[row]!r}{of} at tick {tick} ({tick * row_clock.dt:g} s)"

    def _all(self) -> str:
        names = sorted(set(self._names))
        shown = ", ".join(repr(name) for name in names[:_NAMED])
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        return f"{self._kind}{'s' if len(names) > 1 else ''} {shown}{more}"

    def _time(self) -> str:
        first, last = float(self._row_clock.time.min()), float(self._row_clock.time.max())
        return f"{first:g} s" if first == last else f"{first:g} to {last:g} s"


def _named(what: str, component: Any) -> str:
    """A component as messages call it; a class is told where it is not the whole of what is told."""
    return f"{what} ({type(component).__name__})"


def array_problem(array: Any, what: str, shape: tuple[int, ...], by: str = "") -> str:
    """What is wrong with something, returned `by`, that was to be an array of numbers of a shape; or nothing."""
    source = f" from {by}" if by else ""
    if not isinstance(array, np.ndarray):
        return f"expected {what} of the shape {shape}{source}, got a {type(array).__name__}"
    if array.shape != shape:
        return f"expected {what} of the shape {shape}{source}, got the shape {array.shape}"
    if array.dtype != np.float64:
        return f"expected {what} of the type float64{source}, got {array.dtype}; .astype(np.float64) makes it so"
    return ""


def is_finite(array: npt.NDArray[np.float64]) -> bool:
    """Whether there is neither nan nor inf among the numbers."""
    # NumPy takes longer to begin than a few numbers to add up; of finite ones the sum may be infinite all the same.
    if array.size <= _FEW and math.isfinite(sum(array.ravel().tolist())):
        return True
    return bool(np.isfinite(array).all())


class _HasDrive(Protocol):
    drive: Any
    whose: Whose


G = TypeVar("G", bound=_HasDrive)
P = ParamSpec("P")
R = TypeVar("R")


def of_drive(method: Callable[Concatenate[G, P], R]) -> Callable[Concatenate[G, P], R]:
    """A method of a group that asks its drive, and blames the drive for what is raised on the way."""

    @functools.wraps(method)
    def asked(group: G, /, *args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return method(group, *args, **kwargs)
        except RAISED as error:
            group.whose.blame("drive", group.drive, error)

    return asked
