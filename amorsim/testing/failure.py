"""The message of a failed check."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import NoReturn

import numpy as np

from amorsim.core.error_text import RAISED, error_in_words
from amorsim.core.errors import ComponentError

__all__ = ["CheckError", "Who", "array_in_words"]


def array_in_words(found: object) -> str:
    """What was found in place of an expected array: ``"float32 (7,)"``, or the class of another value."""
    return f"{found.dtype} {found.shape}" if isinstance(found, np.ndarray) else type(found).__name__


class CheckError(ComponentError):
    """A check that a component fails; `check` is its name."""

    def __init__(self, who: str, check: str, message: str) -> None:
        self.check = check
        super().__init__(f"{who} fails the check {check!r}: {message}")


class Who:
    """The component that is tried, by kind and class; failures name it."""

    def __init__(self, kind: str, cls: type) -> None:
        self.kind = kind
        self.cls = cls

    def __str__(self) -> str:
        return f"{self.kind.replace('_', ' ')} {self.cls.__name__}"

    def fail(self, check: str, message: str) -> NoReturn:
        """Raise a `CheckError` of the named check."""
        raise CheckError(str(self), check, message)

    def require(self, holds: object, check: str, what: str, expected: object, found: object) -> None:
        """Fail unless something holds."""
        if not holds:
            self.fail(check, f"{what}: expected {expected}, found {found}")

    @contextlib.contextmanager
    def calling(self, method: str) -> Iterator[None]:
        """A block in which a failure names the method that raised."""
        try:
            yield
        except CheckError:
            raise
        except RAISED as error:
            if isinstance(error, ValueError) and "read-only" in str(error):
                self.fail("parameters", f"{method}: expected its parameters let alone, found it writing: {error}")
            try:
                self.fail("runs", f"{method}: expected it to return, found {error_in_words(error)}")
            except CheckError as failure:
                raise failure from error
