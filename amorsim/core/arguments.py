"""Arguments of public functions, checked: the error names the argument, what was given, and what is expected."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeGuard

import numpy as np
import numpy.typing as npt

from amorsim.core.parameters import ParameterError
from amorsim.core.trouble import in_words

__all__ = ["check_kind", "check_text", "is_real", "numbers", "path_of", "real", "texts", "whole"]

Array = npt.NDArray[np.float64]


def path_of(given: object, name: str, expected: str = "a path, as a text or a pathlib.Path") -> Path:
    """The path that was given; a `ParameterError` for what is none, as an empty text or one with a null character."""
    text = os.fspath(given) if isinstance(given, os.PathLike) else given
    if not isinstance(text, str) or not text:
        raise ParameterError(name, f"expected {expected}, got {in_words(given)}")
    if "\0" in text:
        raise ParameterError(name, f"expected {expected}, without null characters, got {in_words(given)}")
    return Path(text)


def check_kind(given: object, kind: type, name: str, expected: str) -> None:
    """Raise a `ParameterError` for what is not of a class; `expected` says what is, with an example."""
    if not isinstance(given, kind):
        raise ParameterError(name, f"expected {expected}, got {in_words(given)}")


def check_text(given: object, name: str, expected: str = "a text") -> None:
    """Raise a `ParameterError` for what is no text."""
    check_kind(given, str, name, expected)


def texts(given: object, name: str, expected: str) -> tuple[str, ...]:
    """The texts of a list; `expected` says what they are, in the plural. One text alone is a mistake for a list."""
    if isinstance(given, str):
        raise ParameterError(name, f"expected a list of {expected}, as [{given!r}], got a text")
    if not isinstance(given, Iterable) or isinstance(given, Mapping):
        raise ParameterError(name, f"expected a list of {expected}, got {in_words(given)}")
    found = tuple(given)
    for each in found:
        if not isinstance(each, str):
            raise ParameterError(name, f"expected a list of {expected}, each a text, got {in_words(each)} among them")
    return found


def whole(given: object, name: str, expected: str, least: int = 0) -> int:
    """A whole number as Python's, also of NumPy's; a `ParameterError` for others, and for those below `least`."""
    number = int(given) if isinstance(given, np.integer) else given
    if not isinstance(number, int) or isinstance(number, bool) or number < least:
        raise ParameterError(name, f"expected {expected}, got {in_words(given)}")
    return number


def is_real(given: object) -> TypeGuard[float]:
    """Whether something is a finite number, also one of NumPy's."""
    if not isinstance(given, (int, float, np.integer, np.floating)) or isinstance(given, bool):
        return False
    try:
        return math.isfinite(given)
    except OverflowError:  # an integer of hundreds of digits
        return False


def real(given: object, name: str, expected: str) -> float:
    """A finite number as Python's float; a `ParameterError` for others. Bounds are the caller's to check."""
    if is_real(given):
        return float(given)
    raise ParameterError(name, f"expected {expected}, got {in_words(given)}")


def numbers(given: Any, name: str, shape: tuple[int | str, ...]) -> Array:
    """Numbers as an array of float64; a `ParameterError` if they are none, or of another shape.

    A text in `shape` stands for any number of entries: ``("N", 3)``.
    """
    words = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})"
    try:
        array = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ParameterError(name, f"expected numbers of the shape {words}, got {in_words(given)}") from None
    fits = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or wanted == size for wanted, size in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ParameterError(name, f"expected numbers of the shape {words}, got those of {array.shape}")
    return array
