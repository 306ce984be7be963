"""Arguments of public functions, checked: the error names the argument, what was given, and what is expected."""

from __future__ import annotations

import collections.abc
import functools
import inspect
import math
import os
import sys
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal, TypeGuard, TypeVar, cast

import numpy as np
import numpy.typing as npt

from amorsim.array_types import Array
from amorsim.core.error_text import in_words
from amorsim.core.parameters import ParameterError

__all__ = [
    "check_kind",
    "check_text",
    "checked",
    "is_list",
    "is_numeric",
    "is_real",
    "numbers",
    "path_of",
    "real",
    "texts",
    "whole",
]

F = TypeVar("F", bound=Callable[..., Any])
Test = Callable[[Any], bool]

_MOST = 1000  # elements of a list that are looked at


def checked(function: F) -> F:
    """Refuse arguments of a public function that do not fit its annotations, before it begins.

    On a class it checks those of its constructor. A `float` is a number, also one of NumPy's; an `int` is whole; an
    array is anything that makes one of numbers. ``Annotated[int, "a number of threads >= 1"]`` has words for what is
    expected. What an annotation cannot express, such as a bound, the function checks itself. It costs some microseconds
    a call, so it is for what scripts call, not for what a step calls.

    Raises
    ------
    ParameterError
        From the function, with the argument's name, what was given and what is expected.
    """
    if inspect.isclass(function):
        setattr(function, "__init__", _checked(function.__init__, function.__module__))  # noqa: B010 - mypy forbids both
        return cast(F, function)
    return cast(F, _checked(function, function.__module__))


def _checked(function: Callable[..., Any], module: str) -> Callable[..., Any]:
    parameters = inspect.signature(function).parameters
    in_order = [
        name for name, one in parameters.items() if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)
    ]
    kinds: dict[str, Any] = {}
    tests: dict[str, Test] = {}

    @functools.wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        if not tests:  # at the first call, for a module may name classes that it imports later
            kinds.update({name: _kind_of(one, module) for name, one in parameters.items()})
            tests.update({name: _test_of(kind) for name, kind in kinds.items()})
        # What is given too often or not at all the function refuses by itself.
        for name, value in (*zip(in_order, args, strict=False), *kwargs.items()):
            if name in tests and not tests[name](value):
                as_list = f", as [{in_words(value)}]" if isinstance(value, str) and tests[name]([value]) else ""
                raise ParameterError(name, f"expected {_in_words(kinds[name])}{as_list}, got {in_words(value)}")
        return function(*args, **kwargs)

    return call


def _kind_of(parameter: inspect.Parameter, module: str) -> Any:
    """The type of a parameter's annotation; anything, if it has none or names something that is not imported."""
    if parameter.annotation is parameter.empty or parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
        return Any
    if not isinstance(parameter.annotation, str):
        return parameter.annotation
    try:
        return eval(parameter.annotation, vars(sys.modules[module]))
    except NameError:
        return Any


