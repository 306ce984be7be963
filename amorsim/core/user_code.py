"""A user's code within a component: a plain function for one row, or a class with an object for each row."""

from __future__ import annotations

import functools
import inspect
import os
import warnings
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import attrs
import numpy as np
import numpy.typing as npt

from amorsim.core.error_text import RAISED, error_in_words, in_words
from amorsim.core.errors import AmorsimError
from amorsim.core.parameters import parameter

__all__ = ["UserCode", "go_back", "present_folder"]

Objects = npt.NDArray[Any]


@attrs.frozen(kw_only=True)
class UserCode:
    """Shared by all kinds of users' code: makes the objects, calls them, and reports failures.

    It also takes the place of a component in a user's file until that file is loaded.

    Parameters
    ----------
    source
        Where it comes from, for messages: ``"file.py:name"``.
    function
        The function or the class.
    options
        Names and values of its keyword arguments.
    """

    kind: ClassVar[str]  # of component, as messages call it
    signature: ClassVar[str] = ""  # of the method that a plain class must have: "velocity(self, obstacle)"

    source: str = parameter(static=True, help="where it comes from, as in file.py:name")
    function: Any = attrs.field()
    options: tuple[tuple[str, Any], ...] = attrs.field(default=())

    def failure(self, message: str, name: str) -> AmorsimError:
        """The exception of its kind for a failure with the robot or obstacle `name` (empty: not known)."""
        return AmorsimError(message)

    def idle(self) -> Any:
        """A function or class that does nothing, to read a scenario without running the user's code."""
        return _nothing

    def make_objects(
        self, rows: int, who: Callable[[int], str], made_with: Callable[[int], Mapping[str, Any]] | None = None
    ) -> dict[str, Objects]:
        """The state at the start: ``"objects"`` `(N,)`, one of the class for each row; empty for a function.

        `who` gives the name of a row's robot or obstacle for messages, `made_with` what its object gets in addition to
        the options. Raises the exception of `failure` if the code cannot be called, an object cannot be made, or it has
        not the method.
        """
        what = self.title
        if not callable(self.function):
            raise self.failure(f"{what}: expected a function or a class, got {in_words(self.function)}", "")
        if not inspect.isclass(self.function):
            return {}
        options = dict(self.options)
        objects = np.empty(rows, dtype=object)
        here = present_folder()
        for row in range(rows):
            try:
                objects[row] = self.function(**(made_with(row) if made_with else {}), **options)
            except RAISED as error:
                raise self.failure(
                    f"{what}: making its object for {who(row)} with the options {options} raised "
                    f"{error_in_words(error)}",
                    "",
                ) from error
            if not callable(getattr(objects[row], self._method, None)):
                raise self.failure(
                    f"{what}: the class {self.function.__name__} has no method {self.signature}",
                    "",
                )
        go_back(here, what)
        return {"objects": objects}

    def try_out(self) -> None:
        """Make an object of a class, as at a start; raises as `make_objects`."""
        self.make_objects(1, lambda _: "a try")

    @property
    def title(self) -> str:
        """Its name in messages: its kind and origin, or the name of a script's function."""
        return f"{self.kind} {self.source or getattr(self.function, '__name__', type(self.function).__name__)!r}"

    @property
    def _method(self) -> str:
        return self.signature.partition("(")[0]

    def asker(self, state: Mapping[str, Objects]) -> Callable[[int], Callable[..., Any]]:
        """Returns the function to call for a row: the method of its object, or the function with its options."""
        objects = state.get("objects")
        if objects is not None:
            made, method = objects, self._method
            return lambda row: getattr(made[row], method)
        call = functools.partial(self.function, **dict(self.options))
        return lambda _: call

    def raised(self, error: BaseException, who: str, time: float | None, name: str) -> AmorsimError:
        """The exception to raise for one that the user's code raised, at a time [s] if that is known."""
        when = "" if time is None else f" at {time:g} s"
        return self.failure(f"{self.title} of {who}{when} raised {error_in_words(error)}", name)


def _nothing(*_: Any, **__: Any) -> None:
    """Stop, or stand."""


def present_folder() -> str | None:
    """The working folder; None if it was removed."""
    try:
        return os.getcwd()  # noqa: PTH109 - as text
    except OSError:
        return None


def go_back(folder: str | None, who: str) -> None:
    """Make `folder` the working folder again, with a warning, if a user's code has changed it.

    Paths that a user gave are relative to it, including those of a run's files.
    """
    left_for = present_folder()
    if folder is None or left_for == folder:
        return
    os.chdir(folder)
    warnings.warn(
        f"{who} changed the working folder to {left_for or 'one that is gone'}; it is {folder} again, for paths are "
        "relative to it. Open files by their whole path, as in Path(__file__).parent / 'data.csv'",
        stacklevel=2,
    )
