"""Errors of components: messages that name the component, its robot or obstacle, and the time."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from typing import Any, Concatenate, NoReturn, ParamSpec, Protocol, TypeVar

import numpy as np

from amorsim.array_types import Array
from amorsim.contracts import Controller
from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import AmorsimError, ComponentError, ControllerError
from amorsim.kernels.number_checks import all_finite
from amorsim.simulation.row_clock import RowClock

__all__ = ["ErrorContext", "array_problem", "is_finite", "of_drive"]

_FLOAT = np.dtype(np.float64)
_NAMED = 3  # robots in a message


class ErrorContext:
    """The robots or obstacles that a group's components belong to, and their time.

    Parameters
    ----------
    kind
        ``"robot"`` or ``"obstacle"``.
    names
        The name of each row.
    row_clock
        The clock of the group.
    """

    def __init__(self, kind: str, names: Sequence[str], row_clock: RowClock) -> None:
        self._kind = kind
        self._names = names
        self.row_clock = row_clock

    def blame(self, what: str, component: Any, error: BaseException) -> NoReturn:
        """Raise a component's exception as an error that names the robot or obstacle and the time.

        Errors of amorsim are raised unchanged: they name them already.

        Parameters
        ----------
        what
            The component's role in its robots: ``"estimator 'ekf'"``.
        """
        if isinstance(error, AmorsimError):
            raise error
        message = f"{_named(what, component)} of {self._all()} at {self._time()} raised {error_in_words(error)}"
        if isinstance(component, Controller):
            names = set(self._names)
            raise ControllerError(message, robot=names.pop() if len(names) == 1 else "") from error
        raise ComponentError(message) from error

    def blame_start(self, what: str, component: Any, error: BaseException) -> NoReturn:
        """Raise the exception of a component's `start`, as `blame` does.

        A `ComponentError` of the component's own gets the names too: no `start` knows them.
        """
        if type(error) is ComponentError:
            raise ComponentError(f"{self._all()}, {what}: {error}") from error
        self.blame(what, component, error)

    def wrong(self, what: str, component: Any, problem: str) -> ComponentError:
        """The error for an invalid return value; `problem` is what is wrong, and what to return."""
        return ComponentError(f"{_named(what, component)} of {self._all()} at {self._time()}: {problem}")

    def not_finite(self, what: str, component: Any, numbers: str, values: Array) -> ComponentError:
        """The error for numbers `(N, ...)` with nan or inf in some row; `numbers` is what they are, in words."""
        rows = np.isfinite(values.reshape(len(values), -1)).all(axis=1)
        row = int(np.flatnonzero(~rows)[0])
        return ComponentError(
            f"{_named(what, component)} of {self.row(row)}: expected finite numbers for {numbers}, got "
            f"{values[row].tolist()}"
        )

    def row(self, row: int) -> str:
        """The robot of a row, its replica if that is not the first, and the time."""
        row_clock = self.row_clock
        replica, tick = int(row_clock.replica[row]), int(row_clock.tick[row, 0])
        of = f" in replica {replica}" if replica else ""
        return f"{self._kind} {self._names[row]!r}{of} at tick {tick} ({tick * row_clock.dt:g} s)"

    def _all(self) -> str:
        names = sorted(set(self._names))
        shown = ", ".join(repr(name) for name in names[:_NAMED])
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        return f"{self._kind}{'s' if len(names) > 1 else ''} {shown}{more}"

    def _time(self) -> str:
        first, last = float(self.row_clock.time.min()), float(self.row_clock.time.max())
        return f"{first:g} s" if first == last else f"{first:g} to {last:g} s"


def _named(what: str, component: Any) -> str:
    """A component as messages name it, with its class."""
    return f"{what} ({type(component).__name__})"


def array_problem(array: Any, what: str, shape: tuple[int, ...], by: str = "") -> str:
    """The fault of a value, returned `by`, that must be an array of numbers of a shape; empty if there is none."""
    if isinstance(array, np.ndarray) and array.shape == shape and array.dtype is _FLOAT:
        return ""
    source = f" from {by}" if by else ""
    if not isinstance(array, np.ndarray):
        return f"expected {what} of the shape {shape}{source}, got a {type(array).__name__}"
    if array.shape != shape:
        return f"expected {what} of the shape {shape}{source}, got the shape {array.shape}"
    if array.dtype != np.float64:
        return f"expected {what} of the type float64{source}, got {array.dtype}; .astype(np.float64) makes it so"
    return ""


def is_finite(array: Array) -> bool:
    """Whether all numbers are finite."""
    return all_finite(np.asarray(array, dtype=np.float64).ravel())


class _HasDrive(Protocol):
    drive: Any
    whose: ErrorContext


G = TypeVar("G", bound=_HasDrive)
P = ParamSpec("P")
R = TypeVar("R")


def of_drive(method: Callable[Concatenate[G, P], R]) -> Callable[Concatenate[G, P], R]:
    """Decorates a group's method that calls its drive: exceptions are reported as the drive's."""

    @functools.wraps(method)
    def asked(group: G, /, *args: P.args, **kwargs: P.kwargs) -> R:
        try:
            return method(group, *args, **kwargs)
        except RAISED as error:
            group.whose.blame("drive", group.drive, error)

    return asked