def _test_of(kind: Any) -> Test:
    """The test whether a value fits an annotation, made once for all calls."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if kind is Any or kind is object or isinstance(kind, TypeVar):
        return lambda _: True
    if kind is None or kind is types.NoneType:
        return lambda value: value is None
    if _is_array(kind):
        return is_numeric
    if origin in (typing.Union, types.UnionType):
        tests = [_test_of(each) for each in inner]
        return lambda value: any(test(value) for test in tests)
    if origin is Literal:
        return lambda value: isinstance(value, (str, int)) and value in inner
    if origin is Annotated:
        return _test_of(inner[0])
    if kind is float:
        return _is_number
    if kind is int:
        return lambda value: isinstance(value, (int, np.integer)) and not isinstance(value, bool)
    if kind is bool:
        return lambda value: isinstance(value, (bool, np.bool_))
    if origin is tuple and inner[-1] is not ...:
        parts = [_test_of(each) for each in inner]
        return lambda value: _are_fitting(value, parts)
    if origin in (tuple, collections.abc.Sequence, collections.abc.Iterable, collections.abc.Collection, list):
        element, is_once = _test_of(inner[0]), origin is collections.abc.Iterable
        return lambda value: _is_list_of(value, element, again=not is_once)
    if origin in (collections.abc.Mapping, dict):
        first, second = map(_test_of, inner)
        return lambda value: (
            isinstance(value, origin)
            and all(first(key) and second(each) for _, (key, each) in zip(range(_MOST), value.items(), strict=False))
        )
    if origin is collections.abc.Callable:
        return callable
    if origin is type:
        return inspect.isclass
    wanted = origin or kind
    if not inspect.isclass(wanted) or getattr(wanted, "_is_protocol", False):
        return lambda _: True
    return lambda value: isinstance(value, wanted)


def _is_array(kind: Any) -> bool:
    """Whether an annotation is for an array of numbers; that of anything, ``NDArray[Any]``, is a class as others."""
    if typing.get_origin(kind) is np.ndarray:
        return bool(typing.get_args(kind)[1] != np.dtype[Any])
    return bool(kind == npt.ArrayLike)


def _is_number(value: object) -> bool:
    """Whether it is a number that a float can hold, also nan or infinite."""
    return is_real(value) or (isinstance(value, (float, np.floating)) and not math.isfinite(value))


def is_numeric(value: object) -> bool:
    """Whether it is a number or an array of numbers, or makes one."""
    try:
        return np.asarray(value).dtype.kind in "biuf"
    except (TypeError, ValueError, OverflowError):
        return False


def _is_list_of(value: object, test: Test, *, again: bool) -> bool:
    """Whether it is a list or another iterable, with `again` one that can be iterated twice; a text is none.

    The first elements must pass a test, unless it can be gone through only once.
    """
    if not is_list(value):
        return False
    if not isinstance(value, collections.abc.Sized):
        return not again
    return all(test(each) for _, each in zip(range(_MOST), value, strict=False))


def is_list(value: object) -> TypeGuard[Iterable[Any]]:
    """Whether it is a list or another iterable, but not a text or a table."""
    if isinstance(value, np.ndarray):
        return value.ndim > 0
    return isinstance(value, Iterable) and not isinstance(value, (str, bytes, Mapping))


def _are_fitting(value: object, tests: Sequence[Test]) -> bool:
    """Whether it is a list of so many elements, each of which passes its test."""
    if not isinstance(value, (collections.abc.Sequence, np.ndarray)) or isinstance(value, (str, bytes)):
        return False
    return (
        np.shape(value)[:1] == (len(tests),)
        if isinstance(value, np.ndarray)
        else len(value) == len(tests) and all(test(each) for test, each in zip(tests, value, strict=True))
    )


_WORDS = {
    np.ndarray: "an array",
    float: "a number",
    int: "a whole number",
    str: "a text",
    bool: "True or False",
    None: "None",
}


def _in_words(kind: Any) -> str:
    """An annotation in words."""
    origin, inner = typing.get_origin(kind), typing.get_args(kind)
    if kind in (types.NoneType, None):
        return "None"
    if _is_array(kind):
        return "an array of numbers"
    if origin is Annotated:
        return str(inner[1])
    if origin in (typing.Union, types.UnionType):
        *most, last = dict.fromkeys(map(_in_words, inner))
        return f"{', '.join(most)} or {last}" if most else last
    if origin is Literal:
        return " or ".join(map(repr, inner))
    if origin is tuple and inner[-1] is not ...:
        return f"({', '.join(map(_in_words, inner))})"
    if origin in (tuple, list, collections.abc.Sequence, collections.abc.Iterable, collections.abc.Collection):
        return f"a list, each {_in_words(inner[0])}"
    if origin in (collections.abc.Mapping, dict):
        return f"a table from {_in_words(inner[0])} to {_in_words(inner[1])}"
    if origin is collections.abc.Callable:
        return "a function"
    kind = origin or kind
    if isinstance(kind, type) and issubclass(kind, os.PathLike):
        return "a path"
    return _WORDS.get(kind) or f"a {getattr(kind, '__name__', kind)}"


def path_of(given: object, name: str, expected: str = "a path, as a text or a pathlib.Path") -> Path:
    """The path that was given; a `ParameterError` for another value, an empty text, or a null character in it."""
    text = os.fspath(given) if isinstance(given, os.PathLike) else given
    if not isinstance(text, str) or not text:
        raise ParameterError(name, f"expected {expected}, got {in_words(given)}")
    if "\0" in text:
        raise ParameterError(name, f"expected {expected}, without null characters, got {in_words(given)}")
    return Path(text)


def check_kind(given: object, kind: type, name: str, expected: str) -> None:
    """Raise a `ParameterError` for a value that is not of a class; `expected` is the words for it, with an example."""
    if not isinstance(given, kind):
        raise ParameterError(name, f"expected {expected}, got {in_words(given)}")


def check_text(given: object, name: str, expected: str = "a text") -> None:
    """Raise a `ParameterError` unless this is a text."""
    check_kind(given, str, name, expected)


def texts(given: object, name: str, expected: str) -> tuple[str, ...]:
    """The texts of a list; `expected` names them, in the plural. A single text is refused as a mistake."""
    if isinstance(given, str):
        raise ParameterError(name, f"expected a list of {expected}, as [{given!r}], got a text")
    if not is_list(given):
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
    except (TypeError, ValueError, OverflowError):
        raise ParameterError(name, f"expected numbers of the shape {words}, got {in_words(given)}") from None
    fits = len(array.shape) == len(shape) and all(
        isinstance(wanted, str) or wanted == size for wanted, size in zip(shape, array.shape, strict=True)
    )
    if not fits:
        raise ParameterError(name, f"expected numbers of the shape {words}, got those of {array.shape}")
    return array
